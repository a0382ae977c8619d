"""Errors as the paper takes them, and how far two maps agree on what is larger."""

from __future__ import annotations

import numpy as np

REC709 = np.array([0.2126, 0.7152, 0.0722])
_DARK = 1e-3  # of the mean: below, a relative error means nothing


def light_of(rgb) -> np.ndarray:
    """Rec.709 luminance, float64 (...)."""
    return np.asarray(rgb, np.float64)[..., :3] @ REC709


def lit_pixels(reference, shown) -> np.ndarray:
    """bool (h, w): pixels that show the object and whose reference (h, w, 3) is not black."""
    light = light_of(reference)
    return shown & (light > _DARK * light[shown].mean())


def error_map(picture, reference, mask) -> np.ndarray:
    """e_i = |R - I| / I [Huang07, eq. 3] on luminance, float64 (h, w); 0 outside the mask."""
    found, wanted = light_of(picture), light_of(reference)
    return np.where(mask, np.abs(found - wanted), 0.0) / np.where(mask, wanted, 1.0)


def mre(picture, reference, mask) -> float:
    """Mean relative error over the mask [Huang07, eq. 4]."""
    return float(error_map(picture, reference, mask)[mask].mean())


def rms(picture, reference, mask) -> float:
    """Root of the mean square of e_i over the mask."""
    return float(np.sqrt((error_map(picture, reference, mask)[mask] ** 2).mean()))


def ranks(values: np.ndarray) -> np.ndarray:
    """Mean ranks of float64 (n,): equal values share one."""
    _, where, counts = np.unique(values, return_inverse=True, return_counts=True)
    ends = np.cumsum(counts)
    return (ends - 0.5 * (counts - 1.0))[where]


def rank_correlation(a, b) -> float:
    """Spearman's rho of two float64 (n,): 1 where both put everything in the same order."""
    return float(np.corrcoef(ranks(a), ranks(b))[0, 1])
