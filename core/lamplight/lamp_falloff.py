"""How a lamp's radiance changes with the distance that its light goes: factors from a table.

Light falls off with the square of the distance by itself; a Light Falloff node, or the Ray Length
of Light Path, changes what leaves the lamp by how far it has to go, as no real lamp does. The table
(lamps.falloff_knots) is linear between its rows: exact for Quadratic and Linear falloff, and 6e-5
off at the most for Constant.
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from ..data.lamps import FALLOFF_ROWS, FALLOFF_STEPS, NEAREST


@kernel(forceinline=True)
def falloff_at(lamps, i, far):
    """(r, g, b), the factor of lamp i's radiance at a distance; its ``falloff`` is not -1."""
    part, power = math.frexp(min(max(far, 1e-30), 1e30))  # far = part x 2^power, part from .5 to 1
    place = (2.0 * part - 1.0 + (power - 1 - NEAREST)) * FALLOFF_STEPS
    place = min(max(place, 0.0), FALLOFF_ROWS - 1.0)
    k = min(np.int64(place), FALLOFF_ROWS - 2)
    t, table, row = place - k, lamps.falloffs, lamps.falloff[i]
    s = 1.0 - t
    return (
        s * table[row, k, 0] + t * table[row, k + 1, 0],
        s * table[row, k, 1] + t * table[row, k + 1, 1],
        s * table[row, k, 2] + t * table[row, k + 1, 2],
    )
