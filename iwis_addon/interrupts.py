"""Ctrl-C and SIGTERM on the command line: a render that ends early, not a traceback.

Python's own KeyboardInterrupt would be lost where it comes at a bad time: bpy reports it as the
failure of whichever add-on it is just loading, and renders on.
"""

from __future__ import annotations

import contextlib
import signal
import threading

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextlib.contextmanager
def interrupts():
    """Give an event that the first signal sets; a second one ends the process at once.

    Signals that the parent process ignores, as a shell's for its background jobs, stay ignored.
    """
    interrupted = threading.Event()
    before = {number: signal.getsignal(number) for number in _SIGNALS}

    def interrupt(_number, _frame):
        interrupted.set()
        for number in _SIGNALS:
            signal.signal(number, signal.SIG_DFL)

    for number, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, interrupt)
    try:
        yield interrupted
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
