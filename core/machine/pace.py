"""How fast a render is here and now, and what can still be done in the time that it has.

Work is counted in costs: a shadow ray is 1, a shading point (its ray, material and product) is
SETUP. What a cost takes is measured all the time: kernels, scenes and machines differ, and so does
what else a machine is doing.
"""

from __future__ import annotations

import contextlib
import threading
import time
from typing import NamedTuple

import numpy as np

SETUP = 8.0
# The pace of a stage begins as that of all before it, which counts as this part of the stage.
_INERTIA = 0.1


class Cost(NamedTuple):
    """Of a tile's part in a stage: what it takes in any case, and what the samples take."""

    fixed: float
    samples: float

    @property
    def total(self) -> float:
        """Both."""
        return self.fixed + self.samples


class Pace:
    """The clock of a render. limit: seconds it may take; 0: as many as it needs."""

    def __init__(self, limit: float):
        self.limit = limit or float("inf")
        self._begun, self._cost = time.perf_counter(), 0.0

    def begin(self) -> None:
        """The time counts from now on."""
        self._begun = time.perf_counter()

    def elapsed(self) -> float:
        """Seconds since it began."""
        return time.perf_counter() - self._begun

    def left(self) -> float:
        """Seconds that are left, not below 0."""
        return max(self.limit - self.elapsed(), 0.0)

    @contextlib.contextmanager
    def alarm(self, stop):
        """Set ``stop`` (watch.StopFlag) when the time is up, while the body runs."""
        if not np.isfinite(self.limit):
            yield
            return
        timer = threading.Timer(self.left(), stop.set)
        timer.daemon = True
        timer.start()
        try:
            yield
        finally:
            timer.cancel()

    def add(self, cost: float) -> None:
        """A stage has ended, which had this cost."""
        self._cost += cost

    def seconds_a_cost(self) -> float:
        """On average so far."""
        return self.elapsed() / max(self._cost, 1.0)

    def affordable(self) -> float:
        """The cost for which there is time."""
        return self.left() / self.seconds_a_cost()


class StageWatch:
    """Tells the tiles of a stage what part of their plan there is time for.

    costs: of each tile that takes part; most: the greatest part; watches: else every part is 1.
    Called by all workers.
    """

    def __init__(self, pace: Pace, costs: dict[int, Cost], most: float, watches: bool):
        self._watches = watches
        self._pace, self._most, self._lock = pace, most, threading.Lock()
        self._waiting, self._in_work, self._done = dict(costs), {}, 0.0
        self._begun, self._before = time.perf_counter(), pace.seconds_a_cost()
        self._total = sum(cost.total for cost in costs.values())

    def begin(self, index: int) -> float:
        """A tile begins: the part of its samples that it is to take."""
        with self._lock:
            part = self._part() if self._watches else 1.0
            cost = self._waiting.pop(index)
            self._in_work[index] = cost.fixed + part * cost.samples
            return part

    def end(self, index: int) -> None:
        """A tile has ended."""
        with self._lock:
            self._done += self._in_work.pop(index)

    def fraction(self) -> float:
        """How much of the stage is done."""
        with self._lock:
            waiting = sum(cost.total for cost in self._waiting.values())
        return 1.0 - waiting / max(self._total, 1e-9)

    def _part(self) -> float:
        half_done = 0.5 * sum(self._in_work.values())
        inertia = _INERTIA * self._total
        seconds = self._before * inertia + time.perf_counter() - self._begun
        pace = seconds / max(inertia + self._done + half_done, 1e-9)
        room = self._pace.left() / pace - half_done
        fixed = sum(cost.fixed for cost in self._waiting.values())
        samples = sum(cost.samples for cost in self._waiting.values())
        return min(max((room - fixed) / max(samples, 1e-9), 0.0), self._most)
