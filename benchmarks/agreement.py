"""Whether two renderers agree: their difference, beside what the noise of both explains.

Each side renders several independent pictures (other seeds). Half the difference of two of them has
the distribution of the noise of their mean; so the noise is measured, not assumed.

Cycles' narrowest filter is not quite the pixel's centre: its samples lie within .01 px of it, and
one in 512 anywhere in the pixel (measured; its filter table ends there). So pixels whose centre is
as near to an edge as that see two surfaces in Cycles and one here; they are left out, and counted.
The stray samples stay in: they brighten dark pixels beside bright ones, the largest differences.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np
from metrics import luminance, measured_pixels, relative_difference

FILTER_RADIUS_PX = 0.01
# A surface that leaps by this part of a pixel's width, or turns by this, within the filter's
# radius has an edge there: 50 times what the radius explains on a surface seen head-on.
LEAP_PX, TURN = 0.5, 0.1


class Agreement(NamedTuple):
    """signed: relative difference of the sums; mean_absolute: mean relative difference of a pixel;
    noise: the mean_absolute that the noise of both explains; pixels: how many were compared."""

    signed: float
    mean_absolute: float
    noise: float
    pixels: int

    @property
    def ratio(self) -> float:
        """mean_absolute / noise: 1 if there is nothing but noise."""
        return self.mean_absolute / self.noise


def edge_pixels(run, radius_px: float = FILTER_RADIUS_PX) -> np.ndarray:
    """bool (h, w): pixels that see another surface within a radius about their centre.

    run: a run_iwis.IwisRun
    """
    centre = _surface(run, 0.0, 0.0)
    edges = np.zeros(centre["depth"].shape[:2], bool)
    camera = run.scene.camera
    width_px = (camera.window[1] - camera.window[0]) / camera.width * centre["depth"][..., 0]
    for angle in np.arange(8) * (np.pi / 4):
        there = _surface(run, radius_px * np.cos(angle), radius_px * np.sin(angle))
        leap = np.linalg.norm(there["position"] - centre["position"], axis=-1)
        turn = np.linalg.norm(there["normal"] - centre["normal"], axis=-1)
        edges |= (leap > LEAP_PX * width_px) | (turn > TURN)
        edges |= (there["depth"] < 1e9)[..., 0] != (centre["depth"] < 1e9)[..., 0]
    return edges


def _surface(run, x_px, y_px):
    """Layers of a render whose rays go (x_px, y_px) beside the pixels' centres."""
    camera = run.scene.camera
    left, right, bottom, top = camera.window
    x, y = x_px * (right - left) / camera.width, y_px * (top - bottom) / camera.height
    moved = dataclasses.replace(camera, window=(left + x, right + x, bottom + y, top + y))
    film, _ = run.render(scene=dataclasses.replace(run.scene, camera=moved), max_samples=1)
    return film.layers


def compare(pictures, references, object_mask) -> tuple[Agreement, np.ndarray]:
    """How the means of two sets of pictures differ, and the relative difference, (h, w).

    pictures, references: lists of (h, w, 3), at least two of each; object_mask: bool (h, w)
    """
    found, wanted = np.mean(pictures, axis=0), np.mean(references, axis=0)
    mask = measured_pixels(wanted, object_mask)
    difference = relative_difference(found, wanted, mask)
    noise = np.hypot(_noise(pictures, wanted, mask), _noise(references, wanted, mask))
    signed = luminance(found)[mask].sum() / luminance(wanted)[mask].sum() - 1.0
    agreement = Agreement(
        signed=float(signed),
        mean_absolute=float(np.abs(difference[mask]).mean()),
        noise=float(noise),
        pixels=int(mask.sum()),
    )
    return agreement, difference


def _noise(pictures, reference, mask) -> float:
    """Mean absolute relative error of the mean of pictures, from the differences of its parts."""
    lights = [luminance(picture)[mask] for picture in pictures]
    pairs = [np.abs(a - b) for k, a in enumerate(lights) for b in lights[:k]]
    one = np.mean(np.mean(pairs, axis=0) / luminance(reference)[mask]) / np.sqrt(2.0)
    return float(one / np.sqrt(len(lights)))
