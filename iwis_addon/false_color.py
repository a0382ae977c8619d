"""Passes of numbers as colors: for the rendered view, and for images."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Dark to bright, as the eye orders them, also without color; sRGB values as they are displayed.
_STOPS = np.array(
    [
        (0.00, 0.00, 0.05),
        (0.20, 0.05, 0.45),
        (0.60, 0.10, 0.45),
        (0.90, 0.35, 0.20),
        (1.00, 0.70, 0.10),
        (1.00, 1.00, 0.75),
    ],
    np.float32,
)


class Scale(NamedTuple):
    """From numbers to 0 ... 1. logarithmic: each doubling is as wide as the next."""

    title: str
    low: float
    high: float
    logarithmic: bool = False

    def place(self, values: np.ndarray) -> np.ndarray:
        """float32 of the same shape: 0 at low and below, 1 at high and above."""
        low, high = self.low, self.high
        if self.logarithmic:
            values, low, high = np.log2(np.maximum(values, low)), np.log2(low), np.log2(high)
        return np.clip((values - low) / max(high - low, 1e-12), 0.0, 1.0).astype(np.float32)

    def ticks(self, count: int = 5) -> list[tuple[float, str]]:
        """(place, text) of the numbers beside a legend."""
        places = np.linspace(0.0, 1.0, count)
        if self.logarithmic:
            values = np.exp2(np.log2(self.low) + places * np.log2(self.high / self.low))
        else:
            values = self.low + places * (self.high - self.low)
        return [(float(p), f"{v:.3g}") for p, v in zip(places, values, strict=True)]


def scale_of(layer: str, settings) -> Scale:
    """The scale of a layer of core.film: samples, error or visibility.

    settings: RenderSettings of the picture
    """
    if layer == "samples":
        return Scale("Samples", 1.0, float(max(settings.max_samples, 2)), logarithmic=True)
    if layer == "error":
        return Scale("Error", 0.0, 2.0 * max(settings.error_threshold, 0.01))
    if layer == "visibility":
        return Scale("Visibility", 0.0, 1.0)
    raise ValueError(f"layer {layer!r} has no false colors: samples, error and visibility have")


def false_color(values: np.ndarray, scale: Scale) -> np.ndarray:
    """Display colors, float32 (h, w, 4), of float32 (h, w) or (h, w, 1); alpha is 1."""
    place = scale.place(values.reshape(values.shape[:2])) * (len(_STOPS) - 1)
    low = np.minimum(place.astype(np.int32), len(_STOPS) - 2)
    part = (place - low)[..., None]
    colors = np.ones((*place.shape, 4), np.float32)
    colors[..., :3] = _STOPS[low] * (1.0 - part) + _STOPS[low + 1] * part
    return colors


def legend(height: int) -> np.ndarray:
    """The scale itself, float32 (height, 1, 4), low values at the bottom."""
    return false_color(np.linspace(0.0, 1.0, height, dtype=np.float32)[:, None], Scale("", 0, 1))
