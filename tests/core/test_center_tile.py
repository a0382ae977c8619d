"""center_tile.py: the work at a tile can pause, and asks no neighbour that may be missing."""

import numpy as np
import pytest

from iwis.core.film import LAYERS
from iwis.core.tiles.center_tile import CenterTile, whole_cells
from iwis.core.tiles.tile_job import Rect
from support.scenes import camera_above, make_job, make_picture, varied_scene

RULES = pytest.mark.parametrize("rule", ["FIXED", "PAPER", "PERCEPTUAL"])
SETTINGS = {"max_samples": 64, "error_threshold": 0.2}


def _assert_same(layers, expected):
    for name in LAYERS:
        np.testing.assert_array_equal(layers[name], expected[name], err_msg=name)


@pytest.mark.parametrize("rule", ["FIXED", "PAPER"])
def test_a_tile_that_pauses_ends_with_the_same_picture(rule):
    """Advanced by two rounds at a time, all but sums and guides forgotten in between.

    Products are scaled once then, not lesson by lesson: the last bit differs, and where that
    sends a sample into another cell (about one in 10^6), the pixel.
    """
    job = make_job(varied_scene(), stop_rule=rule, **SETTINGS)
    once, often = (CenterTile(job, Rect(8, 4, 20, 16)) for _ in range(2))
    assert once.advance(64)
    for samples in range(16, 65, 16):
        done = often.advance(samples)
        assert often.develop().layers["samples"].max() <= samples
        often.rest()
    assert done and once.counts()[0] == often.counts()[0]
    layers, expected = often.develop().layers, once.develop().layers
    for name in LAYERS:
        other = np.abs(layers[name] - expected[name]) > 1e-4 * np.abs(expected[name]) + 1e-6
        assert other.mean() < 0.01, name


@RULES
def test_a_tile_says_when_it_is_done(rule):
    """Long before MAX where every pixel has stopped; at MAX in any case."""
    job = make_job(varied_scene(), stop_rule=rule, max_samples=4096, error_threshold=0.5)
    tile = CenterTile(job, Rect(0, 0, 16, 8))
    done = tile.advance(1024)
    assert done == (rule != "FIXED") and tile.advance(4096)


@RULES
@pytest.mark.parametrize("change", [{"threads": 3, "tile_px": 8}, {"tile_px": 13}])
def test_threads_and_tiles_do_not_change_the_picture(rule, change):
    """Bit for bit, although PERCEPTUAL asks the pixels around."""
    settings = SETTINGS | {"stop_rule": rule}
    layers, _ = make_picture(varied_scene(), **settings)
    _assert_same(make_picture(varied_scene(), **settings | change)[0], layers)


@RULES
@pytest.mark.parametrize("region", [(11, 5, 30, 23), (39, 27, 40, 28)])
def test_a_border_is_a_part_of_the_whole(rule, region):
    """The cells that it cuts are worked at whole."""
    x0, y0, x1, y1 = region
    whole, _ = make_picture(varied_scene(), stop_rule=rule, **SETTINGS)
    part, stats = make_picture(varied_scene(region=region), stop_rule=rule, **SETTINGS)
    _assert_same(part, {name: layer[y0:y1, x0:x1] for name, layer in whole.items()})
    assert stats.samples_total == part["samples"].sum()


def test_whole_cells_end_at_the_frame():
    """Eight pixels a side, from the frame's corner on."""
    camera = camera_above(30, 20)
    assert whole_cells(Rect(9, 8, 5, 8), camera) == (8, 8, 8, 8)
    assert whole_cells(Rect(0, 0, 1, 9), camera) == (0, 0, 8, 16)
    assert whole_cells(Rect(25, 17, 5, 3), camera) == (24, 16, 6, 4)
