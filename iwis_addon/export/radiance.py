"""Radiance that can be rendered: finite and not negative."""

from __future__ import annotations

import logging

import numpy as np

log = logging.getLogger(__name__)

# Filters and compression leave tiny negative texels in many a good HDRI. Without them the light
# changes by less than the 0.1 % to which the world agrees with Cycles: nobody need be told.
_UNNOTICED = 1e-3
_LARGEST = 65504.0  # of a half float: for infinity in a map that has nothing finite
# The sun is 1e9 times as bright as a room. Sums over the map and its products must not overflow.
BRIGHTEST_TEXEL, STRONGEST = 1e15, 1e10


def mend_radiance(radiance: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """The map with nothing but finite values >= 0, and what was changed, a line for each kind.

    radiance: float (3,) or (h, w, 3). Returns a C-contiguous float32 array, the same one if it is
    good. NaN and negative values become 0, infinity and what overflows the largest good value.
    """
    radiance = np.ascontiguousarray(radiance, np.float32)
    if radiance.min() >= 0.0 and radiance.max() <= BRIGHTEST_TEXEL:
        return radiance, []
    nan = np.isnan(radiance)
    with np.errstate(invalid="ignore"):
        negative, infinite = radiance < 0.0, radiance > BRIGHTEST_TEXEL
    usable = ~(nan | infinite | negative)
    largest = np.max(radiance, where=usable, initial=0.0)
    largest = np.float32(largest if largest > 0.0 else _LARGEST)
    share = _share_of(radiance, negative, usable)
    too_bright = "infinite" if np.isposinf(radiance[infinite]).all() else "too bright to render"
    notes = []
    for mask, what, now in (
        (nan, "NaN", 0.0),
        (negative, "negative", 0.0),
        (infinite, too_bright, largest),
    ):
        if not mask.any():
            continue
        texels = f"{int(mask.any(axis=-1).sum())} of {radiance[..., 0].size} texels are"
        note = f"{texels if radiance.ndim > 1 else 'is'} {what}: {now:g} instead"
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
