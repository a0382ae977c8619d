"""The pictures of a window without their noise, while their rounds go on.

The denoiser takes as long as some rounds. So pictures between two denoised ones are left out, and
it takes half of the time at the most: it waits until sampling has had as much since the last one.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..scene import Scene
from ..settings import DenoiseSettings, RenderSettings
from .denoise import Denoising, Guided, denoise_apart, prepared

OFF = Denoising(DenoiseSettings())


class _Given(NamedTuple):
    """The last picture, to be denoised otherwise. samples: of a pixel at the most"""

    guided: Guided
    scene: Scene
    settings: RenderSettings
    threads: int
    samples: int


class ViewDenoiser:
    """Of one view: its settings may change at any time, by another thread.

    denoising, start: what is wanted, and from how many samples of a pixel on
    problem: why the last picture kept its noise; working: whether one is being denoised
    shows: whether the last one has no noise: pictures with noise are to wait
    """

    def __init__(self):
        self.denoising, self.start = OFF, 1
        self.problem, self.working, self.shows = "", False, False
        self._given: _Given | None = None
        self._used: tuple[Denoising, int] | None = None
        self._seconds, self._ended = 0.0, -np.inf

    def begin(self) -> bool:
        """Forget the picture before; whether the next one is to keep what a denoiser needs."""
        self._given, self._used, self.shows = None, None, False
        self._seconds, self._ended = 0.0, -np.inf
        return self.denoising.settings.denoise

    def due(self, samples: int) -> bool:
        """Whether a picture of so many samples is to be denoised while better ones are to come."""
        return self._wants(samples) and time.perf_counter() - self._ended > self._seconds

    def _wants(self, samples: int) -> bool:
        return self.denoising.settings.denoise and samples >= self.start

    @property
    def outdated(self) -> bool:
        """Whether the last picture was denoised otherwise than is wanted now."""
        return self._given is not None and self._used != (self.denoising, self.start)

    def take(
        self,
        guided: Guided,
        scene: Scene,
        settings: RenderSettings,
        threads: int,
        samples: int,
        going: Callable[[float], bool],
    ) -> np.ndarray:
        """Combined as it is to be shown, of a picture of the scene by the settings.

        samples: that its pixels have at the most; threads, going: of denoise_apart
        """
        self._given = _Given(guided, scene, settings, threads, samples)
        return self.again(going)

    def again(self, going: Callable[[float], bool]) -> np.ndarray | None:
        """The last picture as it is wanted now; None where there is none."""
        given, wanted = self._given, self.denoising
        if given is None:
            return None
        self._used, self.problem, self.shows = (wanted, self.start), "", False
        if not self._wants(given.samples):
            return given.guided.combined
        known, own = prepared(given.guided, wanted.settings, given.scene, given.settings)
        started, self.working = time.perf_counter(), True
        try:
            out = denoise_apart(known, wanted._replace(settings=own), given.threads, going)
        except (OSError, MemoryError, RuntimeError) as error:
            self.problem, out = f"The view keeps its noise: {error}", None
        finally:
            self.working, self._ended = False, time.perf_counter()
            self._seconds = self._ended - started
        self.shows = out is not None
        return out if self.shows else given.guided.combined
