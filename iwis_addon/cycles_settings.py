"""What a scene was set to for Cycles, as IWIS means it; and both engines' pictures compared."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core.data.channels import LUMINANCE
from ..core.settings import LIMITS
from .callbacks import end_previews
from .images import render_pixels
from .job import ENGINE

# Both defaults: Cycles' noise threshold .01 is of the square root of light, IWIS' .1 relative.
_THRESHOLD_FACTOR = 10.0
_DENOISE_PASSES = {"RGB": "NONE", "RGB_ALBEDO": "ALBEDO", "RGB_ALBEDO_NORMAL": "ALBEDO_NORMAL"}


def copy_cycles_settings(scene) -> list[str]:
    """Set IWIS' settings from Cycles'; names of what was set. Raises ValueError without Cycles.

    Film exposure and transparency need no copy: they are read from where Cycles reads them.
    """
    if not hasattr(scene, "cycles"):
        raise ValueError("Cycles is disabled: its settings are not there to be copied")
    cycles, iwis = scene.cycles, scene.iwis
    rule = "PERCEPTUAL" if cycles.use_adaptive_sampling else "FIXED"
    iwis.time_limit = _within("time_limit", cycles.time_limit)
    if iwis.time_limit > 0.0:  # ends there, or with the samples; the threshold is not asked then
        rule, iwis.target_samples = "BUDGET", 0
    iwis.stop_rule = rule
    iwis.max_samples = _within("max_samples", cycles.samples)
    iwis.error_threshold = _threshold(cycles.adaptive_threshold)
    iwis.viewport.max_samples = _within("max_samples", cycles.preview_samples or cycles.samples)
    iwis.viewport.error_threshold = _threshold(cycles.preview_adaptive_threshold)
    iwis.seed = _within("seed", cycles.seed)
    iwis.use_animated_seed = cycles.use_animated_seed
    iwis.pixel_filter = cycles.pixel_filter_type  # BOX, GAUSSIAN or BLACKMAN_HARRIS
    iwis.filter_width = _within("filter_width", cycles.filter_width)
    bounces = cycles.transparent_max_bounces
    iwis.transparent_max_bounces = _within("transparent_max_bounces", bounces)
    _copy_denoising(cycles, "", iwis)
    _copy_denoising(cycles, "preview_", iwis.viewport)
    iwis.viewport.denoise_start = _within("max_samples", cycles.preview_denoising_start_sample)
    for layer in scene.view_layers:
        layer.iwis.use_denoising = layer.cycles.use_denoising
        layer.iwis.use_pass_denoising_data = layer.cycles.denoising_store_passes
    names = ["stop rule", "time limit", "samples", "thresholds", "seed", "pixel filter"]
    return [*names, "transparent bounces", "denoising"]


def _copy_denoising(cycles, prefix: str, own) -> None:
    """prefix: of Cycles' names; own: ``scene.iwis``, or ``scene.iwis.viewport``"""
    own.denoise = getattr(cycles, f"use_{prefix}denoising")
    own.denoise_passes = _DENOISE_PASSES[getattr(cycles, f"{prefix}denoising_input_passes")]
    own.denoise_prefilter = getattr(cycles, f"{prefix}denoising_prefilter")
    own.denoise_quality = getattr(cycles, f"{prefix}denoising_quality")


def _threshold(cycles_threshold: float) -> float:
    """0 is Cycles' automatic threshold."""
    return _within("error_threshold", _THRESHOLD_FACTOR * (cycles_threshold or 0.01))


def _within(name, value):
    low, high = LIMITS[name]
    return min(max(value, low), high)


class Comparison(NamedTuple):
    """difference: float32 (h, w, 4), |IWIS - Cycles|; mre: mean relative error of the luminance of
    pixels that show an object [Huang07, eq. 3]; bias: signed, of their sums"""

    difference: np.ndarray
    mre: float
    bias: float


# What must be equal in both: direct light, no denoiser, alpha to tell objects from the world.
_RENDER = {"film_transparent": True, "use_motion_blur": False}
_CYCLES = {"use_denoising": False, "max_bounces": 0, "use_adaptive_sampling": False}


def compare_with_cycles(scene, samples: int) -> Comparison:
    """Render the scene with IWIS as it is set, and with Cycles' direct light; settings are kept.

    samples: of Cycles. Raises ValueError without Cycles, RuntimeError when a render fails.
    """
    if not hasattr(scene, "cycles"):
        raise ValueError("Cycles is disabled: enable it in Preferences, Add-ons, to compare")
    wanted = [(scene.render, name, value) for name, value in _RENDER.items()]
    wanted += [(scene.cycles, name, value) for name, value in _CYCLES.items()]
    wanted += [(scene.cycles, "samples", samples), (scene.iwis, "denoise", False)]
    kept = [(owner, name, getattr(owner, name)) for owner, name, _ in wanted]
    kept.append((scene.render, "engine", scene.render.engine))
    end_previews()
    try:
        for owner, name, value in wanted:
            setattr(owner, name, value)
        scene.render.engine = ENGINE
        ours = render_pixels(scene)
        scene.render.engine = "CYCLES"
        return compare(ours, render_pixels(scene))
    finally:
        for owner, name, value in kept:
            setattr(owner, name, value)


def compare(ours: np.ndarray, cycles: np.ndarray) -> Comparison:
    """Two pictures, float32 (h, w, 4), alpha 1 where an object is."""
    difference = np.abs(ours - cycles)
    difference[..., 3] = 1.0
    light, wanted = (picture[..., :3].astype(np.float64) @ LUMINANCE for picture in (ours, cycles))
    shown = cycles[..., 3] > 0.999
    shown &= wanted > 1e-3 * (wanted[shown].mean() if shown.any() else 0.0)
    if not shown.any():
        return Comparison(difference, float("nan"), float("nan"))
    light, wanted = light[shown], wanted[shown]
    mre = float((np.abs(light - wanted) / wanted).mean())
    return Comparison(difference, mre, float(light.sum() / wanted.sum() - 1.0))
