"""Shadow rays through coloured surfaces: embree_filter.py, trace_lanes.py, lamp_light.py."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.lamps import SUN, make_lamps
from iwis.core.data.program import Closure, Program
from iwis.core.embree.embree_rays import ALL_COLORS, occluded_block
from iwis.core.render_cache import RenderCache
from iwis.core.scene import BLACK, CAMERA_RAYS, GGX, SHADOW_RAYS
from support.programs import with_programs
from support.scenes import camera_at, constant_world, diffuse, floor, make_picture, make_scene

_ONE = np.ones(3, np.float32)
_TINT = np.float32([0.9, 0.5, 0.1])


_TINTED = Program(ops=(), closures=(Closure(BLACK, GGX, _ONE, {}),), transparent=_TINT)


def _under(roofs, world):
    """A small white floor under so many vast tinted roofs; the camera is between them."""
    camera = camera_at((0.0, 0.0, 0.6), (0.0, 0.01, 0.0), 6, 6, 0.6)
    parts = [floor(1.0), *(floor(500.0, 1.0 + k) for k in range(roofs))]
    materials = [diffuse((1.0, 1.0, 1.0))] * len(parts)
    scene = make_scene(parts, materials, world, camera)
    return with_programs(scene, None, *[_TINTED] * roofs)


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
@pytest.mark.parametrize("roofs", [1, 2])
def test_shadow_has_the_color_of_what_throws_it(pixel_filter, roofs):
    """A floor under one tinted roof, and under two: each color is let through for itself.

    4096 rays a pixel, 36 pixels: four standard errors of a share.
    """
    settings = {"max_samples": 4096, "stop_rule": "FIXED", "pixel_filter": pixel_filter}
    layers, _ = make_picture(_under(roofs, constant_world()), **settings)
    shown = layers["combined"][..., :3].mean((0, 1))
    of_the_grid = np.rint(_TINT * 255.0) / 255.0
    np.testing.assert_allclose(shown, of_the_grid**roofs, atol=0.004)


def test_lamp_throws_a_colored_shadow():
    """Of a sun straight above, through a tinted roof: 16 samples a pixel of 36."""
    lamps = make_lamps([{"kind": SUN, "size": (0.02, 0.0), "radiance": (1000.0,) * 3}])
    tinted = dataclasses.replace(_under(1, constant_world((0.0, 0.0, 0.0))), lamps=lamps)
    unseen = np.uint8([CAMERA_RAYS | SHADOW_RAYS, CAMERA_RAYS])
    plain = dataclasses.replace(tinted, object_flags=unseen)
    settings = {"max_samples": 256, "stop_rule": "FIXED", "pixel_filter": "BOX"}
    lit, shown = (
        make_picture(s, **settings)[0]["combined"][..., :3].mean((0, 1)) for s in (plain, tinted)
    )
    assert (lit > 0.1).all()
    np.testing.assert_allclose(shown / lit, _TINT, atol=0.03)


def test_packets_and_single_rays_see_the_same_colors():
    """The same bits, and each color as often as it is let through."""
    rays = RenderCache().rays(_under(1, constant_world()))
    accel = rays.traversal
    assert accel.colored
    rng = np.random.default_rng(11)
    n = 20_000
    origins = np.tile(np.float32([0.0, 0.0, 0.5]), (n, 1))
    up = rng.normal(size=(n, 3)).astype(np.float32)
    up[:, 2] = np.abs(up[:, 2]) + np.float32(0.05)
    packets, singles = np.empty(n, np.uint8), np.empty(n, np.uint8)
    occluded_block(accel, origins, up, n, ALL_COLORS, packets)
    occluded_block(accel._replace(occluded8=0), origins, up, n, ALL_COLORS, singles)
    np.testing.assert_array_equal(packets, singles)
    free = [1.0 - np.mean((packets >> k) & 1) for k in range(3)]
    np.testing.assert_allclose(free, _TINT, atol=0.015)  # four standard errors
