"""Surfaces that let rays through: cutouts.py, opacity.py, embree_filter.py, scene_rays.py."""

import dataclasses

import numpy as np
import pytest

import iwis.core.see_through.ray_masks as ray_masks
from iwis.core.data.program import Closure, Op, Program, Ref
from iwis.core.embree.accel import Accel
from iwis.core.embree.opacity_grids import Opacity
from iwis.core.render_cache import RenderCache
from iwis.core.scene import CAMERA_RAYS, DIFFUSE, GGX, SHADOW_CATCHER, SHADOW_RAYS
from iwis.core.see_through.opacity import bake_opacity
from support.programs import TINT, pane, with_programs
from support.scenes import (
    camera_at,
    constant_world,
    diffuse,
    floor,
    make_mesh,
    make_picture,
    make_scene,
)

_ONE = np.ones(3, np.float32)
_POSITION = Op("ShaderNodeNewGeometry", {}, {"outputs": {"Position"}})
_HALF = Op("ShaderNodeSeparateXYZ", {"Vector": Ref(0, "Position")}, {})
_STEP = Op(
    "ShaderNodeMath",
    {"Value": Ref(1, "X"), "Value_001": np.float32(0.0)},
    {"operation": "GREATER_THAN", "use_clamp": False},
)
_AS_COLOR = Op("convert", {"Value": Ref(2, "Value")}, {"source": "NUMBER", "target": "COLOR"})


def _card(share) -> Program:
    """A material that lets a share through and reflects what else there is."""
    closure = Closure(DIFFUSE, GGX, np.float32(1.0 - share) * _ONE, {})
    return Program(ops=(), closures=(closure,), transparent=np.float32(share) * _ONE)


# Passes all light where x > 0, none elsewhere.
_SIDE = Program(
    ops=(_POSITION, _HALF, _STEP, _AS_COLOR),
    closures=(Closure(DIFFUSE, GGX, _ONE, {}),),
    transparent=Ref(3, ""),
)


def _under_a_roof(program, side=6):
    """A small floor under a vast roof of a material; the camera is between them."""
    camera = camera_at((0.0, 0.0, 0.6), (0.0, 0.01, 0.0), side, side, 0.6)
    parts = [floor(1.0), floor(500.0, 1.0)]
    scene = make_scene(parts, [diffuse((0.5, 0.5, 0.5)), diffuse()], constant_world(), camera)
    return with_programs(scene, None, program)


@pytest.fixture(params=["by Embree's filter", "hit by hit"])
def way(request, monkeypatch):
    """Both ways that shadow rays can be let through."""
    if request.param == "hit by hit":
        monkeypatch.setattr(ray_masks, "can_filter", lambda: False)
    return request.param


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0])
def test_roof_lets_its_share_of_the_light_through(way, share):
    """An even sky over a roof over a floor of albedo .5: radiance .5 times the share.

    4096 rays a pixel, 36 pixels: a standard error of .0011 of 1, of which three; grids keep a share
    to half a step of 255.
    """
    scene = _under_a_roof(_card(share))
    layers, _ = make_picture(scene, max_samples=4096, stop_rule="FIXED")
    radiance = layers["combined"][..., :3].mean()
    assert abs(radiance - 0.5 * share) <= 0.5 * (3 * 0.0011 + 0.5 / 255)


def test_camera_sees_through_a_roof(way):
    """From above, a roof that passes half, over a black world: half of it and half of the floor."""
    scene = _under_a_roof(_card(0.5))
    camera = camera_at((0.0, 0.0, 2.0), (0.0, 0.01, 0.0), 8, 8, 0.5)
    scene = dataclasses.replace(scene, camera=camera)
    layers, _ = make_picture(scene, max_samples=2048, stop_rule="FIXED", pixel_filter="BOX")
    # The roof, albedo .8, is lit from above in full; the floor, .5, by half of the light.
    expected = 0.5 * 0.8 + 0.5 * 0.5 * 0.5
    assert abs(layers["combined"][..., :3].mean() / expected - 1.0) < 0.02
    assert (layers["combined"][..., 3] == 1.0).all()


def test_alpha_is_the_share_of_the_rays_that_end():
    """A card over nothing, transparent film: alpha is its opacity; at pixel centres it is drawn."""
    camera = camera_at((0.0, 0.0, 2.0), (0.0, 0.01, 0.0), 16, 16, 0.4)
    scene = make_scene([floor()], [diffuse()], constant_world(), camera)
    scene = dataclasses.replace(with_programs(scene, _card(0.25)), transparent_film=True)
    settings = {"max_samples": 512, "stop_rule": "FIXED"}
    smooth = make_picture(scene, pixel_filter="BOX", **settings)[0]["combined"][..., 3]
    np.testing.assert_allclose(smooth, 0.75, atol=1.5 / 64)  # 64 passes, stratified
    drawn = make_picture(scene, **settings)[0]["combined"][..., 3]
    assert set(np.unique(drawn)) == {0.0, 1.0} and abs(drawn.mean() - 0.75) < 0.03


def test_layers_are_drawn_apart():
    """Three cards that pass .3 each, one behind the other: opacity 1 - .3^3, and that of each."""
    camera = camera_at((0.0, 0.0, 2.0), (0.0, 0.01, 0.0), 16, 16, 0.4)
    parts = [floor(50.0, -0.1 * k) for k in range(3)]
    scene = make_scene(parts, [diffuse()] * 3, constant_world(), camera)
    scene = with_programs(scene, *[_card(0.3)] * 3)
    scene = dataclasses.replace(scene, transparent_film=True)
    settings = {"max_samples": 512, "stop_rule": "FIXED", "pixel_filter": "BOX"}
    alpha = make_picture(scene, **settings)[0]["combined"][..., 3]
    np.testing.assert_allclose(alpha, 1.0 - 0.3**3, atol=1.5 / 64)  # 64 passes, stratified
    assert abs(alpha.mean() - (1.0 - 0.3**3)) < 0.003


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
@pytest.mark.parametrize("behind", ["the world", "a floor", "a shadow catcher"])
def test_pane_colors_what_is_behind_it(behind, pixel_filter):
    """Of white things behind it the camera sees the tint, without noise, in every pixel.

    Its opacity is the rest of the tint's mean, but before a floor. The floor's own light is noisy:
    a deviation of .6 % at 512 samples.
    """
    camera = camera_at((0.0, 0.0, 2.0), (0.0, 0.01, 0.0), 16, 16, 0.4)
    parts = [floor(), *([floor(500.0, -0.5)] if behind != "the world" else [])]
    materials = [diffuse(), diffuse((1.0, 1.0, 1.0))][: len(parts)]
    scene = make_scene(parts, materials, constant_world(), camera)
    scene = with_programs(scene, *[pane(), None][: len(parts)])
    plain = CAMERA_RAYS | SHADOW_RAYS
    flags = np.uint8([CAMERA_RAYS, plain][: len(parts)])
    if behind == "a shadow catcher":
        flags[1] |= SHADOW_CATCHER
    scene = dataclasses.replace(scene, object_flags=flags)
    settings = {"max_samples": 512, "stop_rule": "FIXED", "pixel_filter": pixel_filter}
    shown = make_picture(scene, **settings)[0]["combined"]
    noise = 0.03 if behind == "a floor" else 0.003
    np.testing.assert_allclose(shown[..., :3], np.broadcast_to(TINT, (16, 16, 3)), rtol=noise)
    film = dataclasses.replace(scene, transparent_film=True)
    alpha = make_picture(film, **settings)[0]["combined"][..., 3]
    expected = 1.0 if behind == "a floor" else 1.0 - TINT.mean()
    np.testing.assert_allclose(alpha, expected, atol=0.003)


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
def test_panes_multiply(pixel_filter):
    """Three panes one behind the other; a black one ends the rays."""
    camera = camera_at((0.0, 0.0, 2.0), (0.0, 0.01, 0.0), 8, 8, 0.4)
    parts = [floor(50.0, -0.1 * k) for k in range(3)]
    scene = make_scene(parts, [diffuse()] * 3, constant_world(), camera)
    scene = dataclasses.replace(scene, transparent_film=True)
    for last, expected in ((TINT, TINT**3), (np.zeros(3, np.float32), np.zeros(3))):
        panes = with_programs(scene, pane(), pane(), pane(last))
        layers, _ = make_picture(panes, max_samples=8, pixel_filter=pixel_filter)
        alpha, world = layers["combined"][..., 3], layers["environment"]
        np.testing.assert_allclose(alpha, 1.0 - expected.mean(), atol=1e-5)
        np.testing.assert_allclose(world, np.broadcast_to(expected, world.shape), atol=1e-5)


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
@pytest.mark.parametrize("clip_end, seen", [(1.5, 0), (2.05, 1), (2.15, 2), (9.0, 3)])
def test_panes_beyond_the_far_plane_are_not_there(pixel_filter, clip_end, seen):
    """Three panes, 2, 2.1 and 2.2 m away."""
    camera = camera_at((0.0, 0.0, 2.0), (0.0, 0.01, 0.0), 8, 8, 0.01)
    camera = dataclasses.replace(camera, clip_end=clip_end)
    parts = [floor(50.0, -0.1 * k) for k in range(3)]
    scene = with_programs(
        make_scene(parts, [diffuse()] * 3, constant_world(), camera), *[pane()] * 3
    )
    layers, _ = make_picture(scene, max_samples=8, pixel_filter=pixel_filter)
    world = layers["environment"]
    np.testing.assert_allclose(world, np.broadcast_to(TINT**seen, world.shape), atol=1e-5)


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
def test_surface_that_shows_itself_is_drawn_by_its_share(pixel_filter):
    """Tinted, and black beside that: rays end or take the tint over its mean."""
    camera = camera_at((0.0, 0.0, 2.0), (0.0, 0.01, 0.0), 16, 16, 0.4)
    scene = make_scene([floor()], [diffuse()], constant_world(), camera)
    black = Closure(DIFFUSE, GGX, np.zeros(3, np.float32), {})
    tint = Program(ops=(), closures=(black,), transparent=TINT)
    shown = make_picture(with_programs(scene, tint), pixel_filter=pixel_filter, max_samples=8)
    shown = shown[0]["combined"][..., :3].reshape(-1, 3)
    ratio = shown / (TINT / TINT.mean())
    np.testing.assert_allclose(ratio, ratio[:, :1] * np.ones(3), rtol=1e-5)
    assert abs(shown.mean() / TINT.mean() - 1.0) < 0.1


def test_half_a_card_is_cut_away(way):
    """The camera and the shadow see the same half."""
    scene = _under_a_roof(_SIDE)
    rays = RenderCache().rays(scene)
    assert rays.by_rays is (way == "hit by hit")
    rng = np.random.default_rng(7)
    origins = np.concatenate([rng.uniform(-1, 1, (500, 2)), np.full((500, 1), 0.5)], 1)
    origins = origins.astype(np.float32)
    up = np.tile(np.float32([0.0, 0.0, 1.0]), (500, 1))
    origins[:, :2] *= 400.0
    sharp = np.abs(origins[:, 0]) > 2.0 * 1000.0 / 64.0  # metres that a step of the grid may blur
    np.testing.assert_array_equal(rays.occluded(origins, up)[sharp], origins[sharp, 0] < 0.0)


def test_grey_grids_take_no_more_room():
    scene = _under_a_roof(_card(0.5))
    assert not bake_opacity(scene, scene.mesh.material_index == 1).colored


def test_filter_passes_what_the_grid_says():
    """0, .5 and 1 at the corners of a triangle: half of all rays go through, and the same ones."""
    vertices, triangles, normals = floor()
    mesh = make_mesh((vertices, triangles, normals))
    half = Opacity(
        np.zeros(2, np.int32),
        np.zeros(1, np.int64),
        np.ones(1, np.int32),
        np.uint8([0, 128, 255]),
        np.zeros(1, np.uint8),
        np.zeros((0, 3, 3), np.float32),
    )
    accel, n = Accel(mesh, opacity=half), 40_000
    xy = np.random.default_rng(5).uniform(-1.0, 1.0, (n, 2))
    origins = np.concatenate([xy, np.ones((n, 1))], axis=1).astype(np.float32)
    down = np.tile(np.float32([0.0, 0.0, -1.0]), (n, 1))
    first, second = accel.occluded(origins, down), accel.occluded(origins, down)
    np.testing.assert_array_equal(first, second)
    assert abs(first.mean() - 0.5) < 0.01  # four standard errors
    assert (accel.intersect(origins, down)[0] >= 0).all()


@pytest.mark.parametrize("flags", [CAMERA_RAYS, SHADOW_RAYS])
def test_object_that_only_some_rays_see(flags):
    """A roof that the camera does not see throws its shadow, and the other way round."""
    scene = _under_a_roof(None)
    scene = dataclasses.replace(
        scene, shaders=None, object_flags=np.uint8([CAMERA_RAYS | SHADOW_RAYS, flags])
    )
    above = camera_at((0.0, 0.0, 2.0), (0.0, 0.01, 0.0), 6, 6, 0.4)
    scene = dataclasses.replace(scene, camera=above)
    layers, _ = make_picture(scene, max_samples=64, stop_rule="FIXED")
    expected = 0.8 if flags == CAMERA_RAYS else 0.0  # the roof, lit; the floor in its shadow
    # 64 samples of an even sky, their mean over 36 pixels.
    assert abs(layers["combined"][..., :3].mean() - expected) <= 0.02 * expected + 1e-5


def test_hierarchies_are_kept_while_what_they_show_is_the_same():
    """New objects that say the same give the same parts; another grid gives new ones."""
    cache, scene = RenderCache(), _under_a_roof(_SIDE)
    first = cache.rays(scene)
    again = cache.rays(with_programs(scene, None, dataclasses.replace(_SIDE)))
    assert first.traversal == again.traversal
    other = cache.rays(with_programs(scene, None, _card(0.5)))
    assert other.traversal != first.traversal


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
@pytest.mark.parametrize("clear", [0.0, 0.5])
def test_holdout_takes_its_share_of_light_and_alpha(clear, pixel_filter):
    """A floor of albedo .8 under an even sky, a quarter of it held out, none or half of it clear.

    288 draws a picture under CENTER, 64 times as many under BOX: 4 standard errors.
    """
    shown = 0.75 - clear
    own = {"holdout": np.float32(0.25) * _ONE}
    if clear:
        own["transparent"] = np.float32(clear) * _ONE
    closure = Closure(DIFFUSE, GGX, np.float32(shown) * _ONE, {})
    program = Program(ops=(), closures=(closure,), **own)
    camera = camera_at((0.0, 0.0, 5.0), (0.0, 0.01, 0.0), 24, 12, 0.6)
    scene = make_scene([floor(50.0)], [diffuse()], constant_world(), camera)
    scene = dataclasses.replace(with_programs(scene, program), transparent_film=True)
    layers, _ = make_picture(scene, max_samples=256, stop_rule="FIXED", pixel_filter=pixel_filter)
    tolerance = 0.1 if pixel_filter == "CENTER" else 0.013
    assert layers["combined"][..., 3].mean() == pytest.approx(shown, abs=tolerance)
    assert layers["combined"][..., :3].mean() == pytest.approx(0.8 * shown, abs=tolerance)
