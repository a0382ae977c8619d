"""Halton points, and the shift that gives each pixel its own.

[Huang07, section 3.2] asks for points that stay the same when more are added: sample k of a pixel
is radical_inverse(k + 1) in bases 2 and 3, moved on the torus by a hash of pixel and seed
(Cranley-Patterson); with no shift all pixels share the same points, as the paper is literally read.
"""

import numpy as np

from .._jit import kernel

_UNIT = 1.0 / 4294967296.0


@kernel
def radical_inverse_2(index):
    """float64 in [0, 1): the binary digits of index (< 2^32), mirrored."""
    # numba widens uint32 arithmetic to 64 bits: mask, or high bits stay in.
    bits = np.uint64(index)
    bits = ((bits << 16) | (bits >> 16)) & 0xFFFFFFFF
    bits = ((bits & 0x00FF00FF) << 8) | ((bits & 0xFF00FF00) >> 8)
    bits = ((bits & 0x0F0F0F0F) << 4) | ((bits & 0xF0F0F0F0) >> 4)
    bits = ((bits & 0x33333333) << 2) | ((bits & 0xCCCCCCCC) >> 2)
    bits = ((bits & 0x55555555) << 1) | ((bits & 0xAAAAAAAA) >> 1)
    return np.float64(bits) * _UNIT


@kernel
def radical_inverse_3(index):
    """float64 in [0, 1): the ternary digits of index, mirrored."""
    inverse, scale = 0.0, 1.0
    while index > 0:
        scale /= 3.0
        inverse += scale * (index % 3)
        index //= 3
    return inverse


@kernel
def hash_pixel(x, y, seed, salt):
    """float64 in [0, 1), one number for each pixel, seed and salt (rounds of PCG's output mix)."""
    mask = np.uint64(0xFFFFFFFF)
    state = np.uint64(x) * np.uint64(0x9E3779B1) ^ np.uint64(y) * np.uint64(0x85EBCA77)
    state ^= np.uint64(seed) * np.uint64(0xC2B2AE3D) ^ np.uint64(salt) * np.uint64(0x27D4EB2F)
    state &= mask
    for _ in range(2):
        state = (state * np.uint64(747796405) + np.uint64(2891336453)) & mask
        shift = (state >> np.uint64(28)) + np.uint64(4)
        state = (((state >> shift) ^ state) * np.uint64(277803737)) & mask
        state = (state >> np.uint64(22)) ^ state
    return np.float64(state) * _UNIT


@kernel
def halton_table(count, out):
    """Write the first ``count`` points, index 1 first (0 is the origin): float64 (count, 2)."""
    for k in range(count):
        out[k, 0] = radical_inverse_2(k + 1)
        out[k, 1] = radical_inverse_3(k + 1)
