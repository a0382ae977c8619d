"""Perlin's noise in one to four dimensions, as Blender has it: kernels of core/nodes/noise.py.

In NumPy a point in space took .25 microseconds, and a rock of 24 octaves, bump and all, more than
its light: here it takes .005. numba widens 32-bit numbers at each step, so each is cut off.
"""

from __future__ import annotations

import numpy as np

from .._jit import kernel

_ZERO, _ONE, _TWO = np.float32(0.0), np.float32(1.0), np.float32(2.0)
_SIX, _TEN, _FIFTEEN = np.float32(6.0), np.float32(10.0), np.float32(15.0)
_UNIT = np.float32(1.0 / 0xFFFFFFFF)
# Of the noise in d dimensions, so that it keeps to -1 ... 1.
_SCALE_1, _SCALE_2 = np.float32(0.25), np.float32(0.6616)
_SCALE_3, _SCALE_4 = np.float32(0.9820), np.float32(0.8344)
_START = 0xDEADBEEF + 13  # of Jenkins' lookup3, and 4 for each word
START_1, START_2 = np.uint32(_START + 4), np.uint32(_START + 8)
_START_3, _START_4 = np.uint32(_START + 12), np.uint32(_START + 16)


@kernel(forceinline=True)
def _turned(x, k):
    u = np.uint32
    return u(u(x << u(k)) | u(x >> u(32 - k)))


@kernel(forceinline=True)
def hash_final(a, b, c):
    """The last step of Jenkins' lookup3, of three words: uint32."""
    u = np.uint32
    c = u(u(c ^ b) - _turned(b, 14))
    a = u(u(a ^ c) - _turned(c, 11))
    b = u(u(b ^ a) - _turned(a, 25))
    c = u(u(c ^ b) - _turned(b, 16))
    a = u(u(a ^ c) - _turned(c, 4))
    b = u(u(b ^ a) - _turned(a, 14))
    return u(u(c ^ b) - _turned(b, 24))


@kernel(forceinline=True)
def _mixed(a, b, c):
    u = np.uint32
    a = u(u(a - c) ^ _turned(c, 4))
    c = u(c + b)
    b = u(u(b - a) ^ _turned(a, 6))
    a = u(a + c)
    c = u(u(c - b) ^ _turned(b, 8))
    b = u(b + a)
    a = u(u(a - c) ^ _turned(c, 16))
    c = u(c + b)
    b = u(u(b - a) ^ _turned(a, 19))
    a = u(a + c)
    c = u(u(c - b) ^ _turned(b, 4))
    return a, u(b + a), c


@kernel(forceinline=True)
def _word(x):
    return np.float32(x).view(np.uint32)


@kernel(forceinline=True)
def number_of_2(x, y):
    """A number in 0 ... 1 of two, by their bits in float32."""
    u = np.uint32
    word = hash_final(u(START_2 + _word(x)), u(START_2 + _word(y)), START_2)
    return np.float32(word) * _UNIT


@kernel(forceinline=True)
def number_of_3(x, y, z):
    """The same of three."""
    u = np.uint32
    a, b, c = u(_START_3 + _word(x)), u(_START_3 + _word(y)), u(_START_3 + _word(z))
    return np.float32(hash_final(a, b, c)) * _UNIT


@kernel(forceinline=True)
def number_of_4(x, y, z, w):
    """The same of four."""
    u = np.uint32
    a, b, c = u(_START_4 + _word(x)), u(_START_4 + _word(y)), u(_START_4 + _word(z))
    a, b, c = _mixed(a, b, c)
    return np.float32(hash_final(u(a + _word(w)), b, c)) * _UNIT


@kernel(forceinline=True)
def _signed(value, bit):
    return -value if bit != np.uint32(0) else value


@kernel(forceinline=True)
def _fade(t):
    return t * t * t * (t * (t * _SIX - _FIFTEEN) + _TEN)


@kernel(forceinline=True)
def _mix(a, b, t):
    return a + (b - a) * t


@kernel(forceinline=True)
def _cell(x):
    """(whole part as a word, the rest) of a number below 2^31."""
    whole = np.floor(x)
    return np.uint32(np.int32(whole)), x - whole


@kernel(forceinline=True)
def _corner_1(i, x):
    u = np.uint32
    h = hash_final(u(START_1 + i), START_1, START_1)
    return _signed(_ONE + np.float32(np.int32(h & u(7))), h & u(8)) * x


@kernel(forceinline=True)
def _corner_2(i, j, x, y):
    u = np.uint32
    h = hash_final(u(START_2 + i), u(START_2 + j), START_2)
    near = (h & u(7)) < u(4)
    return _signed(x if near else y, h & u(1)) + _signed(_TWO * (y if near else x), h & u(2))


@kernel(forceinline=True)
def _corner_3(i, j, k, x, y, z):
    u = np.uint32
    h = u(hash_final(u(_START_3 + i), u(_START_3 + j), u(_START_3 + k)) & u(15))
    a = x if h < u(8) else y
    other = x if (h == u(12)) | (h == u(14)) else z
    b = y if h < u(4) else other
    return _signed(a, h & u(1)) + _signed(b, h & u(2))


@kernel(forceinline=True)
def _corner_4(i, j, k, m, x, y, z, w):
    u = np.uint32
    a, b, c = _mixed(u(_START_4 + i), u(_START_4 + j), u(_START_4 + k))
    h = u(hash_final(u(a + m), b, c) & u(31))
    p = x if h < u(24) else y
    q = y if h < u(16) else z
    r = z if h < u(8) else w
    return _signed(p, h & u(1)) + _signed(q, h & u(2)) + _signed(r, h & u(4))


@kernel(forceinline=True)
def _edge_3(i, j, k, x, y, z, t):
    """Between the corners of an edge along x."""
    low = _corner_3(i, j, k, x, y, z)
    return _mix(low, _corner_3(np.uint32(i + np.uint32(1)), j, k, x - _ONE, y, z), t)


@kernel(forceinline=True)
def _edge_4(i, j, k, m, x, y, z, w, t):
    low = _corner_4(i, j, k, m, x, y, z, w)
    return _mix(low, _corner_4(np.uint32(i + np.uint32(1)), j, k, m, x - _ONE, y, z, w), t)


@kernel(forceinline=True)
def _cube_4(i, j, k, m, x, y, z, w, fx, fy, fz):
    j1, k1 = np.uint32(j + np.uint32(1)), np.uint32(k + np.uint32(1))
    y1, z1 = y - _ONE, z - _ONE
    near = _mix(_edge_4(i, j, k, m, x, y, z, w, fx), _edge_4(i, j1, k, m, x, y1, z, w, fx), fy)
    far = _mix(_edge_4(i, j, k1, m, x, y, z1, w, fx), _edge_4(i, j1, k1, m, x, y1, z1, w, fx), fy)
    return _mix(near, far, fz)


@kernel
def perlin_1d(p, out):
    """Write signed noise, float32 (n,), of p, float32 (1, n), below 2^31. So the others."""
    for n in range(len(out)):
        i, x = _cell(p[0, n])
        far = _corner_1(np.uint32(i + np.uint32(1)), x - _ONE)
        out[n] = _SCALE_1 * _mix(_corner_1(i, x), far, _fade(x))


@kernel
def perlin_2d(p, out):
    """See perlin_1d."""
    for n in range(len(out)):
        i, x = _cell(p[0, n])
        j, y = _cell(p[1, n])
        i1, j1 = np.uint32(i + np.uint32(1)), np.uint32(j + np.uint32(1))
        fx, x1, y1 = _fade(x), x - _ONE, y - _ONE
        low = _mix(_corner_2(i, j, x, y), _corner_2(i1, j, x1, y), fx)
        high = _mix(_corner_2(i, j1, x, y1), _corner_2(i1, j1, x1, y1), fx)
        out[n] = _SCALE_2 * _mix(low, high, _fade(y))


@kernel
def perlin_3d(p, out):
    """See perlin_1d."""
    for n in range(len(out)):
        i, x = _cell(p[0, n])
        j, y = _cell(p[1, n])
        k, z = _cell(p[2, n])
        j1, k1 = np.uint32(j + np.uint32(1)), np.uint32(k + np.uint32(1))
        fx, fy, y1, z1 = _fade(x), _fade(y), y - _ONE, z - _ONE
        near = _mix(_edge_3(i, j, k, x, y, z, fx), _edge_3(i, j1, k, x, y1, z, fx), fy)
        far = _mix(_edge_3(i, j, k1, x, y, z1, fx), _edge_3(i, j1, k1, x, y1, z1, fx), fy)
        out[n] = _SCALE_3 * _mix(near, far, _fade(z))


@kernel
def perlin_4d(p, out):
    """See perlin_1d."""
    for n in range(len(out)):
        i, x = _cell(p[0, n])
        j, y = _cell(p[1, n])
        k, z = _cell(p[2, n])
        m, w = _cell(p[3, n])
        fx, fy, fz = _fade(x), _fade(y), _fade(z)
        near = _cube_4(i, j, k, m, x, y, z, w, fx, fy, fz)
        far = _cube_4(i, j, k, np.uint32(m + np.uint32(1)), x, y, z, w - _ONE, fx, fy, fz)
        out[n] = _SCALE_4 * _mix(near, far, _fade(w))


@kernel
def all_within(p, limit):
    """Whether all numbers of p, float32 (d, n), are numbers, and nearer to 0 than a limit."""
    beyond = 0
    for a in range(p.shape[0]):
        for n in range(p.shape[1]):
            beyond += not abs(p[a, n]) < limit
    return beyond == 0


PERLIN = (perlin_1d, perlin_2d, perlin_3d, perlin_4d)
