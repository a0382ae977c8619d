"""Long work in a thread of its own, while the caller's thread listens for a cancel."""

from __future__ import annotations

import queue
import threading

import numpy as np

from ..film import Progress

# How long the caller's thread waits before it asks the sink again: a cancel is seen this soon.
POLL_SECONDS = 0.05


class StopFlag:
    """A threading.Event that machine code can read: raised by any thread, never taken back."""

    def __init__(self):
        self.memory = np.zeros(1, np.uint8)

    def set(self) -> None:
        """Ask everybody to stop."""
        self.memory[0] = 1

    def is_set(self) -> bool:
        """Whether somebody has."""
        return bool(self.memory[0])


class Cancelled(Exception):
    """Ends a long build that nobody waits for any more."""


def watched(work, sink, stop, phase):
    """work(tell) in a thread of its own, while the sink is asked whether to stop; None if it was.

    tell(fraction, text) passes progress on. Nobody waits for work that was cancelled: it sees
    ``stop`` and ends unseen.
    """
    box: dict = {}
    said = queue.SimpleQueue()

    def run():
        try:
            box["result"] = work(lambda fraction, text: said.put((fraction, text)))
        except BaseException as error:  # raised again in the caller's thread
            box["error"] = error

    thread = threading.Thread(target=run, name=f"iwis-{phase}", daemon=True)
    thread.start()
    sink.progress(Progress(phase=phase, fraction=0.0))
    try:
        while thread.is_alive():
            thread.join(POLL_SECONDS)
            while not said.empty():
                fraction, text = said.get()
                sink.progress(Progress(phase=phase, fraction=fraction, text=text))
            if sink.cancelled():
                stop.set()
                return None
    except BaseException:  # the sink's: the work is not waited for either
        stop.set()
        raise
    if "error" in box:
        raise box["error"]
    return box["result"]
