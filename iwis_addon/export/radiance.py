"""Radiance that can be rendered: finite. Negative light takes away, as in Cycles."""

from __future__ import annotations

import numpy as np

_LARGEST = 65504.0  # of a half float: for infinity in a map that has nothing finite
# The sun is 1e9 times as bright as a room. Sums over the map and its products must not overflow.
BRIGHTEST_TEXEL, STRONGEST = 1e15, 1e10


def mend_radiance(radiance: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """The map with nothing but finite values, and what was changed, a line for each kind.

    radiance: float (3,) or (h, w, 3). Returns a C-contiguous float32 array, the same one if it is
    good. NaN and what overflows below becomes 0, infinity and what overflows the largest good
    value.
    """
    radiance = np.ascontiguousarray(radiance, np.float32)
    if radiance.min() >= -BRIGHTEST_TEXEL and radiance.max() <= BRIGHTEST_TEXEL:
        return radiance, []
    nan = np.isnan(radiance)
    with np.errstate(invalid="ignore"):
        negative, infinite = radiance < -BRIGHTEST_TEXEL, radiance > BRIGHTEST_TEXEL
    usable = ~(nan | infinite | negative)
    largest = np.max(radiance, where=usable, initial=0.0)
    largest = np.float32(largest if largest > 0.0 else _LARGEST)
    too_bright = "infinite" if np.isposinf(radiance[infinite]).all() else "too bright to render"
    notes = []
    for mask, what, now in (
        (nan, "NaN", 0.0),
        (negative, "too far below 0 to render", 0.0),
        (infinite, too_bright, largest),
    ):
        if mask.any():
            texels = f"{int(mask.any(axis=-1).sum())} of {radiance[..., 0].size} texels are"
            notes.append(f"{texels if radiance.ndim > 1 else 'is'} {what}: {now:g} instead")
    mended = np.where(usable, radiance, np.float32(0.0))
    mended[infinite] = largest
    return mended, notes
