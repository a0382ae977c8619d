"""A sheet of pictures: IWIS, Cycles and their difference, of twenty of the cases."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .compare import Result

COUNT, COLUMNS = 20, 4
CONTRAST = 4.0


def draw_sheet(results: dict[str, Result], path: Path) -> None:
    """Write a JPEG of twenty cases, spread over all: each IWIS | Cycles | difference."""
    # What makes the documents alone needs matplotlib.
    from matplotlib.figure import Figure

    names = list(results)
    chosen = [names[int(i)] for i in np.linspace(0, len(names) - 1, min(COUNT, len(names)))]
    rows = -(-len(chosen) // COLUMNS)
    figure = Figure(figsize=(4.2 * COLUMNS, 1.25 * rows), layout="constrained", dpi=90)
    for axes, name in zip(figure.subplots(rows, COLUMNS, squeeze=False).flat, chosen, strict=False):
        axes.imshow(triple(results[name]), origin="lower", interpolation="nearest")
        axes.set_title(name, fontsize=8)
    for axes in figure.axes:
        axes.axis("off")
    figure.savefig(path, pil_kwargs={"quality": 85})


def triple(result: Result) -> np.ndarray:
    """Both pictures as a screen shows them, and their difference, grey for none: (h, 3 w, 3)."""
    scale = max(float(np.percentile(result.cycles, 99.0)), 1e-6)
    difference = 0.5 + CONTRAST * (result.ours - result.cycles) / scale
    shown = [np.clip(p / scale, 0.0, 1.0) ** (1.0 / 2.2) for p in (result.ours, result.cycles)]
    return np.concatenate([*shown, np.clip(difference, 0.0, 1.0)], axis=1)
