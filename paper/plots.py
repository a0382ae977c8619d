"""The figures drawn by matplotlib, which is an extra of the package: pip install 'iwis[paper]'."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .figure3 import ShownPixel
from .metrics import light_of
from .results import Results

_RED, _BLUE = "#d62728", "#1f4fd6"


def developed(rgb: np.ndarray, white: float) -> np.ndarray:
    """sRGB (h, w, 3), row 0 on top, of linear light; what is as bright as ``white`` is 1."""
    x = np.clip(rgb / white, 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)[::-1]


def white_of(rgb: np.ndarray, shown: np.ndarray) -> float:
    """The light that 98 % of the pixels shown stay below."""
    return float(np.percentile(light_of(rgb)[shown], 98.0)) or 1.0


def draw_all(results: Results, folder: Path) -> dict[str, Path]:
    """Every figure as a .png; name -> file."""
    import matplotlib

    matplotlib.use("Agg")
    figures = {
        "figure1": _figure1,
        "figure2": _figure2,
        "figure3": _figure3,
        "figure4": _figure4,
        "figure5": _figure5,
        "figure5_crops": _crops,
        "tables": _tables,
    }
    paths = {}
    for name, draw in figures.items():
        figure = draw(results)
        paths[name] = folder / f"{name}.png"
        figure.savefig(paths[name], dpi=100, bbox_inches="tight")
    return paths


def _axes(rows, columns, size):
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False)


def _show(axes, picture, title, **options):
    axes.set_axis_off()
    axes.set_title(title, fontsize=9)
    return axes.imshow(picture, interpolation="nearest", **options)


def _figure1(results):
    figure, axes = _axes(1, 3, (7.5, 5.2))
    maps = results.maps_of_tables
    top = float(np.percentile(maps.e_i[maps.mask], 97.0))
    # sigma_d is a radiance: scaled to the mean of e_d, so that one colour scale serves all three.
    scale = maps.e_d[maps.mask].mean() / max(maps.sigma_d[maps.mask].mean(), 1e-30)
    shown = {
        "e_i": maps.e_i,
        f"e_d (rank corr. {maps.by_e_d[0]:.2f})": maps.e_d,
        f"sigma_d, scaled ({maps.by_sigma_d[0]:.2f})": maps.sigma_d * scale,
    }
    for ax, (name, values) in zip(axes[0], shown.items(), strict=True):
        image = _show(ax, values[::-1], name, vmin=0.0, vmax=max(top, 1e-6), cmap="inferno")
    figure.colorbar(image, ax=list(axes[0]), shrink=0.7)
    return figure


def _square(axes, title):
    axes.set(xlim=(0, 1), ylim=(0, 1), aspect="equal", xticks=[], yticks=[])
    axes.set_title(title, fontsize=9)


def _density(axes, density):
    shown = np.log1p(density)
    axes.imshow(shown, extent=(0, 1, 0, 1), origin="lower", cmap="Greys", vmax=2.0 * shown.max())


def _figure2(results):
    figure, axes = _axes(2, 3, (7.5, 5.2))
    warping = results.warping
    colors = (_RED, "#2ca02c", _BLUE)
    n = len(warping.points[0])
    for k in range(3):
        _density(axes[1, k], warping.density)
        for row, found in enumerate((warping.points[k], warping.warped[k])):
            for j in range(k + 1):
                x, y = found[j * n : (j + 1) * n].T
                axes[row, k].plot(x, y, ".", color=colors[j], markersize=6)
            _square(axes[row, k], f"{(k + 1) * n} {'warped' if row else 'Halton'} points")
    return figure


def _figure3(results):
    figure, axes = _axes(1, 3, (9, 3.4))
    for ax, pixel in zip(axes[0], results.pixels, strict=True):
        _draw_pixel(ax, pixel)
    return figure


def _draw_pixel(axes, pixel: ShownPixel):
    _density(axes, pixel.density)
    for seen, color in ((True, _RED), (False, _BLUE)):
        x, y = pixel.warped[pixel.seen == seen].T
        axes.plot(x, y, ".", color=color, markersize=6)
    n, k = len(pixel.seen), int(pixel.seen.sum())
    _square(axes, f"pixel {pixel.pixel}: {k} of {n} samples visible")


def _figure4(results):
    figure, axes = _axes(2, 3, (8, 10))
    for k, r in enumerate(results.rendered):
        picture = r.picture
        shown = picture.samples > 0
        white = white_of(picture.rgb, shown)
        name = f"{r.pair.material} / {r.pair.probe}"
        _show(axes[0, k], developed(picture.rgb, white), f"{name}\n{picture.seconds:.2f} s")
        title = f"{r.mean:.1f} samples a pixel"
        image = _show(axes[1, k], picture.samples[::-1], title, vmin=0, vmax=100, cmap="viridis")
    figure.colorbar(image, ax=list(axes[1]), shrink=0.6)
    return figure


def _figure5(results):
    figure, axes = _axes(1, 2, (11, 4.6))
    for ax, what, title in (
        (axes[0, 0], "from_limited", "against the reference that the tables limit"),
        (axes[0, 1], "mre", "against the true reference"),
    ):
        for name, points in results.curves.curves.items():
            style = "-" if name.startswith(("IIS", "WIS")) else "--"
            x, y = [p.mean for p in points], [getattr(p, what) for p in points]
            ax.plot(x, y, style, marker=".", label=name, linewidth=1.2)
        ax.set(xscale="log", yscale="log", xlabel="mean samples a pixel", ylabel="MRE")
        ax.set_title(title, fontsize=9)
        ax.grid(True, which="both", alpha=0.25)
    axes[0, 1].legend(fontsize=7)
    return figure


def _crops(results):
    crops = results.curves.crops
    figure, axes = _axes(len(crops), 3, (8, 1.3 * len(crops)))
    shown = results.truth.lit
    white = white_of(results.truth.limited.rgb, shown)
    for row, crop in zip(axes, crops, strict=True):
        for ax, (name, rgb) in zip(row, crop.pictures.items(), strict=True):
            error = f", MRE {100 * crop.errors[name]:.1f} %" if name in crop.errors else ""
            count = f" {crop.means[name]:.0f} samples" if name in crop.means else ""
            title = f"{crop.name}, mean {crop.samples}: {name}{count}{error}"
            _show(ax, developed(rgb, white), title)
            ax.title.set_fontsize(7)
    return figure


def _tables(results):
    figure, axes = _axes(1, 1, (5, 3.4))
    x = [100 * t.coefficients for t in results.tables]
    ax = axes[0, 0]
    ax.plot(x, [t.limited_from_true for t in results.tables], "o-", label="tables alone")
    ax.plot(x, [t.from_limited for t in results.tables], "o-", label="sampling alone")
    ax.plot(x, [t.from_true for t in results.tables], "o-", label="both")
    ax.set(xscale="log", ylim=(0, None), xlabel="coefficients kept, %", ylabel="MRE")
    ax.grid(True, which="both", alpha=0.25)
    ax.legend(fontsize=8)
    return figure
