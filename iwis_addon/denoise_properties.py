"""How the denoiser's settings are offered, of renders and of the rendered view: as in Cycles."""

from __future__ import annotations

from ..core.settings import DENOISE_CHOICES, DenoiseSettings

_TEXTS = {
    "denoise_passes": (
        "Denoising Passes",
        "What tells the denoiser noise from the detail of surfaces",
        {
            "NONE": ("None", "The picture alone"),
            "ALBEDO": ("Albedo", "The colors of surfaces"),
            "ALBEDO_NORMAL": ("Albedo and Normal", "Colors and normals of surfaces"),
        },
    ),
    "denoise_prefilter": (
        "Denoising Prefilter",
        "What is done about noise in the passes themselves",
        {
            "NONE": ("None", "Nothing: they have no noise, as with the pixel filter Center"),
            "FAST": ("Fast", "They are taken to have some: the least time where they do"),
            "ACCURATE": ("Accurate", "Their own noise is taken away first: three times the time"),
        },
    ),
    "denoise_quality": (
        "Denoising Quality",
        "Of the denoiser's network",
        {
            "HIGH": ("High", "The best picture"),
            "BALANCED": ("Balanced", "Between the two"),
            "FAST": ("Fast", "The least time"),
        },
    ),
}
DEFAULTS = DenoiseSettings()
# The rendered view's, as Cycles has them.
VIEW_DEFAULTS = DenoiseSettings(
    denoise_passes="ALBEDO", denoise_prefilter="FAST", denoise_quality="BALANCED"
)


def switch(**more) -> dict:
    """Arguments of the BoolProperty ``denoise``."""
    return {"name": "Denoise", "default": DEFAULTS.denoise, **more}


def choice(field: str, defaults: DenoiseSettings = DEFAULTS, **more) -> dict:
    """Arguments of the EnumProperty of a field of DenoiseSettings."""
    name, description, texts = _TEXTS[field]
    items = [(value, *texts[value]) for value in DENOISE_CHOICES[field]]
    return {
        "name": name,
        "description": description,
        "items": items,
        "default": getattr(defaults, field),
        **more,
    }
