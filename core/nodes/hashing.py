"""Blender's hashes of numbers, in unsigned 32-bit arithmetic: Jenkins' lookup3 and PCG."""

from __future__ import annotations

import numpy as np

_START = 0xDEADBEEF + 13


def _rotated(x, k):
    return (x << np.uint32(k)) | (x >> np.uint32(32 - k))


def _mixed(a, b, c):
    a = (a - c) ^ _rotated(c, 4)
    c = c + b
    b = (b - a) ^ _rotated(a, 6)
    a = a + c
    c = (c - b) ^ _rotated(b, 8)
    b = b + a
    a = (a - c) ^ _rotated(c, 16)
    c = c + b
    b = (b - a) ^ _rotated(a, 19)
    a = a + c
    c = (c - b) ^ _rotated(b, 4)
    return a, b + a, c


def _final(a, b, c):
    c = (c ^ b) - _rotated(b, 14)
    a = (a ^ c) - _rotated(c, 11)
    b = (b ^ a) - _rotated(a, 25)
    c = (c ^ b) - _rotated(b, 16)
    a = (a ^ c) - _rotated(c, 4)
    b = (b ^ a) - _rotated(a, 14)
    return (c ^ b) - _rotated(b, 24)


def hash_words(*words) -> np.ndarray:
    """uint32 (n,) of one to four arrays of uint32."""
    start = np.uint32((_START + (len(words) << 2)) & 0xFFFFFFFF)
    state = [np.full_like(words[0], start) for _ in range(3)]
    with np.errstate(over="ignore"):
        for k, word in enumerate(words[:3]):
            state[k] = state[k] + word
        if len(words) == 4:
            state = list(_mixed(*state))
            state[0] = state[0] + words[3]
        return _final(*state)


def _bits(number):
    return np.ascontiguousarray(number, np.float32).view(np.uint32)


def hash_numbers(*numbers) -> np.ndarray:
    """float32 (n,) in [0, 1] of one to four arrays of float32, by their bits."""
    words = [_bits(a) for a in np.broadcast_arrays(*numbers)]
    return hash_words(*words).astype(np.float32) * np.float32(1.0 / 0xFFFFFFFF)


def hash_to_color(p) -> np.ndarray:
    """Three numbers (n, 3) of p, float32 (d, n), d = 1 ... 4."""
    if len(p) == 4:
        x, y, z, w = p
        turns = ((x, y, z, w), (z, x, w, y), (w, z, y, x))
        return np.stack([hash_numbers(*turn) for turn in turns], -1)
    more = [hash_numbers(*p, np.full_like(p[0], k)) for k in (1.0, 2.0)]
    return np.stack([hash_numbers(*p), *more], -1)
