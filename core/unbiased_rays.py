"""Mode UNBIASED's samples as rays, for comparisons, tests and whoever wants to see every ray."""

from __future__ import annotations

import numpy as np

from .embree_rays import NOTHING
from .guide import new_guides
from .incremental import RayBatch, new_sums
from .light_rays import Light
from .lobes import DIFFUSE_LOBE, Lobes
from .product import new_products
from .sequence import PixelSequence
from .shading import ShadingPoints
from .unbiased import Task, build_products, new_work, take_samples


class UnbiasedSampler:
    """Product sampling of some points as rays (incremental.Sampler).

    A render takes block_loop.continue_blocks, which makes the same samples and traces them at once.
    offset: metres that a shadow ray starts off its surface
    """

    def __init__(
        self,
        points: ShadingPoints,
        lobes: Lobes,
        light: Light,
        sequence: PixelSequence,
        offset: float,
    ):
        glossy = bool((lobes.kind > DIFFUSE_LOBE).any())
        products, self._work = new_products(len(points.pixel), glossy), new_work()
        build_products(lobes, light, products, self._work.scratch)
        own = products, new_guides(0), sequence, np.float32(offset)
        self._task = Task(points, lobes, light, *own)

    def lit(self) -> np.ndarray:
        """See incremental.Sampler."""
        return self._task.products.trees[:, 0] > 0.0

    def unoccluded(self) -> None:
        """See incremental.Sampler: only the samples know it."""

    def sample(self, active: np.ndarray, first: int, counts: np.ndarray, rays: RayBatch) -> int:
        """See incremental.Sampler."""
        own = self._task, self._work, active, len(active), first, counts
        return take_samples(*own, NOTHING, new_sums(0), rays)
