"""Every way to make the picture, behind one call: method(value, seed) -> Shot."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from configurations import Configuration
from run_core import CoreRun
from run_cycles import render_cycles
from run_iwis import IwisRun


class Shot(NamedTuple):
    """One render. rgb: (h, w, 3); samples: mean over object pixels; cpu, wall: seconds.

    wall is 0 where only the CPU's time is known.
    """

    rgb: np.ndarray
    samples: float
    cpu: float
    wall: float = 0.0


class Renderers(NamedTuple):
    """What is open and loaded: the file in bpy, its export, own estimators, Mitsuba or None."""

    scene: object
    iwis: IwisRun
    core: CoreRun
    mitsuba: object | None


def make_method(configuration: Configuration, renderers: Renderers):
    """The call for a configuration; None where its renderer or its settings are not there."""
    makers = {"iwis": _iwis, "core": _core, "cycles": _cycles, "mitsuba": _mitsuba}
    return makers[configuration.renderer](configuration, renderers)


def _iwis(configuration, renderers):
    run = renderers.iwis
    try:
        run.settings(**configuration.settings)
    except (TypeError, ValueError):  # a rule that this version does not have
        return None

    def render(value, seed):
        changes = configuration.settings | {configuration.knob: value, "seed": seed}
        film, stats = run.render(**changes)
        rgb = film.layers["combined"][..., :3]
        return Shot(
            rgb, stats.samples_mean, stats.cpu_seconds["sampling"], stats.seconds["sampling"]
        )

    return render


def _core(configuration, renderers):
    def render(value, seed):
        made = renderers.core.render(configuration.settings["method"], value, seed)
        return Shot(made.rgb, float(value), made.cpu, made.wall)

    return render


def _cycles(configuration, renderers):
    def render(value, seed):
        timed = render_cycles(renderers.scene, value, seed=seed)
        return Shot(timed.rgb, float(value), timed.cpu)

    return render


def _mitsuba(configuration, renderers):
    if renderers.mitsuba is None:
        return None

    def render(value, seed):
        made = renderers.mitsuba.render(value, seed, **configuration.settings)
        return Shot(made.rgb, float(made.samples), made.cpu, made.wall)

    return render


def reference_method(renderer: str, renderers: Renderers):
    """render(samples, seed) for converged.converge(): IWIS at a fixed count, or Mitsuba's MIS."""

    def iwis(samples, seed):
        film, stats = renderers.iwis.render(stop_rule="FIXED", max_samples=samples, seed=seed)
        return film.layers["combined"][..., :3], samples, stats.cpu_seconds["sampling"]

    def mitsuba(samples, seed):
        made = renderers.mitsuba.render(samples, seed, emitter=1, bsdf=1)
        return made.rgb, made.samples, made.cpu

    return {"iwis": iwis, "mitsuba": mitsuba}[renderer]
