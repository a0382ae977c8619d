"""Whoever takes the engine from Blender first ends what other threads render with it."""

import threading

import pytest

from iwis.iwis_addon import callbacks
from iwis.iwis_addon.job import RenderJob

SECONDS = 20.0  # that no test may wait


class Rendering(threading.Thread):
    """As a thread of Blender's in a callback, which looks for a cancel as a user's Esc is one."""

    def __init__(self, listens: bool):
        super().__init__(daemon=True)
        self._listens, self.inside, self.leave = listens, threading.Event(), threading.Event()
        self.start()
        assert self.inside.wait(SECONDS)

    def run(self):
        with callbacks.inside():
            self.inside.set()
            ends = RenderJob.interrupt if self._listens else self.leave
            ends.wait(SECONDS)


def test_a_callback_of_another_thread_is_ended_and_waited_for():
    """It is told to end, has left when end_all() returns, and the next render may go on."""
    thread = Rendering(listens=True)
    assert callbacks.end_all(SECONDS)
    thread.join(SECONDS)
    assert not thread.is_alive()
    assert not RenderJob.interrupt.is_set()


def test_one_that_does_not_answer_is_not_waited_for_without_end():
    """The time is over, and that is told."""
    thread = Rendering(listens=False)
    assert not callbacks.end_all(0.1)
    thread.leave.set()
    thread.join(SECONDS)
    assert callbacks.end_all(0.1)


def test_a_callback_does_not_wait_for_itself():
    """A handler that disables the add-on in a render of this very thread."""
    with callbacks.inside():
        assert callbacks.end_all(SECONDS)
        assert not RenderJob.interrupt.is_set()


def test_an_exception_leaves_as_well():
    """Nobody waits for a callback that has failed."""
    with pytest.raises(ValueError, match="bad"), callbacks.inside():
        raise ValueError("bad")
    assert not callbacks._inside
