"""The picture of a Sky Texture in a window: what is there at once, and the right one once it is.

A process of Blender takes seconds for one (sky.py). A slider that is dragged asks for dozens: one
is rendered when it comes to rest, or has not for a while; then the newest that was asked for.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np

from ..images.sky import Launch, Skies, SkyError, SkyWanted, kept_sky, remember, render_sky
from ..shaders.seen_tree import name_of

# How long a slider has not moved when it rests; how long one that never rests is waited for.
_REST_SECONDS, _LONGEST_SECONDS = 0.25, 2.0


class LateSkies(Skies):
    """Of one window. ``arrived`` is called, by any thread, when there is a sky to be read."""

    def __init__(self, arrived: Callable[[], None]):
        self._arrived = arrived
        self._lock = threading.Lock()
        self._wanted: dict[str, tuple[SkyWanted, str]] = {}  # and the node's name, by key
        self._rendered: dict[str, np.ndarray | SkyError] = {}
        self._shown: dict[str, np.ndarray] = {}  # the last sky, by the node's name
        self._news = self._closed = False
        self._newest, self._asked_at = "", 0.0  # the last key, and when it was first asked for
        self._launch: Launch | None = None
        self._thread = self._child = None

    @property
    def waiting(self) -> bool:
        """Whether what was read last is not what was asked for."""
        return bool(self._wanted)

    def begin(self) -> None:
        """See Skies."""
        with self._lock:
            self._wanted.clear()
            self._news = False

    def read(self, node) -> np.ndarray | None:
        """As Skies.read, at once: the node's last sky, or None, while it is being rendered."""
        wanted = SkyWanted.of(node)
        with self._lock:
            sky = self._rendered.get(wanted.key)
        if isinstance(sky, SkyError):
            raise sky
        if sky is not None:
            remember(wanted, sky)
        sky = kept_sky(wanted)
        with self._lock:
            if sky is None:
                if wanted.key != self._newest:
                    self._newest, self._asked_at = wanted.key, time.monotonic()
                self._wanted[wanted.key] = wanted, name_of(node)
                self._start()
                return self._shown.get(name_of(node))
            self._rendered.pop(wanted.key, None)
            self._shown[name_of(node)] = sky
        return sky

    def take(self) -> bool:
        """Whether there is a sky that read did not give yet; once for each."""
        with self._lock:
            news, self._news = self._news, False
        return news

    def close(self) -> None:
        """Render none any more."""
        with self._lock:
            self._closed = True
            if self._child is not None:
                self._child.kill()

    def _start(self):
        if self._thread is None and not self._closed:
            self._launch = Launch.here()
            self._thread = threading.Thread(target=self._work, name="iwis-sky", daemon=True)
            self._thread.start()

    def _work(self):
        began = time.monotonic()
        while True:
            with self._lock:
                missing = [w for key, w in self._wanted.items() if key not in self._rendered]
                if self._closed or not missing:
                    self._thread = None
                    return
                rest = self._asked_at + _REST_SECONDS - time.monotonic()
            if rest > 0.0 and time.monotonic() - began < _LONGEST_SECONDS:
                time.sleep(min(rest, 0.05))
                continue
            self._render(*missing[0])
            began = time.monotonic()

    def _render(self, wanted: SkyWanted, name: str):
        try:
            sky = render_sky(wanted, self._launch, self._started)
        except SkyError as error:
            sky = error
        with self._lock:
            self._take_in(wanted, name, sky)
        try:
            self._arrived()
        except ReferenceError:  # nobody looks any more
            self.close()

    def _take_in(self, wanted: SkyWanted, name: str, sky):
        self._child = None
        if wanted.key in self._wanted:
            self._rendered[wanted.key] = sky
            for key in self._rendered.keys() - self._wanted.keys():
                if not isinstance(self._rendered[key], SkyError):
                    del self._rendered[key]
        if not isinstance(sky, SkyError):
            self._shown[name] = sky  # even if it is not wanted any more: nearer than the last
        self._news = True

    def _started(self, child):
        with self._lock:
            self._child = child
            if self._closed:
                child.kill()
