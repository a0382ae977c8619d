"""core/sampling/block_loop.py: one kernel does what incremental.continue_points does ray by ray."""

import numpy as np
import pytest

from iwis.core.products.guide import new_guides
from iwis.core.tiles.center_tile import CenterTile
from iwis.core.tiles.filtered_tile import FilteredTile
from iwis.core.tiles.tile_job import Rect
from support.scenes import make_job, one_texel_world, varied_scene

WHOLE = Rect(0, 0, 40, 28)
# Machine code for products is made once for either loop, and each time LLVM chooses anew in which
# order a product's 1024 cells add up: sums of so many float32 are off by 1024^.5 / 2^24 = 2e-6 as
# a rule, and by some times that at the worst of a picture's pixels.
SAME = {"rtol": 1e-5, "atol": 1e-7}


def _layers(by_rays, work=CenterTile, world=None, **settings):
    job = make_job(varied_scene(world), max_samples=64, **settings)
    job.accel.by_rays = by_rays
    tile = work(job, WHOLE)
    if by_rays is not None:  # nor does the older loop learn
        if work is CenterTile:
            tile._look()
            tile._guides = [new_guides(0)] * len(tile._layers)
        else:
            tile._sampler._guides = new_guides(0)
    while not tile.advance(64):
        pass
    return tile.develop().layers, tile.counts()


@pytest.mark.slow
@pytest.mark.parametrize("rule", ["FIXED", "PAPER", "PERCEPTUAL"])
@pytest.mark.parametrize("work", [CenterTile, FilteredTile])
def test_both_loops_make_the_same_picture(work, rule):
    """Same counts, same rays; light but for the last bits of float32."""
    settings = {"stop_rule": rule, "pixel_filter": "CENTER" if work is CenterTile else "BOX"}
    layers, counts = _layers(False, work, **settings)
    expected, expected_counts = _layers(True, work, **settings)
    assert counts == expected_counts
    for name, layer in layers.items():
        np.testing.assert_allclose(layer, expected[name], **SAME, err_msg=name)


def test_a_sun_of_one_texel_too():
    """Lanes without light get no ray in either loop."""
    world = one_texel_world(ground=0.1)
    layers, counts = _layers(False, world=world, stop_rule="FIXED")
    expected, expected_counts = _layers(True, world=world, stop_rule="FIXED")
    assert counts == expected_counts and counts.shadow_rays < counts.samples
    np.testing.assert_allclose(layers["combined"], expected["combined"], **SAME)


def test_a_raised_flag_ends_it():
    """With what there is: no sample is lost, none is added."""
    job = make_job(varied_scene(), stop_rule="FIXED", max_samples=64)
    job.stop.set()
    tile = CenterTile(job, WHOLE)
    tile.advance(64)
    assert tile.counts().samples == 0 and np.isfinite(tile.develop().layers["combined"]).all()
