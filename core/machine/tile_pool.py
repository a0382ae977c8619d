"""Work in threads, results on the caller's thread, which also asks whether to stop.

Workers never call the sink: Blender's data is touched by one thread only.
"""

from __future__ import annotations

import queue
import threading

from .turns import Turns

# How long the caller's thread waits for a result before it asks whether to stop.
_POLL_SECONDS = 0.01
_ENDED = object()  # what a worker says last


def run_pool(items, threads: int, work, take, cancelled, stop) -> bool:
    """Call take(work(item)) for every item: whether ``cancelled`` said stop before the end.

    work: called by one of ``threads`` workers, in the order of items; take: by the caller's thread.
    cancelled: asked every 0.01 s; then ``stop`` is set, no further item is begun, and what is
    in work is taken as it comes. stop: also for the workers to look at; set while an error is
    raised here, a worker's or one of take's.
    """
    waiting: queue.SimpleQueue = queue.SimpleQueue()
    for item in items:
        waiting.put(item)
    threads = min(threads, waiting.qsize())
    turns = Turns(threads)
    finished: queue.SimpleQueue = queue.SimpleQueue()
    workers = [
        threading.Thread(target=_work, args=(waiting, work, finished, stop, turns), daemon=True)
        for _ in range(threads)
    ]
    for k, worker in enumerate(workers):
        worker.name = f"iwis-{k}"
        worker.start()
    done = False
    try:
        was_cancelled = _collect(len(workers), finished, take, cancelled, stop)
        done = True
    finally:
        if not done:
            stop.set()
        for worker in workers:
            worker.join()
    return was_cancelled


def _work(waiting, work, finished, stop, turns) -> None:
    try:
        while not stop.is_set():
            item = waiting.get_nowait()
            with turns.taken():
                result = work(item)
            finished.put(result)
    except queue.Empty:
        pass
    except BaseException as error:  # raised again in the caller's thread
        finished.put(error)
    finally:
        finished.put(_ENDED)


def _collect(working: int, finished, take, cancelled, stop) -> bool:
    was_cancelled = False
    while working:
        if not was_cancelled and cancelled():
            was_cancelled = True
            stop.set()
        try:
            result = finished.get(timeout=_POLL_SECONDS)
        except queue.Empty:
            continue
        if result is _ENDED:
            working -= 1
        elif isinstance(result, BaseException):
            raise result
        else:
            take(result)
    return was_cancelled
