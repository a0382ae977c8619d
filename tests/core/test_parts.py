"""core/_parts.py: what a kernel calls is a part of it, compiled once, and computes what it says."""

import gc
import importlib
import pkgutil
from typing import NamedTuple

import numba
import numpy as np
import pytest

import iwis.core
from iwis.core import _jit
from iwis.core._parts import Kernel
from iwis.core.settings import PIXEL_FILTERS, STOP_RULES
from support.scenes import make_picture, varied_scene


class Pair(NamedTuple):
    """Two arrays, and a number beside them."""

    first: np.ndarray
    second: np.ndarray
    factor: float


@_jit.kernel
def _scaled(pair, k, power):
    value = pair.first[k] * pair.factor
    return value * value if power == 2 else value


@_jit.kernel(forceinline=True)
def _swapped(pair):
    return Pair(pair.second, pair.first, -pair.factor)


@_jit.kernel
def _walk(pair, turns, out):
    """Variables that hold tuples are written in loops and branches, and forgotten in between."""
    total = 0.0
    for k in range(len(out)):
        own = pair
        for turn in range(turns):
            if (turn + k) % 2 == 0:
                own = _swapped(own)
            else:
                other = Pair(own.first, own.second, 0.5 * own.factor)
                own = other
        out[k] = _scaled(own, k, 1) + _scaled(own, k, 2)
        total += own.second[k]
    return total


def _pair(rng):
    return Pair(rng.random(7), rng.random(7), 3.0)


def test_a_kernel_computes_what_its_text_says(rng):
    """The tuples of _walk, in machine code and in Python."""
    pair, out, expected = _pair(rng), np.zeros(7), np.zeros(7)
    for turns in range(4):
        total = _walk(pair, turns, out)
        assert total == pytest.approx(_walk.py_func(pair, turns, expected), rel=1e-12)
        np.testing.assert_allclose(out, expected, rtol=1e-12)


@_jit.kernel
def _part(x, power):
    return x**power


@_jit.kernel
def _whole(x):
    return _part(x, 2) + _part(x, 3)


def test_what_a_kernel_calls_is_no_machine_code_of_its_own():
    """A part has no entry for Python, and numbers that are written make no second one."""
    fresh = Kernel(_whole.py_func, {}, _whole.targetoptions, _whole._compiler.pipeline_class)
    assert fresh(2.0) == 12.0
    assert not _part.overloads and len(_part._part.overloads) == 1


def test_a_part_can_be_called_by_python_as_well():
    """It is compiled for that when it happens."""
    pair = Pair(np.array([2.0]), np.array([5.0]), 3.0)
    assert _scaled(pair, 0, 2) == 36.0 and _swapped(pair).first[0] == 5.0


@_jit.kernel
def _indexed(a, at, out):
    """Reads and writes by numbers with and without a sign, written ones, pairs, parts, slices."""
    k, n = at[1], np.uint32(at[0])
    out[0] = a[k, n] + a[2][k] + a[np.int32(1), 0]
    out[n + np.uint32(1)] = a[k][1:][0]
    row = a[k]
    row[0], a[k, 2] = 9.0, 7.0
    a[0, :] = 5.0
    out[np.int8(2)] = a[..., 1][k]
    return len(a[1:k])


def test_any_index_finds_its_place(rng):
    """As Python does, but for those that count from the end."""
    a, out = rng.random((4, 3)), np.zeros(3)
    expected_a, expected = a.copy(), out.copy()
    at = np.int32([0, 2])
    assert _indexed(a, at, out) == _indexed.py_func(expected_a, at, expected) == 1
    np.testing.assert_array_equal(a, expected_a)
    np.testing.assert_array_equal(out, expected)


@_jit.kernel
def _pick(a, k):
    return a[k]


@pytest.mark.skipif(bool(numba.config.BOUNDSCHECK), reason="bounds checks do ask for it")
def test_indices_are_not_asked_for_their_sign():
    """That costs more than the access, and keeps loops out of vector instructions."""
    fresh = Kernel(_pick.py_func, {}, _pick.targetoptions, _pick._compiler.pipeline_class)
    assert fresh(np.arange(3.0), 1) == 1.0
    assert "icmp slt" not in fresh.inspect_llvm(fresh.signatures[0])


def test_pythons_garbage_is_collected_as_before_a_kernel_was_compiled():
    """Rarely while numba is at work: a tenth of its time."""
    before = gc.get_threshold()

    @_jit.kernel
    def wrong(x):
        return x.nothing

    with pytest.raises(Exception, match="nothing"):
        wrong(1.0)
    assert gc.get_threshold() == before


def _loaded() -> dict[str, int]:
    """Kernels of the core that have machine code -> for how many signatures."""
    found = {}
    for module in pkgutil.walk_packages(iwis.core.__path__, "iwis.core."):
        for name, value in vars(importlib.import_module(module.name)).items():
            if isinstance(value, Kernel) and value.overloads:
                found[f"{value.py_func.__module__}.{name}"] = len(value.overloads)
    return found


@pytest.mark.slow
def test_a_changed_setting_compiles_no_kernel_again():
    """Of the kernels that the default picture took, none is wanted for other types."""
    make_picture(varied_scene(), max_samples=8)
    loaded = _loaded()
    assert "iwis.core.sampling.block_loop.continue_blocks" in loaded
    choices = [{"stop_rule": rule} for rule in STOP_RULES]
    choices += [{"pixel_filter": kind} for kind in PIXEL_FILTERS]
    choices += [{"decorrelation": "NONE"}, {"seed": 3}, {"batch_size": 1}, {"tile_px": 16}]
    choices += [{"error_threshold": 0.0}, {"stop_rule": "BUDGET", "time_limit": 0.01}]
    for choice in choices:
        make_picture(varied_scene(), **{"max_samples": 8} | choice)
        after = _loaded()
        assert {name: after[name] for name in loaded} == loaded, choice
