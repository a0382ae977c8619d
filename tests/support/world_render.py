"""What Cycles and IWIS see of the world in all directions, and worlds to look at."""

import itertools
import math

import bpy
import numpy as np
from mathutils import Euler

from iwis.core.light.environment import eval_environment_many, make_lookup
from iwis.iwis_addon.export.worlds.world import read_world
from support.cycles_render import render_cycles

# Asked for is 0.1 %. What is left: Cycles' smallest pixel filter moves a ray by up to .005 pixel,
# which is 3e-4 of a texel of a 16 pixel wide map, and texels differ by a factor of up to 2.
RELATIVE = 1e-3
HEIGHT, WIDTH = 8, 16
# The six axes, and two directions that have no axis, pole or seam in their middle.
_LOOKS = [
    (0.0, 0.0, 0.0),
    (math.pi, 0.0, 0.0),
    *((math.pi / 2, 0.0, quarter * math.pi / 2) for quarter in range(4)),
    (0.7, 0.4, 0.3),
    (2.1, 0.2, 2.5),
]
_PIXELS = 96
_HALF_ANGLE = math.radians(46.0)


def new_world(scene):
    """The node tree of a new world, empty; the scene gets a camera."""
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    camera.data.angle = 2.0 * _HALF_ANGLE
    scene.render.resolution_x = scene.render.resolution_y = _PIXELS
    scene.world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0):
        scene.world.use_nodes = True
    scene.world.node_tree.nodes.clear()
    return scene.world.node_tree


def pixel_directions() -> np.ndarray:
    """float32 (n, 3), unit: the world direction of each pixel of ``cycles_background``."""
    across = ((np.arange(_PIXELS) + 0.5) / _PIXELS * 2.0 - 1.0) * math.tan(_HALF_ANGLE)
    x, y = np.meshgrid(across, across)
    local = np.stack([x, y, -np.ones_like(x)], -1).reshape(-1, 3)
    local /= np.linalg.norm(local, axis=1, keepdims=True)
    world = [local @ np.array(Euler(look).to_matrix()).T for look in _LOOKS]
    return np.concatenate(world).astype(np.float32)


def cycles_background(scene, folder) -> np.ndarray:
    """float32 (n, 3): the world as eight perspective cameras see it, one ray a pixel's centre."""
    if scene.world is not None:
        scene.world.cycles.sampling_method = "NONE"  # no importance map: 4 ms instead of 1 s
    parts = []
    for look in _LOOKS:
        scene.camera.rotation_euler = look
        bpy.context.view_layer.update()
        layers = render_cycles(scene, folder, passes=())
        parts.append(layers["Combined"][..., :3].reshape(-1, 3))
    return np.concatenate(parts)


def some_texels(rng) -> np.ndarray:
    """float32 (8, 16, 3), contrast 1:2, no symmetry."""
    return rng.uniform(0.5, 1.0, (HEIGHT, WIDTH, 3)).astype(np.float32)


def new_image(texels, *, is_float=True, space=None, alpha=None):
    """A generated image."""
    height, width, _ = texels.shape
    image = bpy.data.images.new("map", width, height, alpha=True, float_buffer=is_float)
    if space is not None:
        image.colorspace_settings.name = space
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = texels
    if alpha is not None:
        rgba[..., 3] = alpha
    image.pixels.foreach_set(rgba.ravel())
    image.update()
    return image


def save_image(texels, path, file_format, depth="8", alpha=None):
    """A file that holds these numbers, and its data-block."""
    image = new_image(texels, space="Non-Color", alpha=alpha)
    scene = bpy.data.scenes.new("save")
    scene.view_settings.view_transform = "Raw"
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth = file_format, depth
    settings.color_mode = "RGB" if alpha is None else "RGBA"
    image.save_render(str(path), scene=scene)
    bpy.data.images.remove(image)
    bpy.data.scenes.remove(scene)
    return bpy.data.images.load(str(path))


def add(tree, kind, **values):
    node = tree.nodes.new(f"ShaderNode{kind}")
    for name, value in values.items():
        if name in node.inputs:
            node.inputs[name].default_value = value
        else:
            setattr(node, name, value)
    return node


def link(tree, *nodes):
    """Link first outputs to first inputs, along the chain."""
    for source, target in itertools.pairwise(nodes):
        tree.links.new(source.outputs[0], target.inputs[0])


def textured_world(tree, image, **values):
    """Environment Texture, Background, World Output. Returns the first two."""
    texture = add(tree, "TexEnvironment", image=image, **values)
    background = add(tree, "Background")
    link(tree, texture, background, add(tree, "OutputWorld"))
    return texture, background


def exported():
    warnings = []
    environment = read_world(bpy.context.evaluated_depsgraph_get(), warnings).light
    return environment, warnings


def looked_up(environment):
    directions = pixel_directions()
    radiance = np.empty_like(directions)
    eval_environment_many(make_lookup(environment), directions, radiance)
    return radiance


def near_singularity(environment):
    """Whether a pixel lies where a small step of the direction is a large step in the map.

    The poles of an equirectangular map (6 degrees: steps times 10), the rim of a mirror ball, all
    of which shows +y (15 degrees: the same in texels, since the ball's are finer).
    """
    matrix = environment.world_to_map.astype(float)
    d = pixel_directions() @ matrix[:, :3].T + matrix[:, 3]
    d /= np.maximum(np.linalg.norm(d, axis=1, keepdims=True), 1e-9)
    if environment.projection == "MIRROR_BALL":
        return d[:, 1] > np.cos(np.radians(15.0))
    return np.abs(d[:, 2]) > np.cos(np.radians(6.0))


def assert_as_cycles(scene, folder, relative=RELATIVE, quantised=0.0):
    """Every pixel agrees to ``relative``, and on average to a tenth of it.

    But at singularities, where one in a hundred may not; quantised: rounding of Cycles' texels
    """
    environment, warnings = exported()
    assert not warnings
    ours, cycles = looked_up(environment), cycles_background(scene, folder)
    difference = np.abs(ours - cycles).max(axis=1) / np.abs(cycles).max(axis=1)
    if environment.interpolation == "CLOSEST":
        # A pixel whose filter touches a texel's border may fall on either side: 2 in a thousand.
        assert (difference > 1e-6).mean() < 0.005
        return
    singular = near_singularity(environment)
    assert difference[~singular].max() < relative + quantised
    assert difference[~singular].mean() < 0.1 * relative + quantised
    if singular.any():
        assert np.quantile(difference[singular], 0.99) < 10 * relative + quantised


def mapped_world(tree, image, vector_type, projection="EQUIRECTANGULAR", **values):
    texture, _ = textured_world(tree, image, projection=projection)
    mapping = add(tree, "Mapping", vector_type=vector_type, **values)
    tree.links.new(add(tree, "TexCoord").outputs["Generated"], mapping.inputs["Vector"])
    link(tree, mapping, texture)
    return mapping


def read(cache=None, **options):
    """(world, warnings) of the open scene."""
    warnings = []
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return read_world(depsgraph, warnings, cache, **options), warnings


def noisy_world(tree, **values):
    """Noise at generated coordinates. Returns the texture and the background."""
    noise, background = add(tree, "TexNoise", **values), add(tree, "Background")
    link(tree, noise, background, add(tree, "OutputWorld"))
    return noise, background
