"""Blender's random numbers of the cells of a grid, in one to four dimensions: kernels.

PCG in 32-bit arithmetic, each step cut off as numba widens it; on the line, and everywhere before
Blender 5, Jenkins' lookup3. A cell is four whole numbers, float32, 0 beyond the dimensions d that
there are. Which hash it is, is the length of a tuple: known to the compiler, so that loops over
points stay free of branches.
"""

from __future__ import annotations

import numpy as np

from .._jit import kernel
from .perlin import START_1, START_2, hash_final, number_of_2, number_of_3, number_of_4

_FACTOR, _SUMMAND = np.int32(1664525), np.int32(1013904223)
_UNIT, _LINE_UNIT = np.float32(1.0 / 0x7FFFFFFF), np.float32(1.0 / 0xFFFFFFFF)
_BITS_OF_1, _BITS_OF_2 = np.float32([1.0, 2.0]).view(np.uint32)
_ZERO, _ONE, _TWO = np.float32(0.0), np.float32(1.0), np.float32(2.0)


@kernel(forceinline=True)
def _unit(v):
    return np.float32(v & np.int32(0x7FFFFFFF)) * _UNIT


@kernel(forceinline=True)
def _add_product(a, b, c):
    return np.int32(a + np.int32(b * c))


@kernel(forceinline=True)
def _begun(v):
    return np.int32(np.int32(v * _FACTOR) + _SUMMAND)


@kernel(forceinline=True)
def _folded(v):
    return np.int32(v ^ (v >> np.int32(16)))


@kernel(forceinline=True)
def _flat_numbers(i, j):
    """Two numbers in 0 ... 1 of a cell of the plane."""
    x, y = _begun(i), _begun(j)
    x = _add_product(x, y, _FACTOR)
    y = _add_product(y, x, _FACTOR)
    x, y = _folded(x), _folded(y)
    x = _add_product(x, y, _FACTOR)
    y = _add_product(y, x, _FACTOR)
    return _unit(x), _unit(y)


@kernel(forceinline=True)
def _turn_3(x, y, z):
    x = _add_product(x, y, z)
    y = _add_product(y, z, x)
    return x, y, _add_product(z, x, y)


@kernel(forceinline=True)
def _turn_4(x, y, z, w):
    x = _add_product(x, y, w)
    y = _add_product(y, z, x)
    z = _add_product(z, x, y)
    return x, y, z, _add_product(w, y, z)


@kernel(forceinline=True)
def line_number(i):
    """A number in 0 ... 1 of a cell of the line."""
    bits = np.float32(i).view(np.uint32)
    return np.float32(hash_final(np.uint32(START_1 + bits), START_1, START_1)) * _LINE_UNIT


@kernel(forceinline=True)
def _more_of_line(i, word):
    bits = np.float32(i).view(np.uint32)
    first, second = np.uint32(START_2 + bits), np.uint32(START_2 + word)
    return np.float32(hash_final(first, second, START_2)) * _LINE_UNIT


@kernel(forceinline=True)
def _numbers_before(d, cell):
    """cell_numbers of before Blender 5."""
    x, y, z, w = cell
    if d == 2:
        return number_of_2(x, y), number_of_3(x, y, _ONE), number_of_3(x, y, _TWO), _ZERO
    if d == 3:
        return number_of_3(x, y, z), number_of_4(x, y, z, _ONE), number_of_4(x, y, z, _TWO), _ZERO
    return number_of_4(x, y, z, w), number_of_4(z, x, w, y), number_of_4(w, z, y, x), _ZERO


@kernel(forceinline=True)
def _point_before(d, cell):
    """Four numbers: cell_point of before Blender 5, of randomness 1."""
    x, y, z, w = cell
    if d == 2:
        return number_of_2(x, y), number_of_3(x, y, _ONE), _ZERO, _ZERO
    if d == 3:
        return _numbers_before(d, cell)
    first, second = number_of_4(x, y, z, w), number_of_4(w, x, y, z)
    return first, second, number_of_4(z, w, x, y), number_of_4(y, z, w, x)


@kernel(forceinline=True)
def cell_numbers(d, cell, before):
    """Four numbers in 0 ... 1 of a cell. before: (), or (0,) for those of before Blender 5"""
    if len(before) > 0 and d > 1:
        return _numbers_before(d, cell)
    i, j, k, m = np.int32(cell[0]), np.int32(cell[1]), np.int32(cell[2]), np.int32(cell[3])
    if d == 1:
        return line_number(i), _more_of_line(i, _BITS_OF_1), _more_of_line(i, _BITS_OF_2), _ZERO
    if d < 4:
        x, y, z = _turn_3(_begun(i), _begun(j), _begun(k))
        x, y, z = _turn_3(_folded(x), _folded(y), _folded(z))
        return _unit(x), _unit(y), _unit(z), _ZERO
    x, y, z, w = _turn_4(_begun(i), _begun(j), _begun(k), _begun(m))
    x, y, z, w = _turn_4(_folded(x), _folded(y), _folded(z), _folded(w))
    return _unit(x), _unit(y), _unit(z), _unit(w)


@kernel(forceinline=True)
def cell_point(d, cell, randomness, before):
    """The point of a cell, from its corner; four numbers. before: as of cell_numbers"""
    if d == 1:
        return line_number(np.int32(cell[0])) * randomness, _ZERO, _ZERO, _ZERO
    if len(before) > 0:
        x, y, z, w = _point_before(d, cell)
        return x * randomness, y * randomness, z * randomness, w * randomness
    if d == 2:
        x, y = _flat_numbers(np.int32(cell[0]), np.int32(cell[1]))
        return x * randomness, y * randomness, _ZERO, _ZERO
    x, y, z, w = cell_numbers(d, cell, before)
    return x * randomness, y * randomness, z * randomness, w * randomness
