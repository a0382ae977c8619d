"""Mode UNBIASED's samples as rays, for comparisons, tests and whoever wants to see every ray."""

from __future__ import annotations

import numpy as np

from .._jit import kernel
from ..bsdf.lobes import DIFFUSE_LOBE, Lobes
from ..embree.embree_rays import NOTHING
from ..geometry.shading import ShadingPoints
from ..products.guide import new_guides
from ..products.like_products import NEARLY_ALIKE, build_products
from ..products.product import new_products
from ..unit_square.sequence import PixelSequence
from .incremental import RayBatch, new_sums
from .light_rays import Light
from .unbiased import Task, new_work, take_samples


class UnbiasedSampler:
    """Product sampling of some points as rays (incremental.Sampler).

    A render takes block_loop.continue_blocks, which makes the same samples and traces them at once.
    offset: metres that a shadow ray starts off its surface; apart: of build_products; bounds: int,
    where blocks of points begin, and their number; None: one block
    """

    def __init__(
        self,
        points: ShadingPoints,
        lobes: Lobes,
        light: Light,
        sequence: PixelSequence,
        offset: float,
        apart: np.float32 = NEARLY_ALIKE,
        bounds: np.ndarray | None = None,
    ):
        glossy = bool((lobes.kind > DIFFUSE_LOBE).any())
        products, self._work = new_products(len(points.pixel), glossy), new_work()
        bounds = np.array([0, len(points.pixel)]) if bounds is None else bounds
        _build_blocks(bounds, lobes, apart, light, products, self._work.scratch)
        own = products, new_guides(0), sequence, np.float32(offset)
        self._task = Task(points, lobes, light, *own)

    def lit(self) -> np.ndarray:
        """See incremental.Sampler."""
        products = self._task.products
        return products.trees[products.own, 0] > 0.0

    def unoccluded(self) -> None:
        """See incremental.Sampler: only the samples know it."""

    def sample(self, active: np.ndarray, first: int, counts: np.ndarray, rays: RayBatch) -> int:
        """See incremental.Sampler."""
        own = self._task, self._work, active, len(active), first, counts
        return take_samples(*own, NOTHING, new_sums(0), rays)


@kernel
def _build_blocks(bounds, lobes, apart, light, products, scratch):
    for block in range(len(bounds) - 1):
        first, end = bounds[block], bounds[block + 1]
        build_products(lobes, first, end, apart, light, products, scratch)
