"""Radiance that can be rendered: finite and not negative."""

from __future__ import annotations

import logging

import numpy as np

log = logging.getLogger(__name__)

# Filters and compression leave tiny negative texels in many a good HDRI. Without them the light
# changes by less than the 0.1 % to which the world agrees with Cycles: nobody need be told.
_UNNOTICED = 1e-3
_LARGEST = 65504.0  # of a half float: for infinity in a map that has nothing finite


def mend_radiance(radiance: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """The map with nothing but finite values >= 0, and what was changed, a line for each kind.

    radiance: float (3,) or (h, w, 3). Returns a C-contiguous float32 array, the same one if it is
    good. NaN and negative values become 0, infinity the largest finite value.
    """
    radiance = np.ascontiguousarray(radiance, np.float32)
    if radiance.min() >= 0.0 and radiance.max() < np.inf:
        return radiance, []
    nan, infinite = np.isnan(radiance), np.isposinf(radiance)
    with np.errstate(invalid="ignore"):
        negative = radiance < 0.0
    usable = ~(nan | infinite | negative)
    largest = np.max(radiance, where=usable, initial=0.0)
    largest = np.float32(largest if largest > 0.0 else _LARGEST)
    share = _share_of(radiance, negative, usable)
    notes = []
    for mask, what, now in (
        (nan, "NaN", 0.0),
        (negative, "negative", 0.0),
        (infinite, "infinite", largest),
    ):
        if not mask.any():
            continue
        note = (
            f"{int(mask.any(axis=-1).sum())} of {radiance[..., 0].size} texels are {what}: "
            f"{now:g} instead"
        )
        if mask is negative and share <= _UNNOTICED:
            log.debug("%s, %.2g of all light", note, share)
        else:
            notes.append(note)
    mended = np.where(usable, radiance, np.float32(0.0))
    mended[infinite] = largest
    return mended, notes


def _share_of(radiance, negative, usable) -> float:
    """Radiance of the negative texels, as a fraction of that of the good ones."""
    total = radiance.sum(dtype=np.float64, where=usable)
    missing = -radiance.sum(dtype=np.float64, where=negative)
    return missing / total if total > 0.0 else np.inf
