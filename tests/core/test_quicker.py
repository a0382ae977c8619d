"""core/_quicker.py: numba's own answers, sooner, and only while a kernel is compiled."""

import gc
import itertools
import operator

import numba
import numpy as np
import pytest
from numba.core import ir, types

from iwis.core._quicker import _call_type, _variables_in, quicker

_KINDS = [
    types.boolean,
    types.int8,
    types.int64,
    types.uint32,
    types.uint64,
    types.float32,
    types.float64,
]
_context = numba.core.registry.cpu_target.typing_context


@pytest.fixture(autouse=True)
def _known():
    _context.refresh()


def _function(name):
    return _context.resolve_value_type(name)


@pytest.mark.parametrize("written", [operator.add, operator.truediv, operator.lt, min, np.sqrt])
def test_operations_on_numbers_have_numbas_types(written):
    """Asked the first time and the second, and the function finds its code by them."""
    function = _function(written)
    count = 1 if written is np.sqrt else 2
    for given in itertools.product(_KINDS, repeat=count):
        expected = types.BaseFunction.get_call_type(function, _context, given, {})
        for _ in range(2):
            found = _call_type(function, _context, given, {})
            assert found == expected
            assert function.get_impl_key(found) == function.get_impl_key(expected)


def test_what_does_not_fit_is_refused_each_time():
    function = _function(operator.lshift)
    for _ in range(2):
        with pytest.raises(numba.TypingError):
            _call_type(function, _context, (types.float32, types.float32), {})


def test_all_other_arguments_are_numbas_to_judge():
    """Written numbers, arrays, and arguments by name."""
    add, array = _function(operator.add), types.float32[::1]
    for given in [(types.literal(2), types.int64), (array, types.float32), (array, array)]:
        expected = types.BaseFunction.get_call_type(add, _context, given, {})
        assert _call_type(add, _context, given, {}) == expected


def test_variables_are_found_however_deep():
    place, scope = ir.unknown_loc, ir.Scope(None, ir.unknown_loc)
    a, b, c = (ir.Var(scope, name, place) for name in "abc")
    call = ir.Expr.call(a, [b], (("key", c),), place)
    values = [a, [b, (c, "text", 1, None)], {"x": a, "y": [b]}, call, "a", (), {"z": call}]
    for value in values:
        assert _variables_in(call, value) == ir.Inst._rec_list_vars(call, value), value
    assert sorted(found.name for found in _variables_in(call, values)) == sorted("abcababcabc")


def test_all_is_as_before_at_the_end():
    """After an error, too, and after one compilation within another."""

    def state():
        own = types.BaseFunction.get_call_type, ir.Inst._rec_list_vars
        return (*own, gc.get_threshold())

    before = state()
    with pytest.raises(ZeroDivisionError), quicker():
        changed = state()
        with quicker():
            assert state() == changed
        assert state() == changed
        raise ZeroDivisionError
    assert state() == before
    assert all(was != then for was, then in zip(before, changed, strict=True))
