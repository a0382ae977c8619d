"""What is compared, and how far: all data of the suite in one place.

A configuration has one knob (a count, a threshold) that is turned step by step until the smallest
of TARGETS is reached; each step is one point of the curve of error against CPU time.
"""

from __future__ import annotations

from typing import NamedTuple

from iwis.core.settings import RenderSettings

TARGETS = (0.10, 0.05, 0.02)  # mean relative errors whose cost is wanted
EDGE_RADIUS_PX = 0.02  # pixels with an edge so near to their centre are left out
UNLIMITED = 1 << 14  # max_samples where a rule shall end a pixel


class Configuration(NamedTuple):
    """One way to make the picture.

    renderer: "iwis" (the product's own way), "core" (reference.py), "cycles" or "mitsuba"
    settings: RenderSettings of iwis; method of core; emitter and BSDF samples of mitsuba
    knob, first, factor: what is turned; its value in step k is first * factor ** k
    """

    name: str
    renderer: str
    settings: dict
    knob: str
    first: float
    factor: float

    def value(self, step: int) -> float:
        """The knob in a step: a whole number where the knob is a count."""
        value = self.first * self.factor**step
        return value if self.factor < 1.0 else round(value)


FIXED = "IWIS, fixed count"
DEFAULT, PAPER = "IWIS, PERCEPTUAL", "IWIS, paper's rule"
CYCLES = "Cycles"
WIS, MIS = "WIS, fixed count", "MIS, own core"


def _ruled(name: str, rule: str) -> Configuration:
    """IWIS where a rule ends the pixels; two steps halve its threshold, one doubles the samples."""
    settings = {"stop_rule": rule, "max_samples": UNLIMITED}
    return Configuration(name, "iwis", settings, "error_threshold", 0.8, 0.5**0.5)


CONFIGURATIONS = (
    Configuration(FIXED, "iwis", {"stop_rule": "FIXED"}, "max_samples", 4, 2),
    _ruled(DEFAULT, "PERCEPTUAL"),
    _ruled(PAPER, "PAPER"),
    Configuration(WIS, "core", {"method": "wis"}, "max_samples", 8, 2),
    Configuration("light only, own core", "core", {"method": "light"}, "max_samples", 8, 2),
    Configuration(MIS, "core", {"method": "mis"}, "max_samples", 8, 2),
    Configuration(CYCLES, "cycles", {}, "max_samples", 8, 2),
    Configuration("Mitsuba, emitter", "mitsuba", {"emitter": 1, "bsdf": 0}, "max_samples", 4, 2),
    Configuration("Mitsuba, MIS", "mitsuba", {"emitter": 1, "bsdf": 1}, "max_samples", 4, 2),
)


class Effort(NamedTuple):
    """How long a part may take.

    repeats: of one point where a render takes less than short_seconds of CPU; else 1
    render_seconds: of CPU, by renderer: a curve ends before a render that may take longer
    reference_noise: own error at which a reference is good enough
    reference_seconds: of CPU, by renderer, after which a reference must do
    reference_samples: of one of the pictures that are averaged
    ray_samples: fixed counts of the part rays; thread_samples: that of the part threads
    picture_error: the error that IWIS' picture has where all get its CPU time
    check_seconds: of CPU, of a picture of Cycles for the difference image
    """

    render_seconds: dict
    reference_seconds: dict
    repeats: int = 3
    short_seconds: float = 1.5
    reference_noise: float = 0.006
    reference_samples: int = 1024
    ray_samples: tuple[int, ...] = (32, 128)
    thread_samples: int = 64
    picture_error: float = 0.07
    check_seconds: float = 12.0


FULL = Effort(
    render_seconds={"iwis": 8.0, "core": 8.0, "cycles": 30.0, "mitsuba": 12.0},
    reference_seconds={"iwis": 60.0, "mitsuba": 40.0},
)
QUICK = Effort(
    render_seconds={"iwis": 1.0, "core": 1.0, "cycles": 4.0, "mitsuba": 1.0},
    reference_seconds={"iwis": 4.0, "mitsuba": 2.0},
    repeats=1,
    short_seconds=0.5,
    reference_noise=0.02,
    reference_samples=256,
    ray_samples=(4, 8),
    thread_samples=8,
    picture_error=0.15,
    check_seconds=1.0,
)


class Picture(NamedTuple):
    """Arguments of a scene's function in scenes.py, whole and with --quick."""

    full: dict
    quick: dict


SCENES = {
    "statue_diffuse": Picture({}, {"detail": 0.3, "size": (40, 80)}),
    "statue_glossy": Picture({}, {"detail": 0.3, "size": (40, 80)}),
    "foliage": Picture({"size": (192, 192)}, {"size": (40, 40)}),
    "interior": Picture({"size": (160, 120)}, {"size": (48, 36)}),
}


def base_settings(threads: int) -> RenderSettings:
    """One shading point at the centre of a pixel, as all that are compared."""
    return RenderSettings(estimator="UNBIASED", pixel_filter="CENTER", threads=threads)
