"""Mode PAPER: samples go down the sparse Haar product, I_d = I_s K / N [Huang07].

A point's BRDF is a sum of table slices times colours ("parts", paper_tables.N_PARTS). A part is
chosen in proportion to its share of I_s, by the same number that then goes on down the tree. Where
a product's mean is negative (truncated series ring) it counts as 0.
"""

from __future__ import annotations

import numpy as np

from .._jit import kernel
from ..bsdf.lobes import Lobes
from ..embree.accel import start_shadow_ray
from ..geometry.shading import ShadingPoints
from ..sampling.incremental import RayBatch
from ..unit_square.sequence import PixelSequence, sequence_point
from ..unit_square.sphere_map import square_to_hemisphere
from ..wavelets.haar_product import ProductTrees, new_scratch, warp_tree
from .paper_products import (
    Products,
    build_trees,
    count_nodes,
    integrate_products,
    light_weights,
    new_integral_scratch,
)
from .paper_tables import N_PARTS, PaperTables


@kernel
def _sample_direction(tables, products, trees, weights, p, x, y):
    """Where (x, y) of the unit square goes at point p: (dx, dy, dz), float64, world space."""
    part = 0
    while part < N_PARTS - 1 and x >= products.share[p, part]:
        x -= products.share[p, part]
        part += 1
    while part > 0 and products.share[p, part] <= 0.0:
        part -= 1  # rounding can step past the last part
    x = min(x / products.share[p, part], 0.9999999999999999)
    light_weights(products.colors[p, part], weights)
    u, v, _ = warp_tree(tables.light, tables.brdf, weights, trees, products.root[p, part], x, y)
    lx, ly, lz = square_to_hemisphere(u, v)
    frame = tables.frames[products.light_slice[p]]
    return (
        lx * frame[0, 0] + ly * frame[1, 0] + lz * frame[2, 0],
        lx * frame[0, 1] + ly * frame[1, 1] + lz * frame[2, 1],
        lx * frame[0, 2] + ly * frame[1, 2] + lz * frame[2, 2],
    )


@kernel
def _sample_round(
    tables, products, trees, points, sequence, weights, offset, active, first, counts, rays
):
    """Rays that leave the surface; those below it are occluded, which needs no ray.

    weights: float32 (3,), scratch
    """
    n = 0
    for a in range(len(active)):
        p = active[a]
        for k in range(first, first + counts[a]):
            x, y = sequence_point(sequence, p, k)
            dx, dy, dz = _sample_direction(tables, products, trees, weights, p, x, y)
            wx, wy, wz = np.float32(dx), np.float32(dy), np.float32(dz)
            if not start_shadow_ray(points, p, wx, wy, wz, False, offset, rays.origins, n):
                continue
            rays.directions[n, 0], rays.directions[n, 1], rays.directions[n, 2] = wx, wy, wz
            rays.point[n] = p
            for c in range(3):
                rays.diffuse[n, c] = products.diffuse[p, c]
                rays.glossy[n, c] = products.glossy[p, c]
            n += 1
    return n


class PaperSampler:
    """Sparse product sampling of the points of one tile (incremental.Sampler).

    rows: int32 (n,), material of each point
    """

    def __init__(
        self,
        points: ShadingPoints,
        lobes: Lobes,
        rows: np.ndarray,
        tables: PaperTables,
        sequence: PixelSequence,
        offset: float,
    ):
        n = len(points.pixel)
        self._points, self._tables = points, tables
        self._sequence, self._offset = sequence, np.float32(offset)
        self.products = Products(
            np.zeros(n, np.int32),
            np.full((n, N_PARTS), -1, np.int32),
            np.zeros((n, N_PARTS, 3), np.float32),
            np.full((n, N_PARTS), -1, np.int32),
            np.zeros((n, N_PARTS), np.float32),
            np.zeros((n, 3), np.float32),
            np.zeros((n, 3), np.float32),
        )
        self._weights = np.empty(3, np.float32)
        integrate_products(tables, rows, lobes, new_integral_scratch(), self.products)
        scratch = new_scratch()
        size = count_nodes(tables, self.products, scratch)
        self._trees = ProductTrees(np.empty((size, 4), np.float32), np.empty((size, 4), np.int32))
        build_trees(tables, self.products, scratch, self._weights, self._trees)

    def direction(self, p: int, x: float, y: float) -> tuple[float, float, float]:
        """Where (x, y) of the unit square goes at point p: unit, world space."""
        return _sample_direction(
            self._tables, self.products, self._trees, self._weights, p, float(x), float(y)
        )

    def frame(self, p: int) -> np.ndarray:
        """Of the slice that point p samples: float32 (3, 3), rows t, b, n."""
        return self._tables.frames[self.products.light_slice[p]]

    def lit(self) -> np.ndarray:
        """See incremental.Sampler."""
        return self.products.share.any(axis=1)

    def unoccluded(self) -> np.ndarray:
        """I_s: float32 (n, 3)."""
        return self.products.diffuse + self.products.glossy

    def sample(self, active: np.ndarray, first: int, counts: np.ndarray, rays: RayBatch) -> int:
        """See incremental.Sampler."""
        return _sample_round(
            self._tables,
            self.products,
            self._trees,
            self._points,
            self._sequence,
            self._weights,
            self._offset,
            active,
            first,
            counts,
            rays,
        )
