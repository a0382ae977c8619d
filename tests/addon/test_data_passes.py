"""Data passes of what lets light through are Cycles': of a surface as opaque as the view layer's
Alpha Threshold whole, of what is behind thinner ones as often as Cycles' rays arrive there."""

import bpy
import numpy as np
import pytest
from parity.scene import Tree

import iwis
from iwis.iwis_addon.export import export_scene
from support.cycles_render import render_cycles

_NAMES = {
    "normal": ("Normal", "Normal"),
    "uv": ("UV", "UV"),
    "mist": ("Mist", "Mist"),
    "ambient_occlusion": ("AO", "Ambient Occlusion"),
    "vector": ("Vector", "Vector"),
    "position": ("Position", "Position"),
    "depth": ("Depth", "Depth"),
    "object_index": ("IndexOB", "Object Index"),
    "material_index": ("IndexMA", "Material Index"),
}
_FLAGS = [name if name != "depth" else "z" for name in _NAMES]
_BEHIND = 7  # the index of what is behind all
# Of 16 x 16 pixels with 256 samples, of which .5 see it at the worst: 4 standard errors.
_ATOL = 4.0 * 0.5 / 256.0


def _surface(tree, kind, alpha):
    grey, clear = (
        tree.made(f"ShaderNodeBsdf{name}", 0, {0: color})
        for name, color in (("Diffuse", (0.3, 0.3, 0.3)), ("Transparent", (1.0, 1.0, 1.0)))
    )
    through = 1.0 - alpha
    if kind == "tinted pane":
        color = (through, 0.5 * through, 0.25 * through)
        return tree.made("ShaderNodeBsdfTransparent", 0, {0: color})
    if kind == "textured":
        inputs = {0: tree.coordinates("Window"), "Scale": 5.0}
        alpha = tree.made("ShaderNodeTexNoise", 0, inputs)
        return tree.made("ShaderNodeMixShader", 0, {0: alpha, 1: clear, 2: grey})
    if kind == "plastic":
        inputs = {"Base Color": (0.8, 0.4, 0.2), "Alpha": alpha}
        return tree.made("ShaderNodeBsdfPrincipled", 0, inputs)
    if kind == "holdout":
        clear = tree.made("ShaderNodeHoldout", 0)
    return tree.made("ShaderNodeMixShader", 0, {0: alpha, 1: clear, 2: grey})


def _plane(height, turn, index, surface):
    bpy.ops.mesh.primitive_plane_add(size=8.0, location=(0.0, 0.0, height), rotation=turn)
    made = bpy.context.object
    made.pass_index = index
    for corner in made.data.uv_layers[0].data:
        corner.uv = index / 10.0, index / 20.0
    material = bpy.data.materials.new("M")
    material.pass_index = 10 * index
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    tree = Tree(material.node_tree)
    tree.surface(surface(tree))
    made.data.materials.append(material)
    for frame in (0, 2):  # at frame 1 where it is
        made.location[0] = 0.1 * index * (frame - 1)
        made.keyframe_insert("location", frame=frame)


@pytest.fixture
def build(scene, tmp_path):
    """build(kind, alpha, threshold, n): n such surfaces before an opaque one."""

    def made(kind, alpha, threshold, n=1):
        scene.render.resolution_x = scene.render.resolution_y = 16
        layer = scene.view_layers[0]
        layer.pass_alpha_threshold = threshold
        for name in _FLAGS:
            setattr(layer, f"use_pass_{name}", True)
        scene.world = bpy.data.worlds.new("W")
        scene.world.mist_settings.start, scene.world.mist_settings.depth = 0.0, 10.0
        scene.world.mist_settings.falloff = "LINEAR"
        scene.world.light_settings.distance = 0.5
        for k in range(n):
            _plane(2.0 - 0.5 * k, (0.5, 0.0, 0.0), k + 1, lambda tree: _surface(tree, kind, alpha))
        _plane(-2.0, (0.0, 0.5, 0.0), _BEHIND, lambda tree: _surface(tree, "mixture", 1.0))
        bpy.ops.object.camera_add(location=(0.0, 0.0, 6.0))
        scene.camera = bpy.context.object
        scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 0.2
        scene.frame_set(1)
        return scene

    return made


def _asked():
    return export_scene(bpy.context.evaluated_depsgraph_get(), warnings=[]).asked


def _both(scene, tmp_path, **settings):
    """name -> the mean of a pass, of IWIS and of Cycles."""
    own = {"max_samples": 256, "stop_rule": "FIXED"} | settings
    scene.render.engine = "IWIS"
    iwis.settings(scene, **own)
    ours = iwis.render(scene)
    cycles = render_cycles(scene, tmp_path, passes=(), samples=256, filter_width=1.5)
    means = {}
    for name, names in _NAMES.items():
        theirs = cycles[names[bpy.app.version >= (5, 0)]]
        own, theirs = (layer.reshape(256, -1).mean(axis=0) for layer in (ours[name], theirs))
        means[name] = np.sort(own), np.sort(theirs)  # files order UV and Vector otherwise
    return means


def _assert_alike(means, names, atol=_ATOL):
    for name in names:
        own, theirs = means[name]
        np.testing.assert_allclose(own, theirs, atol=atol, err_msg=name)


@pytest.mark.parametrize(
    ("kind", "alpha", "threshold", "n"),
    [
        ("mixture", 0.6, 0.5, 1),
        ("mixture", 0.4, 0.5, 1),
        ("mixture", 0.1, 0.0, 1),
        ("mixture", 0.9, 1.0, 1),
        ("mixture", 0.4, 0.5, 3),
        ("plastic", 0.4, 0.5, 2),
        ("textured", 0.5, 0.5, 2),
        ("tinted pane", 0.3, 0.5, 1),
        ("tinted pane", 0.1, 1.0, 3),
        ("holdout", 0.3, 0.5, 1),
    ],
)
def test_means_are_those_of_cycles(build, tmp_path, kind, alpha, threshold, n):
    means = _both(build(kind, alpha, threshold, n), tmp_path)
    _assert_alike(means, ("normal", "uv", "mist"))
    _assert_alike(means, ("vector",), atol=_ATOL * 100)  # pixels
    if n == 1:  # through three panes Cycles' own noise is larger
        _assert_alike(means, ("ambient_occlusion",))


@pytest.mark.parametrize(("alpha", "threshold"), [(0.6, 0.5), (0.4, 0.0), (0.3, 1.0)])
@pytest.mark.parametrize("pixel_filter", ["CENTER", "BLACKMAN_HARRIS"])
def test_depth_is_that_of_the_whole_surface(build, tmp_path, alpha, threshold, pixel_filter):
    """With the position and the indices. Behind a thin one Cycles tells of what its first ray
    meets, here: what most rays do."""
    scene = build("mixture", alpha, threshold)
    means = _both(scene, tmp_path, pixel_filter=pixel_filter)
    if alpha >= threshold:
        _assert_alike(means, ("depth", "position", "object_index", "material_index"), atol=1e-3)
    else:
        assert means["object_index"][0] == _BEHIND
        np.testing.assert_allclose(means["depth"][0], 8.0, atol=1e-3)


def test_one_ray_a_pixel(build, tmp_path):
    """The pixel filter Center has the same passes; fractional alpha is dithered in others."""
    means = _both(build("mixture", 0.4, 0.5, 2), tmp_path, pixel_filter="CENTER")
    _assert_alike(means, ("normal", "uv"))


def test_without_data_passes_nothing_is_looked_at_twice(build, tmp_path):
    """The exporter says so: what costs rays is only done where it is asked for."""
    layer = build("mixture", 0.4, 0.25).view_layers[0]
    assert _asked().solid == 0.25
    for name in _FLAGS:
        setattr(layer, f"use_pass_{name}", False)
    assert _asked().solid is None
