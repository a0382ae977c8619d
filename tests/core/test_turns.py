"""core/machine/turns.py: one of two threads at a time, but for what runs aside."""

import threading

import pytest

from iwis.core.machine.turns import Turns, aside


def _run(*works):
    """Run works in threads of their own, to their ends; raises if one hangs."""
    threads = [threading.Thread(target=work, daemon=True) for work in works]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10.0)
        assert not thread.is_alive(), "a thread waits for ever"


@pytest.mark.parametrize("threads, most", [(1, 1), (2, 1), (3, 1), (4, 2), (9, 4)])
def test_half_of_the_threads_have_turns(threads, most):
    """As many as that are in their turns together, and never more."""
    turns, lock, inside, seen = Turns(threads), threading.Lock(), [0], []
    full = threading.Event()

    def work():
        with turns.taken():
            with lock:
                inside[0] += 1
                seen.append(inside[0])
                if inside[0] == most:
                    full.set()
            assert full.wait(5.0)
            with lock:
                inside[0] -= 1

    _run(*[work] * (3 * most))
    assert full.is_set() and max(seen) == most


def test_what_runs_aside_lets_others_have_the_turn():
    """And has it again after that; aside of aside is nothing."""
    turns, order = Turns(2), []
    begun, done = threading.Event(), threading.Event()

    @aside()
    def long():
        begun.set()
        with aside():
            assert done.wait(5.0)

    def first():
        with turns.taken():
            long()
            order.append("first")

    def second():
        assert begun.wait(5.0)
        with turns.taken():
            order.append("second")
            done.set()

    _run(first, second)
    assert order == ["second", "first"]


def test_a_turn_is_given_back_by_an_error():
    """Within it and aside of it."""
    turns = Turns(1)
    with pytest.raises(ValueError, match="wrong"), turns.taken():
        raise ValueError("wrong")
    with pytest.raises(ValueError, match="wrong"), turns.taken(), aside():
        raise ValueError("wrong")

    def work():
        with turns.taken():
            pass

    _run(work)


def test_aside_of_no_turn_is_nothing():
    """Kernels are called by threads of no pool, too."""
    with aside():
        pass
