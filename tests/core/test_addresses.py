"""core/machine/addresses.py: a function by its address is handed what numba's kernels have."""

from typing import NamedTuple

import numba
import numpy as np
import pytest

from iwis.core import _jit
from iwis.core.machine.addresses import handing_on


class Given(NamedTuple):
    """Arrays and numbers, some of them a level deeper."""

    first: np.ndarray
    count: int
    factor: np.float32
    inner: tuple


def _given(rng):
    inner = rng.random((3, 2)).astype(np.float32), True
    return Given(rng.random(5), 5, np.float32(0.5), inner)


_KIND = numba.typeof(_given(np.random.default_rng(1)))
_hand, _given_at = handing_on(_KIND)


@_jit.kernel
def _double(given):
    for k in range(given.count):
        given.first[k] *= 2.0
    if given.inner[1]:
        given.inner[0][2, 1] = given.factor


@_jit.c_callback(numba.types.void(numba.types.intp), counts_references=False)
def _double_at(place):
    _double(_given_at(place))


@_jit.kernel
def _hand_on(function, given, times):
    for _ in range(times):
        _hand(function, given)


@pytest.mark.parametrize("times", [1, 3])
def test_what_is_handed_on_arrives(rng, times):
    """Arrays are the caller's own, not copies of them."""
    given = _given(rng)
    expected = given.first * 2.0**times
    _hand_on(_double_at.address, given, times)
    np.testing.assert_array_equal(given.first, expected)
    assert given.inner[0][2, 1] == np.float32(0.5)
    assert numba.typeof(given) == _KIND


def test_no_references_are_counted():
    """A block would count those of a hundred arrays."""
    assert "NRT_incref" not in _double_at.inspect_llvm()


def test_other_values_are_refused_when_the_kernel_is_compiled(rng):
    """What is read would be what happens to lie there."""
    given = _given(rng)._replace(first=np.zeros(5, np.float32))
    with pytest.raises(numba.TypingError, match="in place of"):
        _hand_on(_double_at.address, given, 1)
