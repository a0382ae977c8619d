"""What is added to a Transparent BSDF: both have all of their weight (cutouts.going_share)."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.program import Closure, Program
from iwis.core.scene import BLACK, GGX
from support.programs import with_programs
from support.scenes import camera_at, constant_world, diffuse, floor, make_picture, make_scene

_ONE = np.ones(3, np.float32)
_GLOW = np.float32([0.3, 0.2, 0.1])


def _glowing(passing, shown=_ONE):
    """A card that glows, over an even world, on a transparent film: the picture."""
    nothing = Closure(BLACK, GGX, _ONE, {})
    own = {"emission": _GLOW, "transparent": np.float32(passing) * _ONE, "shown": shown}
    card = Program(ops=(), closures=(nothing,), **own)
    camera = camera_at((0.0, 0.0, 2.0), (0.0, 0.01, 0.0), 16, 16, 0.4)
    scene = make_scene([floor()], [diffuse()], constant_world((0.5, 0.5, 0.5)), camera)
    scene = dataclasses.replace(with_programs(scene, card), transparent_film=True)
    settings = {"max_samples": 512, "stop_rule": "FIXED", "pixel_filter": "BOX"}
    return make_picture(scene, **settings)[0]


@pytest.mark.parametrize("passing", [1.0, 0.75, 0.2])
def test_all_of_both_is_seen_and_alpha_is_what_does_not_pass(passing):
    """The glow as it is, the world times what passes, alpha 1 - that, as in Cycles."""
    layers = _glowing(passing)
    # 64 passes a pixel, stratified, of which the share may be wrong by one; 256 pixels.
    error = 3.0 * 2.0 / 64 / 16
    np.testing.assert_allclose(layers["emission"].mean((0, 1)), _GLOW, rtol=error)
    world = layers["environment"].mean()
    assert world == pytest.approx(0.5 * passing, rel=error)
    assert layers["combined"][..., 3].mean() == pytest.approx(1.0 - passing, abs=error)


def test_without_its_weight_what_is_added_is_lost():
    """The twin: a pane that passes all stops no ray, so nothing of it would be seen."""
    assert not _glowing(1.0, shown=None)["emission"].any()
