"""What shader nodes ask of the surfaces around a point (core/surfaces/near_rays.py)."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.program import Closure, Op, Program, Ref
from iwis.core.machine.watch import StopFlag
from iwis.core.render_cache import RenderCache
from iwis.core.scene import BLACK, CAMERA_RAYS, GGX, SHADOW_RAYS
from iwis.core.settings import RenderSettings
from iwis.core.surfaces.near_rays import _on_disk, with_near_rays
from iwis.core.windows.coarse_pictures import Pace
from iwis.core.windows.progressive import render_progressive
from support.programs import with_programs
from support.scenes import (
    black,
    box,
    camera_at,
    constant_world,
    floor,
    join_parts,
    make_picture,
    make_scene,
    quad,
)

FILTERS = ("CENTER", "BOX")
NODE = {"samples": 16, "inside": False, "only_local": False, "everywhere": False}
ONE = np.ones(3, np.float32)
# 256 rays a pixel with the filter, 64 at its centre, in nets of Sobol's sequence: a pixel's
# standard error is below .02, and the mean of 64 pixels an eighth of that.
PIXEL, MEAN = 0.1, 0.008


def test_places_on_the_disk_are_even():
    """Of a square's 400 x 400 cells each of 16 sectors has as many, to a row of cells, each of 4
    rings of one area as well; rays by them are those of the cosine."""
    steps = np.float32((np.arange(400) + 0.5) / 200.0 - 1.0)
    x, y = np.array([_on_disk(a, b) for a in steps for b in steps]).T
    sector = np.int64((np.arctan2(y, x) / (2.0 * np.pi) + 0.5) * 16.0).clip(0, 15)
    assert np.abs(np.bincount(sector, minlength=16) - 10_000).max() < 400
    ring = np.int64(4.0 * (x * x + y * y)).clip(0, 3)
    assert np.abs(np.bincount(ring, minlength=4) - 40_000).max() < 1600


def _glows(distance=2.0, **settings):
    """A material that is as bright as it is open."""
    inputs = {"Color": ONE, "Distance": np.float32(distance)}
    op = Op("ShaderNodeAmbientOcclusion", inputs, NODE | settings)
    whole = (Closure(BLACK, GGX, ONE, {}),)
    return Program(ops=(op,), closures=whole, emission=Ref(0, "Color"))


def _clear():
    return Program(ops=(), closures=(Closure(BLACK, GGX, ONE, {}),), transparent=ONE)


def _scene(parts, *programs, **fields):
    """A metre of the floor, seen from under a roof, or what is there in its place."""
    camera = camera_at((0.0, 0.0, 0.6), (0.0, 0.01, 0.0), 8, 8, 0.6)
    scene = make_scene(parts, [black()] * len(parts), constant_world(0.0), camera, **fields)
    return with_programs(scene, *programs)


def _seen(scene, pixel_filter="CENTER", **settings):
    """float32 (8, 8): how bright it is."""
    settings = {"max_samples": 128, "stop_rule": "FIXED"} | settings
    layers, _ = make_picture(scene, pixel_filter=pixel_filter, **settings)
    return layers["combined"][..., 0]


def _under_roof(floor_program, roof_program=None, **fields):
    return _scene([floor(1.0), floor(500.0, 1.0)], floor_program, roof_program, **fields)


@pytest.mark.parametrize("pixel_filter", FILTERS)
@pytest.mark.parametrize(("reach", "expected"), [(0.5, 1.0), (2.0, 0.25), (1e4, 0.0), (-1.0, 1.0)])
def test_roof_hides_what_is_within_reach(pixel_filter, reach, expected):
    """Under an endless roof at 1 m rays of 2 m meet it within 60 degrees: sin^2 of that, .75. No
    distance, or one below 0: nothing is near."""
    shown = _seen(_under_roof(_glows(reach)), pixel_filter)
    np.testing.assert_allclose(shown, expected, atol=PIXEL)
    assert abs(shown.mean() - expected) < MEAN


def test_distance_of_the_world_is_for_nodes_without_one():
    scene = _under_roof(_glows(0.0, everywhere=True))
    shaders = dataclasses.replace(scene.shaders, near_distance=2.0)
    shown = _seen(dataclasses.replace(scene, shaders=shaders))
    assert abs(shown.mean() - 0.25) < MEAN


@pytest.mark.parametrize("pixel_filter", FILTERS)
def test_only_local_looks_through_other_objects(pixel_filter):
    """Through a roof at 1 m to one of the same object at 1.5 m, which rays of 3 m meet within 60
    degrees; alone, without that one, all is open."""
    between = floor(500.0, 1.0)
    alone = _scene([floor(1.0), between], _glows(3.0, only_local=True), None)
    np.testing.assert_array_equal(_seen(alone, pixel_filter), 1.0)
    own = join_parts([floor(1.0), floor(500.0, 1.5)])
    shown = _seen(_scene([own, between], _glows(3.0, only_local=True), None), pixel_filter)
    assert abs(shown.mean() - 0.25) < MEAN


def test_inside_looks_behind_the_face():
    """Into the ground: a floor at -1 m is there what a roof is above."""
    parts = [floor(1.0), floor(500.0, -1.0), floor(500.0, 0.7)]
    shown = _seen(_scene(parts, _glows(2.0, inside=True), None, None))
    assert abs(shown.mean() - 0.25) < MEAN


def test_a_clear_roof_is_near_too():
    """Cycles' rays end at whatever throws a shadow, clear or not."""
    shown = _seen(_under_roof(_glows(), _clear()))
    assert abs(shown.mean() - 0.25) < MEAN


@pytest.mark.parametrize(("flags", "expected"), [(CAMERA_RAYS, 1.0), (SHADOW_RAYS, 0.25)])
def test_what_throws_no_shadow_is_not_near(flags, expected):
    """What the camera does not see may be."""
    own = np.array([CAMERA_RAYS | SHADOW_RAYS, flags], np.uint8)
    shown = _seen(_under_roof(_glows(), object_flags=own))
    assert abs(shown.mean() - expected) < MEAN


def test_a_normal_turns_the_rays():
    """Along a wall's foot, straight at the wall and away from it."""
    wall = quad((-500.0, -0.65, -500.0), (1000.0, 0.0, 0.0), (0.0, 0.0, 1000.0))
    for y, expected in ((-1.0, 0.0), (1.0, 1.0)):
        program = _glows(1e5)
        inputs = program.ops[0].inputs | {"Normal": np.float32([0.0, y, 0.0])}
        program = dataclasses.replace(program, ops=(program.ops[0]._replace(inputs=inputs),))
        scene = _scene([floor(1.0), wall], program, None)
        assert abs(_seen(scene).mean() - expected) < MEAN


@pytest.mark.parametrize("pixel_filter", FILTERS)
def test_same_picture_whatever_the_tiles_and_threads(pixel_filter):
    """Each point's rays are its own; another seed has others."""
    scene = _under_roof(_glows())
    small, whole = (
        _seen(scene, pixel_filter, tile_px=size, threads=threads)
        for size, threads in ((8, 2), (64, 1))
    )
    np.testing.assert_array_equal(small, whole)
    assert (_seen(scene, pixel_filter, seed=1) != whole).any()


@pytest.mark.parametrize("pixel_filter", FILTERS)
def test_rounded_edges_are_the_same_whatever_the_tiles(pixel_filter):
    """A box as bright as its rounded normals are along x."""
    op = Op("ShaderNodeBevel", {"Radius": np.float32(0.3)}, {"samples": 4})
    whole = (Closure(BLACK, GGX, ONE, {}),)
    program = Program(ops=(op,), closures=whole, emission=Ref(0, "Normal"))
    scene = _scene([box((-0.2, -0.2, -0.5), (0.2, 0.2, 0.0))], program)
    small, whole = (
        _seen(scene, pixel_filter, tile_px=size, threads=threads)
        for size, threads in ((8, 2), (64, 1))
    )
    np.testing.assert_array_equal(small, whole)
    assert whole.max() > 0.2 and whole.min() < -0.2  # the top is seen, and at its edges turned


def test_a_window_shows_what_a_render_shows():
    """A coarse picture is as open in the mean; the last one is the render's, to the last bit."""
    scene, shown = _under_roof(_glows()), []
    settings = RenderSettings(pixel_filter="CENTER", max_samples=8, stop_rule="FIXED", threads=1)
    own = RenderCache(), Pace(), StopFlag(), StopFlag()
    render_progressive(scene, settings, lambda picture: shown.append(_of(picture)), *own)
    assert len(shown) > 1 and abs(shown[0].mean() - 0.25) < 0.2  # some pixel of 64 rays: .05
    np.testing.assert_array_equal(shown[-1], _seen(scene, max_samples=8))


def _of(picture):
    return picture.layers["combined"][..., 0].copy()


def test_one_ray_of_a_point_is_seen_or_not():
    """With one sample a point is open or not; the mean is the same, with more noise."""
    one = _seen(_under_roof(_glows(samples=1)), "BOX", max_samples=128, batch_size=8)
    assert len(np.unique(np.round(one * 16.0))) > 4
    np.testing.assert_allclose(one * 16.0, np.round(one * 16.0), atol=1e-4)  # 16 passes, 0 or 1
    # A standard error of .11 a pixel, .014 of the mean: four of them.
    assert abs(one.mean() - 0.25) < 0.055


def test_scene_without_such_nodes_stays_as_it_is():
    """Nothing is made for it."""
    scene = _under_roof(_clear())
    assert with_near_rays(scene, None, None) is scene
