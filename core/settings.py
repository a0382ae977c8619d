"""Every setting of a render: its name, its default, what it may be. The one home of defaults."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

ESTIMATORS = ("PAPER", "UNBIASED")
STOP_RULES = ("PERCEPTUAL", "PAPER", "FIXED", "BUDGET")
PIXEL_FILTERS = ("CENTER", "BOX", "BLACKMAN_HARRIS", "GAUSSIAN")
DECORRELATIONS = ("OWEN", "PIXEL", "NONE")
DENOISE_PASSES = ("NONE", "ALBEDO", "ALBEDO_NORMAL")
DENOISE_PREFILTERS = ("NONE", "FAST", "ACCURATE")
DENOISE_QUALITIES = ("HIGH", "BALANCED", "FAST")

# Bounds, shared by Blender's sliders, the command line and the checks: name -> (low, high).
LIMITS = {
    "error_threshold": (0.0, 10.0),
    "max_samples": (1, 1 << 20),
    "target_samples": (0, 1 << 20),
    "time_limit": (0.0, 1e7),
    "batch_size": (1, 1024),
    "coefficients": (0.001, 1.0),
    "seed": (0, (1 << 31) - 1),
    "threads": (0, 1024),
    "filter_width": (0.01, 10.0),
    "transparent_max_bounces": (0, 1024),
    "tile_px": (8, 256),
}
CHOICES = {
    "estimator": ESTIMATORS,
    "stop_rule": STOP_RULES,
    "pixel_filter": PIXEL_FILTERS,
    "decorrelation": DECORRELATIONS,
}
# Those of DenoiseSettings.
DENOISE_CHOICES = {
    "denoise_passes": DENOISE_PASSES,
    "denoise_prefilter": DENOISE_PREFILTERS,
    "denoise_quality": DENOISE_QUALITIES,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class RenderSettings:
    """What a user may choose of sampling. [Huang07, algorithm 1] names E, MAX and n.

    error_threshold: E (0: no pixel is done before max_samples). PERCEPTUAL: the relative noise to
        be left in a pixel with half of its light hidden; E r^.625 in one whose samples spread r
        times as much. A picture's mean relative error comes out near E / 2 where most of it sees
        its light, near E on foliage, above where most is dark. PAPER: a pixel is done when e_d <= E
    max_samples: MAX, the most shadow rays of one pixel
    batch_size: n, Halton points a round
    estimator: PAPER (I_s K / N from the tables) or UNBIASED (each sample weighted by L B / pdf)
    stop_rule: PERCEPTUAL (samples where they lower the mean relative error most), PAPER
        (e_d <= E), FIXED (max_samples everywhere) or BUDGET (shared out as PERCEPTUAL does, but so
        that target_samples or time_limit is used up, whichever is sooner; E is not asked)
    target_samples: BUDGET: the mean count of the pixels that show an object; 0: none is set
    time_limit: BUDGET: seconds of sampling, all that is before it (export, light, BVH, kernels)
        not counted, as Cycles means it; 0: none is set
    coefficients: fraction of the Haar coefficients that the paper's tables keep
    pixel_filter: CENTER, one shading point at the pixel's centre; BOX, GAUSSIAN or BLACKMAN_HARRIS,
        several, each with n samples, spread as Cycles' filter of that name weighs
    filter_width: pixels, as Cycles means them: how far BLACKMAN_HARRIS reaches to either side, four
        standard deviations of GAUSSIAN; BOX
        is one pixel wide in any case
    transparent_max_bounces: how many surfaces that let it through one ray of the camera goes
        through; of what it meets then it shows what glows alone, as in Cycles
    decorrelation: what makes the points of two pixels differ: OWEN (Sobol's sequence, scrambled by
        a hash of pixel and seed; estimator PAPER takes PIXEL instead), PIXEL (Halton's, shifted by
        it) or NONE (Halton's, as printed in the paper)
    seed: changes every scramble and shift
    threads: worker threads, 0 = as many as cores; never more than four a core
    tile_px: side of a tile in pixels at the most; pictures do not depend on it; multiples of 8
        are the fastest
    cache_dir: folder of the tables; empty = the user's cache folder
    """

    error_threshold: float = 0.1
    max_samples: int = 256
    target_samples: int = 64
    time_limit: float = 0.0
    batch_size: int = 8
    estimator: str = "UNBIASED"
    stop_rule: str = "PERCEPTUAL"
    coefficients: float = 0.05
    pixel_filter: str = "BLACKMAN_HARRIS"
    filter_width: float = 1.5
    transparent_max_bounces: int = 8
    decorrelation: str = "OWEN"
    seed: int = 0
    threads: int = 0
    tile_px: int = 64
    cache_dir: str = ""

    def __post_init__(self):
        for name, (low, high) in LIMITS.items():
            value = getattr(self, name)
            kind = int if isinstance(low, int) else float
            if isinstance(value, bool) or not isinstance(value, (int, kind)):
                raise ValueError(f"setting {name}: {value!r} is not {_a_number(kind)}")
            if not low <= value <= high:  # NaN fails this too
                raise ValueError(f"setting {name}: {value!r} is outside {low} ... {high}")
        _check_choices(self, CHOICES)
        if self.stop_rule == "BUDGET" and not (self.target_samples or self.time_limit):
            raise ValueError("setting stop_rule: BUDGET needs target_samples or time_limit above 0")

    @property
    def point_set(self) -> str:
        """decorrelation as the estimator has it: the paper's points are Halton's."""
        halton = self.estimator == "PAPER" and self.decorrelation == "OWEN"
        return "PIXEL" if halton else self.decorrelation


@dataclass(frozen=True, slots=True, kw_only=True)
class DenoiseSettings:
    """What is to become of the noise that is left; the samples do not know of it (denoise.py).

    denoise: whether Open Image Denoise takes it away
    denoise_passes: what tells it noise from detail: NONE, ALBEDO or ALBEDO_NORMAL
    denoise_prefilter: of these passes: NONE (they have no noise), FAST (they may have some) or
        ACCURATE (their own noise is taken away first)
    denoise_quality: HIGH, BALANCED or FAST
    """

    denoise: bool = False
    denoise_passes: str = "ALBEDO_NORMAL"
    denoise_prefilter: str = "ACCURATE"
    denoise_quality: str = "HIGH"

    def __post_init__(self):
        if not isinstance(self.denoise, bool):
            raise ValueError(f"setting denoise: {self.denoise!r} is neither True nor False")
        _check_choices(self, DENOISE_CHOICES)


def _check_choices(settings, all_choices) -> None:
    for name, choices in all_choices.items():
        value = getattr(settings, name)
        if value not in choices:
            raise ValueError(f"setting {name}: {value!r} is none of {', '.join(choices)}")


def settings_from_strings(pairs: dict[str, str]) -> tuple[RenderSettings, DenoiseSettings]:
    """Settings from NAME=VALUE texts, as on the command line. Raises ValueError by name."""
    kinds = (RenderSettings, DenoiseSettings)
    fields = {field.name: field for kind in kinds for field in dataclasses.fields(kind)}
    values = {}
    for name, text in pairs.items():
        if name not in fields:
            raise ValueError(f"no setting {name!r}; there are {', '.join(fields)}")
        values[name] = _parse(name, text, fields[name].type)
    return tuple(
        kind(**{name: value for name, value in values.items() if name in kind.__slots__})
        for kind in kinds
    )


def _a_number(kind) -> str:
    return "a whole number" if kind is int else "a number"


def _parse(name, text, type_name):
    if type_name == "str":
        return text.upper() if name in CHOICES | DENOISE_CHOICES else text
    if type_name == "bool":
        known = {"true": True, "1": True, "false": False, "0": False}
        return known.get(text.lower(), text)  # what it is not, the settings refuse
    kind = {"int": int, "float": float}[type_name]
    try:
        return kind(text)
    except ValueError:
        raise ValueError(f"setting {name}: {text!r} is not {_a_number(kind)}") from None
