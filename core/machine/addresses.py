"""Memory and functions by their addresses, from within kernels: what foreign code is handed."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic

_ALIGNMENT = 64  # bytes; Embree asks for 32 under a packet of 8


@intrinsic
def call(typing_context, function, words):
    """Call the C function at an address, void f(size_t, ...), with a tuple of words."""

    def generate(context, builder, signature, arguments):
        given = cgutils.unpack_tuple(builder, arguments[1])
        declared = ir.FunctionType(ir.VoidType(), [word.type for word in given])
        builder.call(builder.inttoptr(arguments[0], declared.as_pointer()), given)
        return context.get_dummy_value()

    return types.void(types.intp, types.UniTuple(types.intp, len(words))), generate


def handing_on(numba_type):
    """Two functions for kernels, by which one of them gives another a value of a type.

    call_with(function, value): call void f(intptr_t) at an address; value_at(place): what f reads
    """

    @intrinsic
    def call_with(typing_context, function, value):
        if types.unliteral(value) != numba_type:
            raise TypingError(f"{value} is handed on in place of {numba_type}")

        def generate(context, builder, signature, arguments):
            word = context.get_value_type(types.intp)
            with builder.goto_entry_block():
                place = builder.alloca(arguments[1].type)
            builder.store(arguments[1], place)
            declared = ir.FunctionType(ir.VoidType(), [word])
            function = builder.inttoptr(arguments[0], declared.as_pointer())
            builder.call(function, [builder.ptrtoint(place, word)])
            return context.get_dummy_value()

        return types.void(types.intp, numba_type), generate

    @intrinsic
    def value_at(typing_context, place):
        def generate(context, builder, signature, arguments):
            kind = context.get_value_type(numba_type)
            return builder.load(builder.inttoptr(arguments[0], kind.as_pointer()))

        return numba_type(types.intp), generate

    return call_with, value_at


@intrinsic(prefer_literal=True)
def stack(typing_context, n_floats):
    """The address of a constant number of floats on the stack, aligned for Embree."""
    count = n_floats.literal_value

    def generate(context, builder, signature, arguments):
        with builder.goto_entry_block():
            place = builder.alloca(ir.ArrayType(ir.FloatType(), count))
            place.align = _ALIGNMENT
        return builder.ptrtoint(place, context.get_value_type(types.intp))

    return types.intp(n_floats), generate


@intrinsic
def put(typing_context, place, value):
    """Write a float32 or uint32 to an address."""

    def generate(context, builder, signature, arguments):
        pointer = builder.inttoptr(arguments[0], arguments[1].type.as_pointer())
        builder.store(arguments[1], pointer, align=4)
        return context.get_dummy_value()

    return types.void(types.intp, value), generate


def _reader(numba_type):
    @intrinsic
    def read(typing_context, place):
        """Read a number from an address."""

        def generate(context, builder, signature, arguments):
            word, least = context.get_value_type(numba_type), min(numba_type.bitwidth // 8, 4)
            return builder.load(builder.inttoptr(arguments[0], word.as_pointer()), align=least)

        return numba_type(types.intp), generate

    return read


get_float, get_int = _reader(types.float32), _reader(types.int32)
get_word, get_byte = _reader(types.intp), _reader(types.uint8)
