"""core/machine/watch.py: long work is listened to, and can be left."""

import threading
import time

import pytest

from iwis.core.film import Film
from iwis.core.machine.watch import Cancelled, watched


class _Sink(Film):
    """A film that notes progress and cancels after so many questions."""

    def __init__(self, cancel_after=None):
        super().__init__((0, 0, 1, 1))
        self.said, self.questions, self.cancel_after = [], 0, cancel_after
        self.threads = set()

    def progress(self, progress):
        self.threads.add(threading.get_ident())
        self.said.append(progress)

    def cancelled(self):
        self.threads.add(threading.get_ident())
        self.questions += 1
        return self.cancel_after is not None and self.questions > self.cancel_after


def test_result_comes_back_and_progress_is_passed_on():
    """All that the work tells reaches the sink, in order, from the caller's thread."""
    sink = _Sink()

    def work(tell):
        assert threading.get_ident() not in sink.threads
        tell(0.25, "a")
        tell(0.75, "b")
        time.sleep(0.1)
        return 42

    assert watched(work, sink, threading.Event(), "tables") == 42
    assert [(p.phase, p.fraction, p.text) for p in sink.said] == [
        ("tables", 0.0, ""),
        ("tables", 0.25, "a"),
        ("tables", 0.75, "b"),
    ]
    assert sink.threads == {threading.get_ident()}


def test_errors_are_raised_in_the_caller():
    """The very exception, not a message about it."""
    error = OSError("no room")

    def work(tell):
        raise error

    with pytest.raises(OSError) as caught:
        watched(work, _Sink(), threading.Event(), "bvh")
    assert caught.value is error


@pytest.mark.parametrize("cancel_after", [0, 2])
def test_cancel_returns_at_once_and_tells_the_work(cancel_after):
    """Within 0.2 s of the sink's answer, although the work goes on; ``stop`` is set for it."""
    stop, finished = threading.Event(), threading.Event()

    def work(tell):
        assert stop.wait(10.0)
        time.sleep(0.5)
        finished.set()

    start = time.perf_counter()
    assert watched(work, _Sink(cancel_after), stop, "bvh") is None
    assert time.perf_counter() - start < 0.2 + 0.06 * cancel_after  # a question every 0.05 s
    assert stop.is_set() and not finished.is_set()
    assert finished.wait(10.0)


def test_a_build_that_ends_by_cancel_is_no_error():
    """Cancelled, raised by the work after a cancel, stays unseen."""
    stop = threading.Event()

    def work(tell):
        stop.wait(10.0)
        raise Cancelled

    assert watched(work, _Sink(0), stop, "tables") is None


def test_an_error_of_the_sink_stops_the_work():
    """Nobody will ask for the result: the work hears of it, the error comes through."""
    stop = threading.Event()

    class Broken(_Sink):
        def cancelled(self):
            raise OSError("no display")

    with pytest.raises(OSError, match="no display"):
        watched(lambda tell: stop.wait(10.0), Broken(), stop, "bvh")
    assert stop.is_set()
