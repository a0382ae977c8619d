"""The thread that renders for one window region: it sleeps, is given work, shows pictures."""

from __future__ import annotations

import logging
import threading
import time
import weakref
from collections.abc import Callable

from ..core.denoising.denoise import Denoising
from ..core.denoising.view_denoiser import ViewDenoiser
from ..core.machine.watch import StopFlag
from ..core.scene import Scene
from ..core.settings import RenderSettings
from . import dependencies

log = logging.getLogger(__name__)

# Threads that have not ended: another file, unregister and Blender's end wait for them.
_RUNNING: weakref.WeakSet[ViewThread] = weakref.WeakSet()
_JOIN_SECONDS = 2.0


class ViewThread(threading.Thread):
    """Renders the last scene that it was given; knows nothing of Blender but ``redraw``.

    picture: core.windows.shown_picture.Picture, or None; version: counts the pictures
    denoiser: of the pictures; failure: what ended the last work
    first_seconds: from the last request to its first picture
    redraw() may raise ReferenceError where nobody looks any more: the thread then ends.
    """

    def __init__(self, redraw: Callable[[], None]):
        super().__init__(name="iwis-view", daemon=True)
        self._redraw = redraw
        self._condition = threading.Condition()
        self._restart, self._close = StopFlag(), StopFlag()
        self._request: tuple[Scene, RenderSettings, float] | None = None
        self.picture, self.version = None, 0
        self.denoiser, self._again = ViewDenoiser(), False
        self.failure: BaseException | None = None
        self.first_seconds = 0.0
        self.working = False
        _RUNNING.add(self)

    def request(self, scene: Scene, settings: RenderSettings) -> None:
        """Render this from now on."""
        with self._condition:
            self._request = scene, settings, time.perf_counter()
            self.working = True
            self._restart.set()
            self._condition.notify()

    def denoise(self, denoising: Denoising, start: int) -> None:
        """Denoise otherwise from now on, the picture that is there too; nothing is sampled anew."""
        with self._condition:
            self.denoiser.denoising, self.denoiser.start = denoising, start
            self._again = self.working = True
            self._condition.notify()

    def idle(self) -> None:
        """Render nothing until the next request."""
        with self._condition:
            self._request, self.working = None, False
            self._restart.set()

    def close(self) -> None:
        """End soon, and show nothing more."""
        self._close.set()
        with self._condition:
            self._restart.set()
            self._condition.notify()

    def run(self) -> None:
        tools = None
        while True:
            with self._condition:
                while not (self._request or self._again or self._close.is_set()):
                    self._condition.wait()
                if self._close.is_set():
                    return
                request, self._request, self._again = self._request, None, False
                self._restart = restart = StopFlag()
            try:
                if request is not None:
                    scene, settings, asked_at = request
                    tools = tools or _Tools()
                    show = self._taker(asked_at)
                    tools.render(scene, settings, show, restart, self._close, self.denoiser)
                elif self.denoiser.outdated:
                    self._show_otherwise(restart)
                self.failure = None
            except ReferenceError:
                return
            except Exception as error:  # shown in the window by whoever draws it
                if not self._close.is_set():
                    log.error("IWIS: the viewport stopped", exc_info=error)
                    self._fail(error)
            with self._condition:
                self.working = self._request is not None or self._again

    def _show_otherwise(self, restart: StopFlag) -> None:
        """Show the last picture, denoised as it is wanted now."""

        def going(_fraction):
            return not (restart.is_set() or self._close.is_set())

        combined, picture = self.denoiser.again(going), self.picture
        if combined is not None and picture is not None and not restart.is_set():
            layers = {**picture.layers, "combined": combined}
            self._taker(0.0, first=False)(picture._replace(layers=layers))

    def _taker(self, asked_at: float, first: bool = True):
        def show(picture):
            nonlocal first
            if self._close.is_set():
                return
            if first:
                self.first_seconds, first = time.perf_counter() - asked_at, False
            self.picture, self.version = picture, self.version + 1
            self._redraw()

        return show

    def _fail(self, error):
        self.failure, self.picture, self.version = error, None, self.version + 1
        try:
            self._redraw()
        except ReferenceError:
            self._close.set()


class _Tools:
    """What is kept from one picture to the next. Imports the core's kernels."""

    def __init__(self):
        dependencies.require()
        from ..core.embree import moved_accel
        from ..core.render_cache import RenderCache
        from ..core.windows import coarse_pictures, progressive

        self._warm_up = moved_accel.warm_up
        self._cache, self._pace = RenderCache(), coarse_pictures.Pace()
        self._render = progressive.render_progressive

    def render(self, scene, settings, show, restart, close, denoiser):
        self._render(scene, settings, show, self._cache, self._pace, restart, close, denoiser)
        if self._warm_up is not None:
            self._warm_up()
            self._warm_up = None


def close_all() -> None:
    """End every thread, and wait for them a little."""
    threads = list(_RUNNING)
    for thread in threads:
        thread.close()
    for thread in threads:
        if thread.is_alive():
            thread.join(_JOIN_SECONDS)
