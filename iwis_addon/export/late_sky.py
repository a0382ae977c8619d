"""The picture of a Sky Texture in a window: what is there at once, and the right one once it is.

A process of Blender takes seconds for one (sky.py). A slider that is dragged asks for dozens: one
is rendered at a time, then the newest that was asked for.
"""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np

from .sky import Launch, Skies, SkyError, SkyWanted, kept_sky, remember, render_sky


class LateSkies(Skies):
    """Of one window. ``arrived`` is called, by any thread, when there is a sky to be read."""

    def __init__(self, arrived: Callable[[], None]):
        self._arrived = arrived
        self._lock = threading.Lock()
        self._wanted: dict[str, tuple[SkyWanted, str]] = {}  # and the node's name, by key
        self._rendered: dict[str, np.ndarray | SkyError] = {}
        self._shown: dict[str, np.ndarray] = {}  # the last sky, by the node's name
        self._news = self._closed = False
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
                self._wanted[wanted.key] = wanted, node.name
                self._start()
                return self._shown.get(node.name)
            self._rendered.pop(wanted.key, None)
            self._shown[node.name] = sky
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
        while True:
            with self._lock:
                missing = [w for key, w in self._wanted.items() if key not in self._rendered]
                if self._closed or not missing:
                    self._thread = None
                    return
            wanted, name = missing[0]
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
