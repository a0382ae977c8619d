"""Plots of docs/benchmarks.md. The only file that needs matplotlib."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import tables
from configurations import CONFIGURATIONS

matplotlib.use("Agg")
from matplotlib import pyplot
from matplotlib.ticker import FuncFormatter, NullFormatter

COLORS = dict(zip((c.name for c in CONFIGURATIONS), pyplot.get_cmap("tab10").colors, strict=False))
PLAIN = FuncFormatter(lambda value, _: f"{value:g}")


def error_curves(scenes: dict, path: Path, title) -> None:
    """MRE against CPU seconds, a panel a scene."""
    columns = min(2, len(scenes))
    rows = -(-len(scenes) // columns)
    figure, axes = pyplot.subplots(rows, columns, figsize=(5 * columns, 4 * rows), squeeze=False)
    for axis, (name, scene) in zip(axes.flat, scenes.items(), strict=False):
        for configuration, curve in tables.curves(scene).items():
            style = "-o" if configuration.startswith("IWIS") else "--o"
            axis.plot(
                curve.column("cpu"),
                curve.column("mre"),
                style,
                color=COLORS[configuration],
                label=configuration,
                markersize=3,
            )
        axis.axhline(scene["reference"]["noise"], color="grey", linewidth=0.5, linestyle=":")
        label(axis, title(name), "CPU seconds", "mean relative error")
    for axis in axes.flat[len(scenes) :]:
        axis.axis("off")
    axes[0, 0].legend(fontsize=7)
    save(figure, path)


def scaling_curves(found: dict, path: Path) -> None:
    """CPU seconds against pixels, samples, triangles and the HDRI's width."""
    panels = {
        "pixels": ("side of the picture", {"cpu": "sampling"}),
        "samples": ("samples a pixel", {"cpu": "sampling"}),
        "triangles": ("triangles", {"cpu": "sampling", "bvh_cpu": "BVH"}),
        "hdri": (
            "width of the HDRI",
            {"cpu": "sampling", "prepare_cpu": "preparing", "again_cpu": "preparing again"},
        ),
    }
    figure, axes = pyplot.subplots(2, 2, figsize=(9, 6.5))
    for axis, (name, (text, series)) in zip(axes.flat, panels.items(), strict=True):
        sizes = [row["value"] for row in found[name]]
        for key, legend in series.items():
            axis.plot(sizes, [row[key] for row in found[name]], "-o", markersize=3, label=legend)
        label(axis, name, text, "CPU seconds")
        axis.legend(fontsize=7)
    save(figure, path)


def label(axis, title: str, x: str, y: str) -> None:
    """Titles, log scales, a grid."""
    axis.set_title(title, fontsize=10)
    axis.set_xlabel(x, fontsize=8)
    axis.set_ylabel(y, fontsize=8)
    axis.set_xscale("log")
    axis.set_yscale("log")
    for ruler in (axis.xaxis, axis.yaxis):
        ruler.set_major_formatter(PLAIN)
        ruler.set_minor_formatter(NullFormatter())
    axis.tick_params(labelsize=7)
    axis.grid(True, which="both", linewidth=0.3)


def save(figure, path: Path) -> None:
    """Write a PNG."""
    figure.tight_layout()
    figure.savefig(path, dpi=90)
    pyplot.close(figure)
