"""What numba does over and over while it compiles, done once or by fewer steps, for that time.

Each answers as numba's own: the types of an operation on plain numbers are looked up among dozens
of candidates for every ``+`` that is written, the variables of each instruction are gathered a
dozen times by one type test after another, and Python looks for garbage among millions of small
objects. A sixth of the time together (docs/decisions/0021-first-compilation.md).
"""

from __future__ import annotations

import gc
from contextlib import contextmanager

from numba.core import ir, types

# Python's garbage is looked for after so many new objects: a tenth of the time goes where it is
# after every few thousand.
_RARELY = 100_000
_PLAIN = (types.Integer, types.Float, types.Boolean)  # no written values, which are other classes

_asked_of_numba = types.BaseFunction.get_call_type
# id of a function's type -> the type, which keeps the id its own, and {arguments: signature}
_signatures: dict[int, tuple[types.BaseFunction, dict]] = {}


@contextmanager
def quicker():
    """While a kernel is compiled, by who holds numba's lock; all is as before at the end."""
    thresholds = gc.get_threshold()
    before = types.BaseFunction.get_call_type, ir.Inst._rec_list_vars
    if thresholds[0]:
        gc.set_threshold(max(thresholds[0], _RARELY), *thresholds[1:])
    types.BaseFunction.get_call_type, ir.Inst._rec_list_vars = _call_type, _variables_in
    try:
        yield
    finally:
        types.BaseFunction.get_call_type, ir.Inst._rec_list_vars = before
        gc.set_threshold(*thresholds)


def _call_type(self, context, args, kws):
    """BaseFunction.get_call_type, which finds the same for plain numbers each time."""
    if kws or not all(type(kind) in _PLAIN for kind in args):
        return _asked_of_numba(self, context, args, kws)
    known = _signatures.setdefault(id(self), (self, {}))[1]
    if args not in known:
        known[args] = _asked_of_numba(self, context, args, kws)
    return known[args]


def _variables_in(self, value) -> list:
    """Inst._rec_list_vars: of values nested as deep as they are."""
    kind = type(value)
    if kind is ir.Var:
        return [value]
    if kind is dict:
        value = value.values()
    elif kind is not list and kind is not tuple:
        return value.list_vars() if isinstance(value, ir.Inst) else []
    found = []
    for part in value:
        if type(part) is ir.Var:
            found.append(part)
        elif type(part) is not str:
            found += _variables_in(self, part)
    return found
