"""The light's coarse statistics: mean and mean square of luminance over cells of the square.

Luminance as of luminance.magnitude: negative light asks for as many samples as that which adds.

Each texel is visited once, by a sample at its centre with its solid angle (by several where it is
larger than a cell), so nothing is missed and the poles need no special care. Where a direction's
texel has no simple inverse (mirror ball, a mapping that moves the origin), cells look their light
up instead.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.luminance import magnitude
from ..data.channels import LUMINANCE_B, LUMINANCE_G, LUMINANCE_R
from .cell_lookup import LARGEST, look_up_cell, look_up_cells
from .environment import EnvironmentLookup, eval_map, fast_atan2
from .pyramid import WHOLE_LEVELS, cell_beside, level_offset, spread_bits

_MAX_LEVEL = 11
_TEXELS_A_CELL = 2.2  # along a side, so that a texel's light never reaches over a whole cell
# Of a neighbour's mean square, what a texel's light that reaches over may bring: a quarter of it.
_TAIL = np.float32(1.0 / 16.0)
_CHUNK = 1 << 18  # samples between two calls of progress


class CellLight(NamedTuple):
    """What is known of the light in each cell, in Morton order.

    finest: float32 (4^level, 2): mean of luminance; what its mean square may be, for the light of a
        texel in the next cell reaches over
    mean, square: float32 (level_offset(level),), first and last of them for all coarser levels
    level: of the finest cells; total: mean magnitude of the sphere
    """

    finest: np.ndarray
    mean: np.ndarray
    square: np.ndarray
    level: int
    total: float


@kernel(forceinline=True)
def _direction_to_square(dx, dy, dz):
    """sphere_to_square in float32, good at the poles too."""
    one, half = np.float32(1.0), np.float32(0.5)
    r = np.sqrt((dx * dx + dy * dy) / (one + abs(dz)))
    v = np.float32(2.0 / math.pi) * fast_atan2(abs(dy), abs(dx)) * r
    u = r - v
    if dz < np.float32(0.0):
        u, v = one - v, one - u
    return half * (math.copysign(u, dx) + one), half * (math.copysign(v, dy) + one)


@kernel
def _find_cells(inverse, jacobian, around, sine, cosine, side, cells, weights):
    """The cell and the relative solid angle of each sample of a row of the map.

    around: float32 (n, 2), cosine and sine of the samples' longitudes; inverse: float32 (3, 3)
    """
    top = np.int32(side - 1)
    scale = np.float32(side)
    for j in range(len(cells)):
        px, py = cosine * around[j, 0], cosine * around[j, 1]
        x = inverse[0, 0] * px + inverse[0, 1] * py + inverse[0, 2] * sine
        y = inverse[1, 0] * px + inverse[1, 1] * py + inverse[1, 2] * sine
        z = inverse[2, 0] * px + inverse[2, 1] * py + inverse[2, 2] * sine
        shorter = np.float32(1.0) / np.sqrt(x * x + y * y + z * z)
        x, y, z = x * shorter, y * shorter, z * shorter
        square_x, square_y = _direction_to_square(x, y, z)
        column = min(np.int32(square_x * scale), top)
        row = min(np.int32(square_y * scale), top)
        cells[j] = spread_bits(column) | (spread_bits(row) << np.int32(1))
        weights[j] = jacobian * shorter * shorter * shorter


@kernel
def _read_row(lookup, row, parts, values):
    """Magnitude of the samples of a row of the map; ``parts`` samples a texel, each way."""
    texels, strength = lookup.texels, lookup.strength
    n = len(values)
    if parts == 1 and lookup.interpolation != 2:
        red = np.float32(LUMINANCE_R) * abs(strength[0])
        green = np.float32(LUMINANCE_G) * abs(strength[1])
        blue = np.float32(LUMINANCE_B) * abs(strength[2])
        for j in range(n):
            values[j] = (
                red * abs(texels[row, j, 0])
                + green * abs(texels[row, j, 1])
                + blue * abs(texels[row, j, 2])
            )
        return
    v = np.float32((row + 0.5) / (parts * texels.shape[0]))
    for j in range(n):
        r, g, b = eval_map(lookup, np.float32((j + 0.5) / n), v)
        values[j] = magnitude(r, g, b)


@kernel
def _add_rows(lookup, inverse, determinant, around, parts, side, first, last, scratch, sums):
    """Add samples of rows first ... last - 1 to sums, float32 (cells, 3): w L, w L^2, w."""
    cells, weights, values = scratch
    step = math.pi / (parts * lookup.texels.shape[0])
    for row in range(first, last):
        latitude = (row + 0.5) * step - 0.5 * math.pi
        sine, cosine = math.sin(latitude), math.cos(latitude)
        jacobian = np.float32(cosine * step * determinant)
        _find_cells(
            inverse, jacobian, around, np.float32(sine), np.float32(cosine), side, cells, weights
        )
        _read_row(lookup, row, parts, values)
        for j in range(len(cells)):
            cell, weight, value = cells[j], weights[j], values[j]
            bounded = min(value, LARGEST)
            sums[cell, 0] += weight * value
            sums[cell, 1] += weight * bounded * bounded
            sums[cell, 2] += weight


@kernel
def _fill_gaps(lookup, level, sums):
    """Turn sums into means; look up what no sample fell into."""
    side = 1 << level
    size = np.float32(1.0 / side)
    for row in range(side):
        for column in range(side):
            cell = spread_bits(np.int32(column)) | (spread_bits(np.int32(row)) << np.int32(1))
            if sums[cell, 2] > np.float32(0.0):
                inverse = np.float32(1.0) / sums[cell, 2]
                sums[cell, 0] *= inverse
                sums[cell, 1] *= inverse
            else:
                x, y = np.float32(column) * size, np.float32(row) * size
                sums[cell, 0], sums[cell, 1], _ = look_up_cell(lookup, x, y, size, 2)


@kernel
def _look_around(level, first, last, cells):
    """Allow rows first ... last - 1 for light from the cells round them."""
    side = 1 << level
    for row in range(first, last):
        for column in range(side):
            brightest = largest = np.float32(0.0)
            for i in range(row - 1, row + 2):
                for j in range(column - 1, column + 2):
                    near = cell_beside(i, j, side)
                    if cells[near, 1] > np.float32(0.0):  # not only lent by its own neighbour
                        brightest = max(brightest, cells[near, 0])
                        largest = max(largest, cells[near, 1])
            cell = cell_beside(row, column, side)
            cells[cell, 0] = max(cells[cell, 0], brightest * np.float32(1.0 / 1024))
            cells[cell, 2] = max(cells[cell, 1], largest * _TAIL)


@kernel
def _compact(n, numbers):
    """Close up rows of (mean, -, square)."""
    for k in range(n):
        numbers[2 * k], numbers[2 * k + 1] = numbers[3 * k], numbers[3 * k + 2]


@kernel
def _sum_up_cells(level, finest, mean, square):
    begin = level_offset(level - 1)
    for k in range(1 << (2 * (level - 1))):
        a, b, c, d = finest[4 * k], finest[4 * k + 1], finest[4 * k + 2], finest[4 * k + 3]
        mean[begin + k] = np.float32(0.25) * (a[0] + b[0] + c[0] + d[0])
        square[begin + k] = np.float32(0.25) * (a[1] + b[1] + c[1] + d[1])


@kernel
def sum_up(values, levels):
    """Write the averages of levels levels - 1 ... 0 from those of the finest."""
    for level in range(levels - 1, -1, -1):
        here, below = level_offset(level), level_offset(level + 1)
        for k in range(1 << (2 * level)):
            child = below + 4 * k
            values[here + k] = np.float32(0.25) * (
                values[child] + values[child + 1] + values[child + 2] + values[child + 3]
            )


def _inverse_of(lookup: EnvironmentLookup) -> np.ndarray | None:
    """float32 (3, 3), map direction -> world direction, where there is one."""
    linear = lookup.matrix[:, :3].astype(np.float64)
    if lookup.projection != 0 or lookup.matrix[:, 3].any():
        return None
    if abs(np.linalg.det(linear)) < 1e-6 * np.linalg.norm(linear) ** 3:
        return None
    return np.linalg.inv(linear / np.linalg.norm(linear)).astype(np.float32)


def _in_steps(n, size, work, progress) -> None:
    for first in range(0, n, size):
        progress(first / n)
        work(first, min(first + size, n))


def _splat(lookup, inverse, level, sums, progress) -> None:
    height, width = lookup.texels.shape[:2]
    # As many samples a texel that every cell meets some.
    parts = max(1, math.ceil((1 << level) * _TEXELS_A_CELL * 1.2 / width))
    n = parts * width
    longitude = (0.5 - (np.arange(n) + 0.5) / n) * (2.0 * np.pi)
    around = np.stack([np.cos(longitude), np.sin(longitude)], -1).astype(np.float32)
    scratch = np.empty(n, np.int32), np.empty(n, np.float32), np.empty(n, np.float32)
    determinant = abs(float(np.linalg.det(inverse.astype(np.float64))))
    fixed = lookup, inverse, determinant, around, parts, 1 << level

    def work(first, last):
        _add_rows(*fixed, first, last, scratch, sums)

    _in_steps(parts * height, max(1, _CHUNK // n), work, progress)


def _fill(lookup, level, cells, progress) -> float:
    """Write mean and possible mean square into columns 0 and 2; returns the sphere's mean."""
    inverse = _inverse_of(lookup)
    if inverse is None:

        def look_up(first, last):
            look_up_cells(lookup, level, first, last, cells)

        _in_steps(len(cells), _CHUNK // 64, look_up, progress)
        total = cells[:, 0].mean(dtype=np.float64)
    else:
        _splat(lookup, inverse, level, cells, progress)
        total = cells[:, 0].sum(dtype=np.float64) / cells[:, 2].sum(dtype=np.float64)
        _fill_gaps(lookup, level, cells)

    def look_around(first, last):
        _look_around(level, first, last, cells)

    _in_steps(1 << level, max(1, _CHUNK >> level), look_around, lambda _: progress(1.0))
    return float(total)


def cell_light(lookup: EnvironmentLookup, progress=lambda fraction: None) -> CellLight:
    """The statistics of a map; progress is told every few milliseconds, and may raise to stop."""
    width = lookup.texels.shape[1]
    level = int(np.clip(round(math.log2(width / _TEXELS_A_CELL)) - 1, WHOLE_LEVELS, _MAX_LEVEL))
    n, coarser = 1 << (2 * level), level_offset(level)
    numbers = np.zeros(3 * n, np.float32)
    total = _fill(lookup, level, numbers.reshape(n, 3), progress)
    _compact(n, numbers)
    numbers.resize(2 * n, refcheck=False)  # in place: 17 MB of an 8K map's peak
    finest = numbers.reshape(n, 2)
    light = CellLight(
        finest, np.empty(coarser, np.float32), np.empty(coarser, np.float32), level, total
    )
    _sum_up_cells(level, finest, light.mean, light.square)
    sum_up(light.mean, level - 1)
    sum_up(light.square, level - 1)
    return light
