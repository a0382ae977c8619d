"""Edges that a few passes may have missed: between pixels whose light differs.

Four passes that fall to one side of a texture's edge, or of a lamp's reflection, agree, and their
pixel would end there: lines come out dotted. What the pixels around say of it does not depend on
that luck. So r of a pixel is at least what it were if one in seven of its passes fell to the other
side of an edge between the darkest and the brightest of the nine.
"""

from __future__ import annotations

import numpy as np

from .._jit import kernel
from .pass_sums import PassSums, mean_variance

# Part of the spread of passes that fall to both sides alike.
_SHARE = 0.7
# Of nine pixels that differ by noise alone, the range in its squares: within it is no edge.
_NOISE = 4.5


@kernel
def _fill(pixel, cell, width, samples, state, spread):
    for i in range(len(pixel)):
        p = pixel[i]
        dark, bright, low, high = p, p, np.inf, -np.inf
        for dy in range(-1, 2):
            for dx in range(-1, 2):
                q = p + dy * width + dx
                if cell[q] != cell[p] or state.passes[q] == 0:
                    continue
                light = state.light[q] / np.float64(state.passes[q])
                if light < low:
                    low, dark = light, q
                if light > high:
                    high, bright = light, q
        squared = (high - low) ** 2
        if not 0.0 < squared < np.inf:
            continue
        squared -= _NOISE * (mean_variance(state, dark) + mean_variance(state, bright))
        if squared > 0.0:
            edge = _SHARE * np.sqrt(squared * samples) / (high + low)
            spread[i] = max(np.float64(spread[i]), edge)


def add_edges(pixel, cell, width: int, samples: int, sums: PassSums, spread) -> None:
    """Raise r of pixels, float32 (n,), beside others of the same cell with other light.

    pixel: int32 (n,), rows of cell and of sums, none at the border; cell: int32, of each pixel of a
    tile, row by row, ``width`` in one; samples: of a pass
    """
    _fill(pixel, cell, width, samples, sums, spread)
