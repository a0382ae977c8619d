"""Lamps that the camera sees: light that is added along its rays."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from iwis.core.camera.camera import CameraRays
from iwis.core.data.lamps import (
    BEAM,
    BY_CAMERA,
    BY_DIFFUSE,
    BY_GLOSSY,
    DISC,
    MESH,
    RECTANGLE,
    SPHERE,
    SUN,
    make_lamps,
)
from iwis.core.data.program import Closure, Program
from iwis.core.lamplight.lamp_glow import lamp_glow, shown_lamps
from iwis.core.scene import BLACK, GGX
from iwis.core.see_through.cutouts import PassedPanes
from support.lamp_rows import area
from support.programs import with_programs
from support.scenes import (
    box,
    camera_above,
    constant_world,
    diffuse,
    floor,
    make_picture,
    make_scene,
)

SEEN = {"seen_by": BY_DIFFUSE | BY_GLOSSY | BY_CAMERA}
UP = np.diag([1.0, -1.0, -1.0])  # an area that shines upwards, to the camera
FILTERS = pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
COLOR = np.float32([3.0, 2.0, 1.0])


def pictures(row, pixel_filter="CENTER", **fields):
    """(layers with the lamp seen, layers with it unseen), of a box on a floor from 10 m above."""
    parts = [floor(0.6), box((0.1, -0.3, 0.0), (0.5, 0.3, 0.5))]
    found = []
    for seen in (SEEN, {}):
        lamps = make_lamps([row | seen | {"radiance": COLOR}])
        scene = make_scene(
            parts, [diffuse()] * 2, constant_world(), camera_above(24, 24), lamps=lamps
        )
        scene = dataclasses.replace(scene, **fields)
        settings = {"stop_rule": "FIXED", "max_samples": 64, "pixel_filter": pixel_filter}
        found.append(make_picture(scene, **settings)[0])
    return found


def glow(layers, without, name="combined"):
    """What the lamp adds to a layer."""
    return layers[name][..., :3] - without[name][..., :3]


@FILTERS
def test_a_ball_over_the_floor_is_seen(pixel_filter):
    """Of radius .25: its radiance, over its part of the picture; all else is as it was."""
    row = {"kind": SPHERE, "position": (-0.3, 0.0, 2.0), "size": (0.25, 0.0)}
    seen, unseen = pictures(row, pixel_filter, transparent_film=True, exposure=2.0)
    added = glow(seen, unseen)
    middle = added[12, 8]  # x = -.26
    np.testing.assert_allclose(middle, 2.0 * COLOR, rtol=1e-4)
    covered = added[..., 0].sum() / middle[0]
    # 35 pixels: their centres count three of them more or less than the disc's area.
    assert covered == pytest.approx(np.pi * 0.25**2 / 1.8**2 * 24**2, abs=3.5)
    np.testing.assert_allclose(added, glow(seen, unseen, "emission"), atol=1e-5)
    for name in ("depth", "normal", "diffuse_direct", "unoccluded", "samples"):
        np.testing.assert_allclose(seen[name], unseen[name], atol=1e-6)
    np.testing.assert_array_equal(seen["combined"][..., 3], unseen["combined"][..., 3])


@FILTERS
def test_what_is_nearer_hides_it(pixel_filter):
    """A disc in the box: seen where it sticks out, not through the box's top."""
    row = {"kind": DISC, "position": (0.1, 0.0, 0.25), "size": (0.25, 0.0)}
    added = glow(*pictures(row, pixel_filter))
    assert added[12, 12].max() == pytest.approx(3.0, rel=1e-4)  # x = .04, left of the box
    assert np.abs(added[12, 15:18]).max() < 1e-5  # in the box


def test_areas_are_seen_from_where_they_shine():
    """Upwards, over the world too; downwards nothing is added."""
    up = area(RECTANGLE, (0.0, 0.0, 2.0), 1.6, 0.4, UP)
    down = area(RECTANGLE, (0.0, 0.0, 2.0), 1.6, 0.4, np.eye(3))
    added = glow(*pictures(up))
    np.testing.assert_allclose(added[12, 2:22], np.tile(COLOR, (20, 1)), rtol=1e-4)
    assert np.abs(glow(*pictures(down))).max() < 1e-6


def test_a_sun_is_seen_where_nothing_else_is():
    """It shines upwards into the camera: beside the floor, not on it."""
    row = {"kind": SUN, "forward": (0.0, 0.0, 1.0), "size": (0.2, 0.0)}
    seen, unseen = pictures(row)
    free = seen["depth"][..., 0] > 1e9
    added = glow(seen, unseen)
    np.testing.assert_allclose(added[free], np.tile(COLOR, (free.sum(), 1)), rtol=1e-4)
    assert np.abs(added[~free]).max() < 1e-6


def test_an_edge_is_smooth():
    """The filter's passes are averaged: a ball's rim is neither on nor off."""
    row = {"kind": SPHERE, "position": (-0.3, 0.0, 2.0), "size": (0.25, 0.0)}
    share = glow(*pictures(row, "BOX"))[..., 0] / COLOR[0]
    assert ((share > 0.05) & (share < 0.95)).sum() > 8


def test_only_what_has_a_size_is_shown():
    """Points, beams and meshes, which are there as geometry, are not."""
    rows = [
        SEEN | {"kind": SPHERE},
        SEEN | {"kind": BEAM, "size": (1.0, 1.0)},
        SEEN | {"kind": MESH, "size": (1.0, 0.0)},
        {"kind": SPHERE, "size": (1.0, 0.0)},
    ]
    assert shown_lamps(make_lamps(rows)) is None
    lamps = shown_lamps(make_lamps([*rows, rows[-1] | SEEN]))
    assert len(lamps.kind) == 1 and lamps.seen_by[0] & BY_CAMERA


TINT = np.float32([0.5, 0.25, 0.75])


def seen_through(heights, row, pixel_filter, **fields):
    """What a lamp adds to the picture of a floor under tinted panes."""
    closure = Closure(BLACK, GGX, np.ones(3, np.float32), {})
    pane = Program(ops=(), closures=(closure,), transparent=TINT)
    parts = [floor(0.6), *(floor(9.0, height) for height in heights)]
    found = []
    for seen in (SEEN, {}):
        lamps = make_lamps([row | seen | {"radiance": COLOR}])
        materials = [diffuse()] * len(parts)
        scene = make_scene(parts, materials, constant_world(), camera_above(24, 24), lamps=lamps)
        scene = with_programs(scene, None, *[pane] * len(heights))
        settings = {"stop_rule": "FIXED", "max_samples": 16, "pixel_filter": pixel_filter}
        found.append(make_picture(dataclasses.replace(scene, **fields), **settings)[0])
    return glow(*found)


@FILTERS
@pytest.mark.parametrize("heights", [(4.0,), (4.0, 6.0), (1.0,), (5.0, 1.0)])
def test_panes_tint_the_lamps_behind_them(pixel_filter, heights):
    """Each that lies between the camera and the lamp, 2 m high, and none that lies behind it."""
    row = {"kind": SPHERE, "position": (-0.3, 0.0, 2.0), "size": (0.25, 0.0)}
    added = seen_through(heights, row, pixel_filter)
    before = sum(height > 2.0 for height in heights)
    np.testing.assert_allclose(added[12, 8], COLOR * TINT**before, rtol=1e-4)


@FILTERS
def test_a_pane_tints_what_shines_from_infinitely_far(pixel_filter):
    """A sun, beside the floor; the film is transparent, its opacity is the pane's alone."""
    row = {"kind": SUN, "forward": (0.0, 0.0, 1.0), "size": (0.2, 0.0)}
    added = seen_through((4.0,), row, pixel_filter, transparent_film=True)
    np.testing.assert_allclose(added[1, 12], COLOR * TINT, rtol=1e-4)


def test_panes_tint_the_lamps_of_light_groups():
    """Columns behind the first three are tinted alike."""
    row = {"kind": SPHERE, "position": (0.0, 0.0, -5.0), "size": (1.0, 0.0), "group": 0}
    lamps = make_lamps([row | {"radiance": COLOR}])
    origins, down = np.zeros((2, 3), np.float32), np.float32([[0.0, 0.0, -1.0]] * 2)
    rays = CameraRays(origins, down, np.full(2, 100.0, np.float32))
    nothing = SimpleNamespace(pixel=np.zeros(0, np.int32), position=np.zeros((0, 3), np.float32))
    panes = [
        PassedPanes(np.array([1]), np.float32([far]), TINT[None].copy()) for far in (2.0, 3.0, 4.5)
    ]
    found = lamp_glow(lamps, rays, nothing, 1, panes)
    np.testing.assert_allclose(found[0], [*COLOR, *COLOR])
    np.testing.assert_allclose(found[1], np.tile(COLOR * TINT**2, 2), rtol=1e-6)  # float32
