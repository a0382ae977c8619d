"""Random choices that read like sentences; the same seed makes the same ones."""

from __future__ import annotations

import numpy as np


class Dice:
    """Throws of one seed.

    told: what has been chosen, for the report; bumps: whether normals may be turned
    glows: whether all is to be shown as light, of any value
    """

    def __init__(self, seed: int, glows: bool = False):
        self._rng = np.random.default_rng(seed)
        self.told: list[str] = []
        self.bumps, self.glows = True, glows

    def tell(self, what: str) -> None:
        """Add to the report."""
        self.told.append(what)

    def chance(self, share: float) -> bool:
        """True for a share of all throws."""
        return bool(self._rng.random() < share)

    def of(self, *things):
        """One of some things."""
        return things[int(self._rng.integers(len(things)))]

    def whole(self, low: int, high: int) -> int:
        """An integer, both ends included."""
        return int(self._rng.integers(low, high + 1))

    def between(self, low: float, high: float) -> float:
        """A number."""
        return float(self._rng.uniform(low, high))

    def spread(self, low: float, high: float) -> float:
        """A number > 0, by its logarithm."""
        return float(np.exp(self._rng.uniform(np.log(low), np.log(high))))

    def edge(self, low: float, high: float) -> float:
        """A number that is often one of the ends, where things go wrong."""
        return self.of(low, high) if self.chance(0.3) else self.between(low, high)

    def vector(self, low: float, high: float) -> tuple[float, float, float]:
        """Three numbers."""
        return tuple(self._rng.uniform(low, high, 3).tolist())

    def color(self, low: float = 0.05, high: float = 0.95) -> tuple[float, float, float]:
        """A colour, or a grey."""
        return (self.between(low, high),) * 3 if self.chance(0.3) else self.vector(low, high)

    def pixels(self, height: int, width: int) -> np.ndarray:
        """float32 (height, width, 4): smooth stripes, noise, opaque."""
        rows, columns = np.mgrid[0:height, 0:width] / np.array([height, width])[:, None, None]
        out = np.ones((height, width, 4), np.float32)
        for channel in range(3):
            turns, phase = self._rng.uniform(0.5, 3.0, 2), self._rng.uniform(0.0, 6.3)
            waves = np.sin(2.0 * np.pi * (turns[0] * rows + np.rint(turns[1]) * columns) + phase)
            noise = 0.2 * self._rng.random((height, width))
            out[..., channel] = 0.4 + 0.35 * waves + noise
        return np.maximum(out, 0.0)
