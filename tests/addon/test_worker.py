"""A cancel is answered within 0.2 s, whatever the work is doing, and finished tiles are kept."""

import threading
import time

import numpy as np
import pytest

from iwis.core.film import Film, Progress, Tile, new_layers
from iwis.core.settings import RenderSettings
from iwis.iwis_addon import sink
from iwis.iwis_addon.worker import run_in_worker


class CancelAfter(Film):
    """A film that is told to stop `seconds` after its making, and remembers who called it."""

    def __init__(self, seconds):
        super().__init__((0, 0, 4, 4))
        self.cancel_at = time.perf_counter() + seconds
        self.threads = set()
        self.texts = []

    def write_tile(self, tile):
        self.threads.add(threading.get_ident())
        super().write_tile(tile)

    def progress(self, progress):
        self.threads.add(threading.get_ident())
        self.texts.append(progress.phase)

    def cancelled(self):
        return time.perf_counter() >= self.cancel_at


def tile(x=0, value=1.0):
    layers = new_layers(2, 2)
    layers["combined"][:] = value
    return Tile(x, 0, 2, 2, layers)


def test_result_tiles_and_progress_arrive_in_the_callers_thread():
    """The sink is called by the thread that called run_in_worker(), only."""
    sink = CancelAfter(60.0)

    def work(relay):
        assert threading.get_ident() not in sink.threads
        relay.progress(Progress("bvh", 0.5))
        relay.write_tile(tile())
        return "done"

    assert run_in_worker(work, sink) == "done"
    assert sink.threads == {threading.get_ident()}
    assert sink.texts == ["bvh"]
    assert (sink.layers["combined"][:2, :2] == 1.0).all()


@pytest.mark.parametrize("first", ["nothing", "a tile"])
def test_cancel_is_answered_while_the_work_is_deaf(first):
    """Work that never asks is left behind after 0.2 s; the tile that was done is there."""
    sink, release = CancelAfter(0.3), threading.Event()

    def work(relay):
        if first == "a tile":
            relay.write_tile(tile())
        release.wait(10.0)

    result = run_in_worker(work, sink)
    answered = time.perf_counter() - sink.cancel_at
    release.set()
    assert result is None
    assert answered < 0.2
    assert np.any(sink.layers["combined"]) == (first == "a tile")


def test_tiles_that_follow_a_cancel_at_once_are_kept():
    """The core hands over the tiles in work when it is told to stop."""
    sink = CancelAfter(0.1)

    def work(relay):
        relay.progress(Progress("sampling", 0.0))
        while not relay.cancelled():
            time.sleep(0.01)
        relay.write_tile(tile(x=2, value=3.0))
        return "stopped"

    assert run_in_worker(work, sink) == "stopped"
    assert (sink.layers["combined"][:2, 2:] == 3.0).all()


def test_errors_of_the_work_are_raised_here():
    """What was done before an error is kept, the error is not swallowed."""
    sink = CancelAfter(60.0)

    def work(relay):
        relay.write_tile(tile())
        raise ValueError("no memory for the tables")

    with pytest.raises(ValueError, match="tables"):
        run_in_worker(work, sink)
    assert np.any(sink.layers["combined"])


def test_an_error_of_the_sink_stops_the_work():
    """Work goes on for nobody when its tiles cannot be taken."""
    stopped = threading.Event()

    class Full(CancelAfter):
        def write_tile(self, tile):
            raise OSError("disk full")

    def work(relay):
        relay.write_tile(tile())
        while not relay.cancelled():
            time.sleep(0.01)
        stopped.set()

    with pytest.raises(OSError, match="disk full"):
        run_in_worker(work, Full(60.0))
    assert stopped.wait(5.0)


@pytest.mark.parametrize("in_window", [False, True])
def test_a_line_tells_the_time_once(monkeypatch, in_window):
    """A farm's log has the time of sampling; above a window's picture stands Blender's own."""
    monkeypatch.setattr(sink, "_TELLS_TIME", not in_window)
    told = sink.BlenderSink(None, "Layer", "", [], (0, 0, 8, 8), RenderSettings(max_samples=16))
    line = told.line(Progress("sampling", 0.5, 1, 2, samples=32 * 16), 3.0, 100.0)
    time_told = "" if in_window else "Time:00:03.00 | "
    rest = "Remaining:00:03.00 | Layer | Rendered 1/2 Tiles, Sample 16/16"
    assert line == f"Mem:100.00M | {time_told}{rest}"
