"""Blender's properties -> the settings of the core: the only file that knows both vocabularies."""

from __future__ import annotations

import dataclasses

from ..core.settings import LIMITS, DenoiseSettings, RenderSettings
from .preferences import cache_dir
from .properties import NOT_ON_SCENE


def render_settings(scene) -> RenderSettings:
    """What the scene asks for, as the core takes it."""
    values = {
        field.name: _as_typed(getattr(scene.iwis, field.name))
        for field in dataclasses.fields(RenderSettings)
        if field.name not in NOT_ON_SCENE
    }
    if scene.iwis.use_animated_seed:
        values["seed"] = (values["seed"] + scene.frame_current) % (LIMITS["seed"][1] + 1)
    values["threads"] = values["threads"] or _blender_threads(scene)
    return RenderSettings(**values, cache_dir=cache_dir())


def viewport_settings(scene) -> RenderSettings:
    """What the rendered view takes: the final settings, but for those that it has of its own."""
    own = scene.iwis.viewport
    return dataclasses.replace(
        render_settings(scene),
        error_threshold=_as_typed(own.error_threshold),
        max_samples=own.max_samples,
        pixel_filter=own.pixel_filter,
        estimator="UNBIASED",
        stop_rule="PERCEPTUAL",
    )


def denoise_settings(owner) -> DenoiseSettings:
    """What is to become of the noise. owner: ``scene.iwis``, or ``scene.iwis.viewport``"""
    fields = dataclasses.fields(DenoiseSettings)
    return DenoiseSettings(**{field.name: getattr(owner, field.name) for field in fields})


def _as_typed(value):
    """Blender's floats are float32: 0.1 comes as 0.10000000149, but means 0.1."""
    return float(f"{value:.7g}") if isinstance(value, float) else value


def _blender_threads(scene) -> int:
    """Blender's own number when a user fixed it, in the scene or by `-t`; else 0, all cores."""
    if scene.render.threads_mode != "FIXED":
        return 0
    return min(scene.render.threads, LIMITS["threads"][1])


def apply_settings(scene, settings: RenderSettings | DenoiseSettings, names) -> None:
    """Write those of the named settings that are its own, as if a user had set them."""
    for name in names:
        if name not in NOT_ON_SCENE and hasattr(settings, name):
            setattr(scene.iwis, name, getattr(settings, name))
