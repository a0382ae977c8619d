"""How a picture is cut into tiles, and in which order they are worked at.

What a tile costs beside its samples is Python's work, so tiles are as large as keeps all threads
busy, and only the last ones are small: those that the other threads wait for.
"""

from __future__ import annotations

from .tile_job import Rect

# Tiles under a thread's hands one after another; those of the last ones that are cut in four.
_TILES_A_THREAD, _CUT_A_THREAD = 2, 1
_LEAST_TILE, _LEAST_PART = 8, 32  # pixels; parts that are smaller cost more than the wait


def tile_plan(region: tuple[int, int, int, int], tile_px: int, threads: int) -> list[Rect]:
    """A render's tiles in the order of work, with sides of tile_px; less for few pixels."""
    size = _tile_size(region, tile_px, threads)
    rects = tile_rects(region, size)
    if threads == 1 or size < 2 * _LEAST_PART:
        return rects
    whole = max(len(rects) - _CUT_A_THREAD * threads, 0)
    parts = [
        part
        for x, y, width, height in rects[whole:]
        for part in tile_rects((x, y, x + width, y + height), size // 2)
    ]
    return rects[:whole] + parts


def tile_rects(region: tuple[int, int, int, int], tile_px: int) -> list[Rect]:
    """The tiles that cover a region, those at its centre first."""
    x0, y0, x1, y1 = region
    rects = []
    for y in range(y0 - y0 % tile_px, y1, tile_px):
        for x in range(x0 - x0 % tile_px, x1, tile_px):
            left, low = max(x, x0), max(y, y0)
            right, top = min(x + tile_px, x1), min(y + tile_px, y1)
            rects.append(Rect(left, low, right - left, top - low))
    middle_x, middle_y = (x0 + x1) / 2, (y0 + y1) / 2
    rects.sort(key=lambda r: (r[0] + r[2] / 2 - middle_x) ** 2 + (r[1] + r[3] / 2 - middle_y) ** 2)
    return rects


def _tile_size(region, tile_px: int, threads: int) -> int:
    """tile_px, or less where a picture would have too few tiles to keep all threads busy."""
    x0, y0, x1, y1 = region
    size, pixels = tile_px, (x1 - x0) * (y1 - y0)
    while size >= 2 * _LEAST_TILE and pixels < _TILES_A_THREAD * threads * size**2:
        size //= 2
    return size
