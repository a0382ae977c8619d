"""Two-stage sampling of light x BRDF, to compare with [Cline06]. Not used by any picture.

First stage: the sphere is cut into REGIONS cells of the light's quadtree, always the one with the
most light x BRDF next; of them one is drawn in proportion to mean light x (BRDF at five places).
Second stage: a direction in it, in proportion to the light alone. [Cline06] finds where to cut by
peaks of the BRDF and cuts a summed-area table; the quadtree and the mean BRDF stand in here.
continue_adaptively() gives each pixel the samples that a pilot's variance asks for: the adaptive
strategy that [Huang07] compares itself with.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.brdf import eval_at
from ..bsdf.lobes import Lobes
from ..bsdf.lobes_at import lobes_at
from ..bsdf.luminance import luminance
from ..embree.accel import Accel
from ..geometry.shading import ShadingPoints
from ..light.environment import eval_environment
from ..light.pyramid import level_offset, morton_to_row_column
from ..sampling.incremental import PixelSums, RayBatch, continue_points
from ..sampling.light_rays import Light, write_ray
from ..sampling.stop_rule import paper_rule, perceptual_rule, relative_error
from ..unit_square.sequence import PixelSequence, sample_number, sequence_point
from ..unit_square.sphere_map import square_to_sphere
from .reference import sample_light_in

_FIRST_LEVEL = 2
REGIONS = 127  # 4^2 cells to begin with, 3 more with each of 37 cuts
_FLOOR = np.float32(0.02)  # of the mean BRDF x cosine: no region with light is left without samples
_BELOW_ONE = 0.9999999999999999
PILOT = 8


class Regions(NamedTuple):
    """The regions of n points: cell, level: int32 (n, REGIONS); weight: float32 (n, REGIONS), adds
    up to total: float32 (n,).
    """

    cell: np.ndarray
    level: np.ndarray
    weight: np.ndarray
    total: np.ndarray


@kernel
def _brdf_cos(at, x, y):
    """Luminance of BRDF x cosine towards a point of the sphere's square."""
    dx, dy, dz = square_to_sphere(x, y)
    dr, dg, db, gr, gg, gb = eval_at(at, np.float32(dx), np.float32(dy), np.float32(dz))
    return luminance(dr + gr, dg + gg, db + gb)


@kernel
def _region_weight(at, pyramid, cell, level):
    """Mean light x mean BRDF x cosine of a cell, times its part of the sphere."""
    row, column = morton_to_row_column(cell)
    side = 1 << level
    brdf = _brdf_cos(at, (column + 0.5) / side, (row + 0.5) / side)
    for q in range(4):
        x, y = column + 0.25 + 0.5 * (q & 1), row + 0.25 + 0.5 * (q >> 1)
        brdf += _brdf_cos(at, x / side, y / side)
    light = pyramid.averages[level_offset(level) + cell]
    share = np.float32(1.0 / (1 << (2 * level)))
    return light * (np.float32(0.2) * brdf + _FLOOR) * share


@kernel
def _cut_regions(lobes, pyramid, regions):
    for p in range(len(regions.total)):
        at = lobes_at(lobes, p)
        cell, level, weight = regions.cell[p], regions.level[p], regions.weight[p]
        n = 1 << (2 * _FIRST_LEVEL)
        for k in range(n):
            cell[k], level[k] = k, _FIRST_LEVEL
            weight[k] = _region_weight(at, pyramid, k, _FIRST_LEVEL)
        while n + 3 <= REGIONS:
            most = np.argmax(weight[:n])
            if weight[most] <= 0.0 or level[most] >= pyramid.levels:
                break
            parent, deeper = 4 * np.int64(cell[most]), np.int64(level[most]) + 1
            for q in range(4):
                k = most if q == 0 else n + q - 1
                cell[k], level[k] = parent + q, deeper
                weight[k] = _region_weight(at, pyramid, parent + q, deeper)
            n += 3
        weight[n:] = 0.0
        regions.total[p] = weight.sum()


@kernel
def _sample_round(points, lobes, light, regions, sequence, offset, active, first, counts, rays):
    n = 0
    for a in range(len(active)):
        p = active[a]
        at, total = lobes_at(lobes, p), np.float64(regions.total[p])
        for k in range(first, first + counts[a]):
            x, y = sequence_point(sequence, p, k)
            x *= total
            chosen = 0
            while chosen < REGIONS - 1 and x >= regions.weight[p, chosen]:
                x -= regions.weight[p, chosen]
                chosen += 1
            weight = np.float64(regions.weight[p, chosen])
            if weight <= 0.0:  # rounding can step past the last region
                continue
            cell, level = np.int64(regions.cell[p, chosen]), np.int64(regions.level[p, chosen])
            dx, dy, dz, pdf = sample_light_in(
                light.pyramid, cell, level, min(x / weight, _BELOW_ONE), y
            )
            wi = np.float32(dx), np.float32(dy), np.float32(dz)
            radiance = eval_environment(light.lookup, wi[0], wi[1], wi[2])
            u, density = sample_number(sequence, p, k), np.float32(pdf * weight / total)
            n = write_ray(at, points, light, p, wi, radiance, density, u, offset, rays, n)
    return n


class TwoStageSampler:
    """Two-stage sampling of the points of one tile (incremental.Sampler)."""

    def __init__(
        self,
        points: ShadingPoints,
        lobes: Lobes,
        light: Light,
        sequence: PixelSequence,
        offset: float,
    ):
        n = len(points.pixel)
        self._points, self._lobes, self._light = points, lobes, light
        self._sequence, self._offset = sequence, np.float32(offset)
        self._regions = Regions(
            np.zeros((n, REGIONS), np.int32),
            np.zeros((n, REGIONS), np.int32),
            np.zeros((n, REGIONS), np.float32),
            np.zeros(n, np.float32),
        )
        _cut_regions(lobes, light.pyramid, self._regions)

    def lit(self) -> np.ndarray:
        """See incremental.Sampler."""
        return (self._lobes.kind != 0) & (self._regions.total > 0.0)

    def unoccluded(self) -> None:
        """See incremental.Sampler: only the samples know it."""

    def sample(self, active: np.ndarray, first: int, counts: np.ndarray, rays: RayBatch) -> int:
        """See incremental.Sampler."""
        return _sample_round(
            self._points,
            self._lobes,
            self._light,
            self._regions,
            self._sequence,
            self._offset,
            active,
            first,
            counts,
            rays,
        )


def continue_adaptively(
    sampler: TwoStageSampler, sums: PixelSums, accel: Accel, threshold: float, most: int
) -> int:
    """A pilot, then as many samples as bring its relative error to ``threshold``: rays traced.

    sums: PixelSums of no samples yet; most: samples of a point at the most
    """
    pilot = min(PILOT, most)
    traced = continue_points(sampler, sums, accel, paper_rule(-1.0, pilot, pilot))
    errors = [
        relative_error(*state)
        for state in zip(sums.count, sums.seen, sums.seen_squared, strict=True)
    ]
    more = np.ceil(pilot * np.minimum((np.array(errors) / threshold) ** 2, most / pilot))
    plan = np.where(sampler.lit(), np.clip(more, pilot, most), 0).astype(np.int32)
    return traced + continue_points(sampler, sums, accel, perceptual_rule(1.0, most, plan))
