"""core/machine/tile_pool.py: a pool ends as soon as its workers have."""

import threading
import time

from iwis.core.machine.tile_pool import run_pool
from iwis.core.machine.watch import StopFlag


def test_a_cancel_waits_for_the_work_at_hand_alone():
    """Several times: a pool that asked now and then whether its workers live took 0.05 s more."""
    ends = []
    for _ in range(5):
        stop, began = StopFlag(), threading.Event()

        def work(item, stop=stop, began=began):
            began.set()
            while not stop.is_set():
                time.sleep(0.001)
            return item

        taken = []
        started = time.perf_counter()
        assert run_pool(range(100), 2, work, taken.append, began.is_set, stop)
        ends.append(time.perf_counter() - started)
        assert sorted(taken) == [0, 1]  # what was in work is taken
    assert min(ends) < 0.04


def test_the_last_results_are_taken_before_the_end():
    taken = []
    assert not run_pool(range(50), 3, lambda item: item, taken.append, lambda: False, StopFlag())
    assert sorted(taken) == list(range(50))
    assert not run_pool([], 3, None, taken.append, lambda: True, StopFlag())
