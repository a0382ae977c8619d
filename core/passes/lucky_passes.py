"""Pixels whose few passes were brighter than those of the pixels around, or more alike, by luck.

Where light is half hidden, passes that saw much of it are alike, and a pixel that had four of them
would end there, while one that had dark ones goes on: all together come out too bright. Where light
is rare passes without it are alike, and all come out too dark. What the pixels around have, whose
light differs by no more than noise explains, is nearer to the truth.
"""

from __future__ import annotations

import numpy as np

from .._jit import kernel
from .pass_sums import PassSums, mean_variance

# Of two pixels' light, the square of its difference over its variance: more is no luck. The spread
# of few passes is itself known badly.
_ALIKE = 25.0
# The most that others' spread raises a pixel's: more is no likely luck of four passes.
_MOST = 1.5


@kernel
def _fill(pixel, cell, width, state, spread):
    for i in range(len(pixel)):
        p = pixel[i]
        passes = np.float64(state.passes[p])
        if passes == 0.0 or state.light[p] <= 0.0:
            continue
        own, variance = state.light[p] / passes, mean_variance(state, p)
        total, count, scatter = own, 1.0, variance
        for dy in range(-1, 2):
            for dx in range(-1, 2):
                q = p + dy * width + dx
                if q == p or cell[q] != cell[p] or state.passes[q] == 0:
                    continue
                light = state.light[q] / np.float64(state.passes[q])
                other = mean_variance(state, q)
                if (light - own) ** 2 <= _ALIKE * (variance + other):
                    total += light
                    count += 1.0
                    scatter += other
        if total > 0.0 and variance > 0.0:
            brighter = own * count / total
            noisier = brighter * np.sqrt(scatter / (count * variance))
            spread[i] *= max(brighter, min(noisier, _MOST), 1.0)


def raise_lucky(pixel, cell, width: int, sums: PassSums, spread) -> None:
    """Raise r of pixels, float32 (n,), that are brighter or surer than those around by luck.

    To what it is relative to the mean light of both, or nearly what all of them have; it falls for
    none, for what has seen little is to go on looking. pixel, cell, width: of light_edges.add_edges
    """
    _fill(pixel, cell, width, sums, spread)
