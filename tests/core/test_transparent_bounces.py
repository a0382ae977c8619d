"""How many surfaces a ray of the camera goes through (cutouts.py, Shaders.passes_of_camera)."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.program import Closure, Program
from iwis.core.scene import DIFFUSE, GGX
from support.programs import TINT, pane, with_programs
from support.scenes import camera_at, constant_world, diffuse, floor, make_picture, make_scene


def _stack(programs, passes, one_more=False, samples=64, **options):
    """Pictures of a stack of panes over a floor, seen from above by rays that may pass so many."""
    camera = camera_at((0.0, 0.0, 2.0), (0.0, 0.01, 0.0), 8, 8, 0.4)
    parts = [floor(1e3, -1.0), *(floor(50.0, -0.1 * k) for k in range(len(programs)))]
    scene = make_scene(parts, [diffuse()] * len(parts), constant_world(), camera)
    scene = with_programs(scene, None, *programs)
    shaders = dataclasses.replace(scene.shaders, one_more=one_more)
    scene = dataclasses.replace(scene, shaders=shaders, transparent_film=True, **options)
    settings = {"max_samples": samples, "stop_rule": "FIXED", "pixel_filter": "BOX"}
    return make_picture(scene, transparent_max_bounces=passes, **settings)[0]["combined"]


@pytest.mark.parametrize("one_more", [False, True])
@pytest.mark.parametrize(("passes", "seen"), [(0, 1), (1, 1), (2, 2), (3, 3), (8, 3)])
def test_camera_sees_what_lies_behind_so_many_panes(passes, seen, one_more):
    """Nothing is lit behind as many as may be passed, but the world is seen, as in Cycles of
    Blender 5; in Blender 4 a ray passes one more. Three panes, whose floor or no floor is behind.
    """
    seen = min(passes + 1, 3) if one_more else seen
    picture = _stack([pane()] * 3, passes, one_more)
    lit = picture[..., :3].max() > 0.0
    most = passes + 1 if one_more else max(passes, 1)
    assert (picture[..., 3] == 1.0).all() and lit == (most > 3)
    above = camera_at((60.0, 0.0, 2.0), (60.0, 0.01, 0.0), 8, 8, 0.4)  # beside the panes
    assert _stack([pane()] * 3, passes, one_more, camera=above)[..., :3].min() > 0.0
    up = camera_at((0.0, 0.0, -0.5), (0.0, 0.01, 2.0), 8, 8, 0.4)  # to the world
    alpha = _stack([pane()] * 3, passes, one_more, camera=up)[..., 3]
    expected = 1.0 - (TINT**3).mean() if most >= 3 else 1.0
    np.testing.assert_allclose(alpha, expected, rtol=1e-5)


def test_what_glows_is_seen_at_the_last_surface():
    """Whole, for there no ray is drawn: two panes that shine by .4 and pass .6 each, of which one
    may be passed: .4 + .6 x .4, and nothing of what reflects."""
    glow = np.float32([0.4] * 3)
    closure = Closure(DIFFUSE, GGX, np.float32([0.1] * 3), {})
    shiny = Program(ops=(), closures=(closure,), transparent=np.float32([0.6] * 3), emission=glow)
    dark = dataclasses.replace(constant_world(), radiance=np.zeros((4, 8, 3), np.float32))
    picture = _stack([shiny] * 3, 1, samples=512, environment=dark)
    # 64 passes of a pixel, stratified: a share of .4, which is .6 brighter, to 1.5 of them.
    np.testing.assert_allclose(picture[..., :3], 0.4 + 0.6 * 0.4, atol=0.6 * 1.5 / 64)
    assert (picture[..., 3] == 1.0).all()
