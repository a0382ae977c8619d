"""core/tiles/tiles.py: every pixel in one tile; large tiles first, and small ones to wait for."""

import numpy as np
import pytest

from iwis.core.tiles.tiles import tile_plan, tile_rects

REGIONS = ((0, 0, 40, 28), (3, 7, 4, 8), (5, 0, 37, 65), (0, 0, 320, 200), (17, 40, 900, 500))


def _assert_covered(region, rects):
    x0, y0, x1, y1 = region
    count = np.zeros((y1, x1), int)
    for x, y, width, height in rects:
        count[y : y + height, x : x + width] += 1
    assert (count[y0:y1, x0:x1] == 1).all() and count.sum() == (x1 - x0) * (y1 - y0)


@pytest.mark.parametrize("region", REGIONS)
@pytest.mark.parametrize("tile_px", [8, 13, 64, 256])
def test_tiles_cover_the_region_once(region, tile_px):
    """None outside, none twice, whatever the threads; none larger than was asked for."""
    _assert_covered(region, tile_rects(region, tile_px))
    for threads in (1, 2, 3, 64):
        rects = tile_plan(region, tile_px, threads)
        _assert_covered(region, rects)
        assert all(max(width, height) <= tile_px for _, _, width, height in rects)


def test_tiles_at_the_centre_come_first():
    """So does Blender's user look there first."""
    x0, y0, x1, y1 = region = (5, 0, 37, 65)
    middle = [
        (x + w / 2 - (x0 + x1) / 2) ** 2 + (y + h / 2 - (y0 + y1) / 2) ** 2
        for x, y, w, h in tile_rects(region, 8)
    ]
    assert middle == sorted(middle)


def test_the_last_tiles_are_small():
    """One a thread is cut in four, for all others wait for the last; one thread waits for none."""
    region = (0, 0, 320, 192)
    sizes = [width for _, _, width, _ in tile_plan(region, 64, 2)]
    assert sizes == [64] * 13 + [32] * 8
    assert [width for _, _, width, _ in tile_plan(region, 64, 1)] == [64] * 15


def test_all_threads_have_tiles():
    """A small picture is cut into as many tiles as keep them busy, down to 8 pixels."""
    assert len(tile_plan((0, 0, 320, 192), 64, 8)) >= 4 * 8
    assert {width for _, _, width, _ in tile_plan((0, 0, 64, 64), 64, 64)} == {8}
