"""Plain estimators to compare with: light, BSDF and MIS sampling, and WIS [Clarberg05].

Not used by any picture; tests and benchmarks run them through the same loop and film.
MIS is the one-sample balance heuristic, half the samples from each: its pdf is the mean of both.
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from ..bsdf.brdf import pdf_at, sample_at
from ..bsdf.lobes import Lobes
from ..bsdf.lobes_at import lobes_at
from ..geometry.shading import ShadingPoints
from ..light.environment import eval_environment
from ..light.pyramid import level_offset, morton_to_row_column, pdf_light
from ..paper_mode.paper import PaperSampler
from ..sampling.incremental import RayBatch
from ..sampling.light_rays import Light, write_ray
from ..unit_square.halton import radical_inverse_2
from ..unit_square.sequence import PixelSequence, sample_number, sequence_point, to_bits
from ..unit_square.sphere_map import square_to_sphere

# Part of the samples that follow the BSDF.
LIGHT_SAMPLING, BSDF_SAMPLING, MIS_SAMPLING = 0.0, 1.0, 0.5
_BELOW_ONE = 0.9999999999999999


@kernel(forceinline=True)
def descend(a, b, c, d, x, y):
    """One step of the hierarchical warp: (quadrant, x, y) [Clarberg05], split by rows first.

    Products with 0 and 1 in place of branches, which nobody could predict; one division.
    """
    top, bottom = a + b, c + d
    y *= top + bottom
    low = np.float64(y >= top)
    high = 1.0 - low
    y -= low * top
    row, left, right = high * top + low * bottom, high * a + low * c, high * b + low * d
    x *= row
    far = np.float64(x >= left)
    x -= far * left
    cell = (1.0 - far) * left + far * right
    inverse = 1.0 / (row * cell)
    quadrant = np.int64(low + low + far)
    return quadrant, min(x * (row * inverse), _BELOW_ONE), min(y * (cell * inverse), _BELOW_ONE)


@kernel
def sample_light_in(pyramid, cell, level, x, y):
    """A direction in a cell, in proportion to the light's luminance: (dx, dy, dz, pdf in sr^-1).

    cell: Morton index of one of the ``level``, one of the pyramid's whole levels
    """
    averages, levels, children = pyramid.averages, pyramid.levels, pyramid.children
    node = level_offset(level) + cell
    per_cell = (1 << (2 * level)) / (4.0 * math.pi * np.float64(averages[node]))
    while level < levels or children[node] > 0:
        below = np.int64(children[node])
        if level < levels:
            below = level_offset(level + 1) + 4 * cell
        quadrant, x, y = descend(
            np.float64(averages[below]),
            np.float64(averages[below + 1]),
            np.float64(averages[below + 2]),
            np.float64(averages[below + 3]),
            x,
            y,
        )
        cell, node, level = 4 * cell + quadrant, below + quadrant, level + 1
    row, column = morton_to_row_column(cell)
    side = 1 << level
    dx, dy, dz = square_to_sphere((column + x) / side, (row + y) / side)
    return dx, dy, dz, np.float64(averages[node]) * per_cell


@kernel
def sample_light(pyramid, x, y):
    """A direction in proportion to the light's luminance: (dx, dy, dz, pdf in sr^-1)."""
    return sample_light_in(pyramid, 0, 0, x, y)


@kernel
def _sample_round(points, lobes, light, share, sequence, offset, active, first, counts, rays):
    n = 0
    for a in range(len(active)):
        p = active[a]
        at = lobes_at(lobes, p)
        for k in range(first, first + counts[a]):
            x, y = sequence_point(sequence, p, k)
            if x < share:
                wx, wy, wz, _ = sample_at(at, np.float32(x / share), np.float32(y))
                dx, dy, dz = np.float64(wx), np.float64(wy), np.float64(wz)
                from_light = pdf_light(light.pyramid, dx, dy, dz)
            else:
                x = (x - share) / (1.0 - share)
                dx, dy, dz, from_light = sample_light(light.pyramid, x, y)
                wx, wy, wz = np.float32(dx), np.float32(dy), np.float32(dz)
            pdf = np.float32(
                share * np.float64(pdf_at(at, wx, wy, wz)) + (1.0 - share) * from_light
            )
            radiance = eval_environment(light.lookup, wx, wy, wz)
            u = sample_number(sequence, p, k)
            n = write_ray(at, points, light, p, (wx, wy, wz), radiance, pdf, u, offset, rays, n)
    return n


class MixtureSampler:
    """Light, BSDF or MIS sampling of the points of one tile (incremental.Sampler).

    share: the part of the samples that follow the BSDF: one of the three constants above
    """

    def __init__(
        self,
        points: ShadingPoints,
        lobes: Lobes,
        light: Light,
        share: float,
        sequence: PixelSequence,
        offset: float,
    ):
        self._points, self._lobes, self._light, self._share = points, lobes, light, float(share)
        self._sequence, self._offset = sequence, np.float32(offset)

    def lit(self) -> np.ndarray:
        """See incremental.Sampler."""
        dark = self._light.pyramid.averages[0] <= 0.0
        return (self._lobes.kind != 0) & (not dark)

    def unoccluded(self) -> None:
        """See incremental.Sampler: only the samples know it."""

    def sample(self, active: np.ndarray, first: int, counts: np.ndarray, rays: RayBatch) -> int:
        """See incremental.Sampler."""
        return _sample_round(
            self._points,
            self._lobes,
            self._light,
            self._share,
            self._sequence,
            self._offset,
            active,
            first,
            counts,
            rays,
        )


def hammersley_points(count: int) -> np.ndarray:
    """uint32 (count, 2): k / count and the radical inverse of k: good for this count only."""
    return to_bits(np.array([((k + 0.5) / count, radical_inverse_2(k)) for k in range(count)]))


def make_wis(points, lobes, rows, tables, sequence, count: int, offset: float) -> PaperSampler:
    """Wavelet importance sampling: the paper's product with ``count`` Hammersley points.

    sequence: its shifts are used (decorrelation PIXEL or NONE)
    """
    hammersley = sequence._replace(points=hammersley_points(count))
    return PaperSampler(points, lobes, rows, tables, hammersley, offset)
