"""A luminaire's photometric table: how strongly it shines along a direction.

Between the angles of the table values follow cubics, as in Cycles (measured there). Below a first
vertical angle of 0 the table is mirrored; elsewhere beside it values go on as they are, and after
the last horizontal one as before the second last step. In Blender 4.5 they are 0 there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .values import normalized, parts

IES = "ies"


def _cubic(a, b, c, d, x):
    """Catmull-Rom, from b to c."""
    return 0.5 * (((d + 3.0 * (b - c) - a) * x + (2 * a - 5 * b + 4 * c - d)) * x + (c - a)) * x + b


def _steps(angles, at):
    """(the last angle that is not above, the part of the way to the next one)."""
    k = np.clip(np.searchsorted(angles, at, side="left") - 1, 0, len(angles) - 2)
    return k, (at - angles[k]) / np.maximum(angles[k + 1] - angles[k], 1e-6)


def intensity(context, settings, inputs):
    """Fac: Strength times the table's value along Vector, of the lamp's own space, -z its axis.

    settings: vertical, horizontal: float32 (k,), (m,), degrees, rising, the latter from 0 to 360;
    values: float32 (m, k); dark_ends: whether values are 0 beside the table
    """
    vertical, horizontal = settings["vertical"], settings["horizontal"]
    x, y, z = parts(normalized(inputs["Vector"]))
    v = np.degrees(np.arccos(np.clip(-z, -1.0, 1.0)))
    h = np.degrees(np.arctan2(x, y)) + 180.0
    i, part = _steps(horizontal, np.clip(h, horizontal[0], horizontal[-1]))
    j, rise = _steps(vertical, v)
    last, top = len(horizontal) - 1, len(vertical) - 1
    mirrored = vertical[0] == 0.0
    table = _Table(settings["values"], settings.get("dark_ends", False))
    columns = (
        (np.where(j > 0, j - 1, int(mirrored)), (j > 0) | mirrored),
        (j, True),
        (j + 1, True),
        (np.minimum(j + 2, top), j + 2 <= top),
    )
    rows = (
        (np.maximum(i - 1, 0), i > 0),
        (i, True),
        (i + 1, True),
        (np.where(i + 2 > last, last - 1, i + 2), i + 2 <= last),
    )
    along = (_cubic(*(table.at(row, column) for column in columns), rise) for row in rows)
    value = np.maximum(_cubic(*along, part), 0.0)
    value = np.where((v < vertical[0]) | (v > vertical[-1]), 0.0, value)
    return {"Fac": (value * inputs["Strength"]).astype(np.float32)}


class _Table(NamedTuple):
    """values: float32 (m, k)"""

    values: np.ndarray
    dark_ends: bool

    def at(self, row, column):
        """The values at rows and columns, each with whether it is in the table itself."""
        (row, has_row), (column, has_column) = row, column
        found = self.values[row, column]
        return np.where(has_row & has_column, found, 0.0) if self.dark_ends else found


FUNCTIONS = {IES: intensity}
