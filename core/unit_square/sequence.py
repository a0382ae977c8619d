"""The low-discrepancy points of each pixel, as 32-bit fractions of the unit square.

OWEN: the first two dimensions of Sobol's sequence, scrambled anew for each pixel by a hash that
flips every digit by those before it [Owen95, Laine11, Burley20]. PIXEL and NONE: Halton's points
with and without a shift on the torus [Huang07, section 3.2]. All stay the same when more are added
(docs/decisions/0012-scrambled-sobol.md).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from .halton import halton_table, hash_pixel

_UNIT = 1.0 / 4294967296.0
_BITS = 4294967296.0
_GOLDEN = 0.6180339887498949


class PixelSequence(NamedTuple):
    """The points of n shading points' pixels.

    points: uint32 (count, 2), common to all; bits in reverse order where they are scrambled
    x, y: uint32 (n,), the shift or the scramble of each
    scrambled: whether x, y are seeds of an Owen scramble, else they are added
    """

    points: np.ndarray
    x: np.ndarray
    y: np.ndarray
    scrambled: bool


def common_points(count: int, decorrelation: str) -> np.ndarray:
    """PixelSequence.points of one of settings.DECORRELATIONS."""
    if decorrelation == "OWEN":
        return sobol_points(count)
    table = np.empty((count, 2))
    halton_table(count, table)
    return to_bits(table)


def to_bits(points: np.ndarray) -> np.ndarray:
    """uint32 of numbers in [0, 1)."""
    return (points * _BITS).astype(np.uint32)


def sobol_points(count: int) -> np.ndarray:
    """uint32 (count, 2): Sobol's first two dimensions, bits in reverse order [Sobol67].

    Reversed, the first is the index itself; the generator matrix of the second is Pascal's triangle
    modulo 2: bit j of the reversed number is the parity of the index's bits i >= j where j is a
    subset of i.
    """
    index = np.arange(count, dtype=np.uint32)
    second = np.zeros(count, np.uint32)
    column = np.uint32(1)  # reversed: 1, 11, 101, 1111 ... in binary
    for bit in range(max(int(count - 1).bit_length(), 1)):
        second ^= np.where((index >> np.uint32(bit)) & np.uint32(1), column, np.uint32(0))
        column ^= np.uint32((int(column) << 1) & 0xFFFFFFFF)
    return np.stack([index, second], -1)


@kernel
def _fill_hashes(pixel, width, x0, y0, seed, x, y):
    for k in range(len(pixel)):
        column, row = x0 + pixel[k] % width, y0 + pixel[k] // width
        x[k] = np.uint32(hash_pixel(column, row, seed, 1) * _BITS)
        y[k] = np.uint32(hash_pixel(column, row, seed, 2) * _BITS)


def pixel_sequence(
    points: np.ndarray, pixel: np.ndarray, tile, seed: int, decorrelation: str
) -> PixelSequence:
    """Each shading point's own sequence, from its pixel's place in the frame and the seed.

    points: of common_points; pixel: int32 (n,), in the tile; tile: (x, y, width) of it in the frame
    """
    x, y = np.zeros(len(pixel), np.uint32), np.zeros(len(pixel), np.uint32)
    if decorrelation != "NONE":
        x0, y0, width = tile
        _fill_hashes(pixel, width, x0, y0, seed, x, y)
    return PixelSequence(points, x, y, decorrelation == "OWEN")


@kernel(forceinline=True)
def scramble(bits, seed):
    """Owen's scramble of a number whose bits are in reverse order; returns them in order, uint32.

    A hash in which each bit depends only on lower ones, with the constants of [Vegdahl21].
    numba widens uint32 arithmetic to 64 bits: every step is cut off, which vectors need.
    """
    u = np.uint32
    x = u(bits ^ u(bits * u(0x3D20ADEA)))
    x = u(x + seed)
    x = u(x * u((seed >> u(16)) | u(1)))
    x = u(x ^ u(x * u(0x05526C56)))
    x = u(x ^ u(x * u(0x53A22864)))
    x = u(u(x << u(16)) | u(x >> u(16)))
    x = u(u((x & u(0x00FF00FF)) << u(8)) | u((x >> u(8)) & u(0x00FF00FF)))
    x = u(u((x & u(0x0F0F0F0F)) << u(4)) | u((x >> u(4)) & u(0x0F0F0F0F)))
    x = u(u((x & u(0x33333333)) << u(2)) | u((x >> u(2)) & u(0x33333333)))
    return u(u((x & u(0x55555555)) << u(1)) | u((x >> u(1)) & u(0x55555555)))


@kernel(forceinline=True)
def sequence_point(sequence, p, k):
    """(x, y), float64 in [0, 1): sample k of shading point p."""
    x, y = sequence.points[k, 0], sequence.points[k, 1]
    if sequence.scrambled:
        x, y = scramble(x, sequence.x[p]), scramble(y, sequence.y[p])
    else:
        x, y = np.uint32(x + sequence.x[p]), np.uint32(y + sequence.y[p])
    return np.float64(x) * _UNIT, np.float64(y) * _UNIT


@kernel(forceinline=True)
def sample_number(sequence, p, k):
    """A number in [0, 1) of sample k of point p, apart from its point."""
    u = (np.float64(sequence.x[p]) + np.float64(sequence.y[p])) * _UNIT + k * _GOLDEN
    return u - np.floor(u)
