"""One random scene by IWIS and by Cycles: what differs by more than their noise."""

from __future__ import annotations

import re
import warnings as python_warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

from iwis.iwis_addon.job import RenderJob
from support.cycles_render import render_cycles
from support.iwis_render import by_pass, render_iwis

# Shading points of a pixel, shadow rays of each, and Cycles' samples; times four for a second look.
POINTS, BATCH, SAMPLES = 32, 4, 64
FILTER_WIDTH = 1.5
# Of the mean: what is below may be the half percent to which a texture, a light's picture or a ball
# of triangles is known; above, it counts where it is more than so many standard errors.
LEAST_BIAS, ERRORS = 0.005, 3.0
# Of the mean, root mean square over blocks of pixels without their noise: what is somewhere else.
BLOCK, MOST_DIFFERENCE = 4, 0.05
_GROUP = "Combined_"
# Warnings that random scenes are expected to give (docs/what-is-supported.md).
FORESEEN = (
    "emission depends on",
    "it gives no light",
    "all light is as on diffuse surfaces",
    "grey shadow",
    "without area, 0 with",
    "a world has no UV map",
    "faces shine: those that move",
)


class Finding(NamedTuple):
    """bias: of the mean, and its standard error; difference: of blocks; both of Cycles' mean.

    alpha: difference of its mean; warnings: unforeseen; ours, cycles: (h, w, 4)
    groups: the most that a light group's mean differs by, beyond its noise, of Cycles' mean
    """

    bias: float
    error: float
    difference: float
    alpha: float
    warnings: list[str]
    ours: np.ndarray
    cycles: np.ndarray
    groups: float = 0.0

    @property
    def differs(self) -> bool:
        """Whether noise does not explain the picture."""
        biased = abs(self.bias) > max(LEAST_BIAS, ERRORS * self.error)
        placed = self.difference > MOST_DIFFERENCE or self.groups > LEAST_BIAS
        return biased or placed or abs(self.alpha) > LEAST_BIAS

    def __str__(self):
        numbers = f"bias {self.bias:+.4f} +- {self.error:.4f}, blocks {self.difference:.4f}"
        return f"{numbers}, alpha {self.alpha:+.4f}, groups {self.groups:.4f}"


def compare(scene, folder: Path) -> Finding:
    """Render the open scene; a picture that differs is rendered again, with more samples."""
    found = _compared(scene, folder, 1, 2)
    return _compared(scene, folder, 4, 4) if found.differs else found


def _compared(scene, folder, more, renders) -> Finding:
    ours = _stacked([_render_iwis(scene, seed, folder, more) for seed in range(renders)])
    told = RenderJob.get().records[-1].stats.warnings
    cycles = _stacked([_render_cycles(scene, seed, folder, more) for seed in range(renders)])
    groups = {name: (ours[name], cycles[name]) for name in cycles if name.startswith(_GROUP)}
    ours, cycles = ours["Combined"], cycles["Combined"]
    scale = max(float(np.abs(cycles[..., :3]).mean()), 1e-4)
    a, b = ours.mean(0), cycles.mean(0)
    means = [pictures[..., :3].mean((1, 2, 3)) for pictures in (ours, cycles)]
    # Of so few renders their own spread says little; pixels of a picture are almost independent.
    error = np.sqrt(sum(_variance_of_mean(p) for p in (ours, cycles)))
    spread = np.sqrt(sum(m.var(ddof=1) / len(m) for m in means))
    noise = sum(_blocks(p).var(0, ddof=1).mean() / len(p) for p in (ours, cycles))
    squared = ((_blocks(a[None]) - _blocks(b[None])) ** 2).mean() - noise
    return Finding(
        bias=float(means[0].mean() - means[1].mean()) / scale,
        error=float(max(error, spread)) / scale,
        difference=float(np.sqrt(max(squared - 2.0 * noise, 0.0))) / scale,
        alpha=float(a[..., 3].mean() - b[..., 3].mean()),
        warnings=unforeseen(told),
        ours=a,
        cycles=b,
        groups=max([_beyond_noise(*pair) for pair in groups.values()], default=0.0) / scale,
    )


def _stacked(renders) -> dict[str, np.ndarray]:
    """Combined, and the light groups' pictures, (n, h, w, channels) by name."""
    names = [n for n in renders[0] if n == "Combined" or n.startswith(_GROUP)]
    return {name: np.array([render[name] for render in renders]) for name in names}


def _beyond_noise(ours, cycles) -> float:
    """The difference of the means, less so many standard errors."""
    error = np.sqrt(_variance_of_mean(ours) + _variance_of_mean(cycles))
    far = abs(float(ours[..., :3].mean()) - float(cycles[..., :3].mean()))
    return max(far - ERRORS * float(error), 0.0)


def unforeseen(warnings) -> list[str]:
    """Those of a render that random scenes are not expected to give."""
    return [w for w in warnings if not any(re.search(known, w) for known in FORESEEN)]


def _variance_of_mean(pictures) -> float:
    """Of the mean of pictures with other seeds."""
    n, height, width, _ = pictures.shape
    return float(pictures[..., :3].mean(-1).var(0, ddof=1).mean()) / (n * height * width)


def _blocks(pictures) -> np.ndarray:
    """(n, rows, columns, 3): means of blocks of pixels."""
    n, height, width, _ = pictures.shape
    rows, columns = height // BLOCK, width // BLOCK
    whole = pictures[:, : rows * BLOCK, : columns * BLOCK, :3]
    return whole.reshape(n, rows, BLOCK, columns, BLOCK, 3).mean((2, 4))


def _render_iwis(scene, seed, folder, more):
    own = scene.iwis
    own.seed, own.filter_width = seed, FILTER_WIDTH
    own.pixel_filter = scene.cycles.pixel_filter_type
    own.max_samples, own.batch_size = POINTS * BATCH * more, BATCH
    own.stop_rule = "FIXED"
    return by_pass(render_iwis(scene, folder))


def _render_cycles(scene, seed, folder, more):
    scene.cycles.seed = seed
    with python_warnings.catch_warnings():
        python_warnings.simplefilter("ignore")
        return render_cycles(scene, folder, (), SAMPLES * more, FILTER_WIDTH)
