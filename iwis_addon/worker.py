"""Work in a thread of its own, so that Blender's thread can always answer a cancel.

Blender may be called by one thread only, and a user who cancels waits at most 0.2 s. So the core
renders in a thread, its tiles come through a queue, and the thread that Blender called writes them
and asks for a cancel meanwhile, whatever the core is doing (compiling a kernel, building a BVH).
"""

from __future__ import annotations

import queue
import threading
import time

from ..core.film import Progress, Tile, TileSink

POLL_SECONDS = 0.01
GRACE_SECONDS = 0.1  # for the core to hand over its last tiles after a cancel
_DONE = object()


class _Relay:
    """The sink that the core sees: hands tiles and progress to Blender's thread."""

    def __init__(self):
        self.items = queue.SimpleQueue()
        self.stop = threading.Event()

    def write_tile(self, tile: Tile) -> None:
        self.items.put(tile)

    def progress(self, progress: Progress) -> None:
        self.items.put(progress)

    def cancelled(self) -> bool:
        return self.stop.is_set()


class _Worker(threading.Thread):
    def __init__(self, work, relay):
        super().__init__(name="iwis-render")
        self._work, self._relay = work, relay
        self.result = self.error = None

    def run(self):
        try:
            self.result = self._work(self._relay)
        except BaseException as error:  # raised again in the thread that waits
            self.error = error
        finally:
            self._relay.items.put(_DONE)


def run_in_worker(work, sink: TileSink, grace_seconds: float = GRACE_SECONDS):
    """Run `work(relay)` in a thread and feed `sink` from this one; return what `work` returned.

    grace_seconds: how long the last tiles are waited for after a cancel

    Raises what `work` raised. After a cancel that `work` does not answer in time it is left to end
    by itself, and None is returned: tiles that are done by then have reached the sink.
    """
    relay = _Relay()
    worker = _Worker(work, relay)
    worker.start()
    try:
        finished = _feed(relay, sink, grace_seconds)
    finally:
        relay.stop.set()
    if not finished:
        return None
    worker.join()
    if worker.error is not None:
        raise worker.error
    return worker.result


def _feed(relay: _Relay, sink: TileSink, grace_seconds: float) -> bool:
    """Pass items on until the work is done (True), or the time after a cancel is over (False)."""
    started = False
    while not sink.cancelled():
        item = _next(relay, POLL_SECONDS)
        if item is _DONE:
            return True
        started |= item is not None
        _pass_on(item, sink)
    relay.stop.set()
    deadline = time.monotonic() + grace_seconds if started else 0.0
    while (item := _next(relay, max(deadline - time.monotonic(), 0.0))) is not _DONE:
        if item is None:
            return False
        _pass_on(item, sink)
    return True


def _next(relay, seconds):
    try:
        return relay.items.get(timeout=seconds)
    except queue.Empty:
        return None


def _pass_on(item, sink):
    if isinstance(item, Tile):
        sink.write_tile(item)
    elif isinstance(item, Progress):
        sink.progress(item)
