"""Fetch memory ahead of its use: what many samples read, each somewhere else in a large table.

A loop that only asks for cache lines waits for none of them; the loop after it finds them there.
"""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .._jit import kernel

_READ, _KEEP, _DATA = 0, 3, 1  # LLVM's llvm.prefetch: for reading, in all caches, no code


@intrinsic
def _fetch(typing_context, place):
    """Ask for the cache line at an address; any address will do, as nothing is read."""

    def generate(context, builder, signature, arguments):
        pointer, word = ir.IntType(8).as_pointer(), ir.IntType(32)
        declared = ir.FunctionType(ir.VoidType(), [pointer, word, word, word])
        function = cgutils.get_or_insert_function(builder.module, declared, "llvm.prefetch.p0")
        how = [word(number) for number in (_READ, _KEEP, _DATA)]
        builder.call(function, [builder.inttoptr(arguments[0], pointer), *how])
        return context.get_dummy_value()

    return types.void(types.intp), generate


@kernel(forceinline=True)
def fetch(array, offset):
    """Ask for the cache line that holds the byte at an offset of an array in one piece."""
    _fetch(array.ctypes.data + offset)
