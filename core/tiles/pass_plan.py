"""How many passes the pixels of a tile want, and how many of them are taken at once.

A pixel whose neighbourhood shows one object, or nothing but the world, may end after PILOT passes;
one near a silhouette takes at least _SILHOUETTE / E. Else a leaf that the pilot missed would be
lost, and one that it hit would not be: thin leaves before the sky came out half as dark. Edges
between colors, and of reflections, are told by the light of the pixels around (light_edges.py).

Where the world has light below 0 (environment.takes_away), a pixel that has not met it looks bright
and sure: one that ends by its own samples came out up to 1 % too bright. All of a cell end alike.

Points of several passes that are alike share a product (like_products.py), so passes are taken
together: a window's first ones alone, for a picture at once, a render's by four, later ones by
eight. Which passes are taken together is the same however often a tile pauses, and so is the
picture.
"""

from __future__ import annotations

import numpy as np

from ..camera.pass_rays import PILOT
from ..camera.silhouettes import Silhouettes
from ..passes.light_edges import add_edges
from ..passes.lucky_passes import raise_lucky
from ..passes.pass_sums import PassSums, cell_spreads, fill_spreads, seldom_spreads
from ..sampling.stop_rule import FLOOR, plan_counts, threshold_of, typical_count
from ..settings import RenderSettings

_SILHOUETTE = 1.2


def end_of_batch(passes: int, together: int, first: int = PILOT) -> int:
    """Where passes that are taken at once end, after so many: 4, 8, 16, 24 ... for 8 and 4.

    together, first: 1 or powers of two, the most that are taken at once, and how many at first
    """
    size = min(together, max(first, 1 << (max(passes, 1).bit_length() - 1)))
    return (passes // size + 1) * size


class PassPlan:
    """What the pixels of a tile want, by its stop rule and what is known of them.

    settings: of the render; batch: samples of a pass; with_alpha: of a transparent film
    """

    def __init__(
        self,
        settings: RenderSettings,
        batch: int,
        with_alpha: bool,
        silhouettes: Silhouettes,
        pixels: np.ndarray,
        cell: np.ndarray,
        by_cells: bool = False,
    ):
        """pixels: int32, that are sampled, cell by cell; cell: int32, of each row, -1 = none

        by_cells: counts are decided by cells, not pixels: of light that takes away
        """
        self._settings, self._batch, self._with_alpha = settings, batch, with_alpha
        self._silhouettes, self._pixels, self._cell = silhouettes, pixels, cell
        self._n_cells, self._by_cells = int(cell.max()) + 1, by_cells

    def wanted(self, active: np.ndarray, passes: int, sums: PassSums) -> np.ndarray:
        """Passes, int32, that each active pixel, int32, is to have, when some have ``passes``.

        sums: as the stop rule is to see them (TileLamps.known)
        """
        settings = self._settings
        most = -(-settings.max_samples // self._batch)
        endless = settings.stop_rule == "FIXED" or settings.error_threshold == 0.0
        if endless or passes < PILOT:
            return np.full(len(active), most, np.int32)
        if settings.stop_rule == "PAPER":
            unsure = sums.error[active] > settings.error_threshold
            wanted = sums.passes[active] + unsure.astype(np.int32)
        else:
            wanted = self._perceptual(active, sums)
        least = int(np.ceil(_SILHOUETTE / settings.error_threshold))
        near = self._silhouettes.near()[active]
        return np.minimum(np.where(near, np.maximum(wanted, least), wanted), most)

    def least_of_edges(self) -> np.float32:
        """Of sqrt(T): what a budget gives pixels near silhouettes at the least."""
        return np.float32(self._batch * _SILHOUETTE / threshold_of(1.0))

    def spreads(self, pixels: np.ndarray, typical: float, sums: PassSums) -> np.ndarray:
        """float32, r of pixels; of blurred ones, or by cells, that of their cell.

        typical: T; sums: as above
        """
        blurred = self._silhouettes.blurred | self._by_cells
        blurred_ones = self._pixels[blurred[self._pixels]]

        def own(some):
            spread = np.empty(len(some), np.float32)
            fill_spreads(some, self._batch, FLOOR / typical, self._with_alpha, sums, spread)
            return spread

        spread = own(pixels)
        raise_lucky(pixels, self._cell, self._silhouettes.width, sums, spread)
        add_edges(pixels, self._cell, self._silhouettes.width, self._batch, sums, spread)
        if len(blurred_ones):
            passes, light = sums.passes[blurred_ones], sums.light[blurred_ones]
            cell = self._cell[blurred_ones]
            shared = cell_spreads(cell, self._n_cells, passes, light, own(blurred_ones))
            which = blurred[pixels]
            spread[which] = shared[self._cell[pixels[which]]]
        if self._by_cells:
            add_edges(pixels, self._cell, self._silhouettes.width, self._batch, sums, spread)
        every, cell = self._pixels, self._cell
        known = sums.passes[every], sums.light[every], own(every)
        seldom = seldom_spreads(cell[every], self._n_cells, self._batch, *known)
        return np.maximum(spread, seldom[cell[pixels]])

    def _perceptual(self, active, sums) -> np.ndarray:
        """PERCEPTUAL: N = T r^.75, in passes."""
        typical, n = typical_count(self._settings.error_threshold), np.int32(self._batch)
        taken = sums.passes[active] * n
        spread = self.spreads(active, typical, sums)
        return -(-plan_counts(spread, taken, typical, self._settings.max_samples) // n)
