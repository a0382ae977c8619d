"""Small arithmetic on the values of nodes: numbers (n,) or (), vectors and colours (n, 3) or (3,).

All is float32: a Python float beside a float32 array keeps it so.
"""

from __future__ import annotations

import numpy as np

from ..data.channels import LUMINANCE as _REC709
from ..data.rows import row_means

LUMINANCE = _REC709.astype(np.float32)


def column(number) -> np.ndarray:
    """A number that multiplies vectors."""
    return np.asarray(number, np.float32)[..., None]


def vector(x, y, z) -> np.ndarray:
    """Three numbers as one vector."""
    return np.stack(np.broadcast_arrays(*(np.asarray(a, np.float32) for a in (x, y, z))), -1)


def parts(value) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The three numbers of a vector."""
    return value[..., 0], value[..., 1], value[..., 2]


def dot(a, b) -> np.ndarray:
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def length(a) -> np.ndarray:
    return np.sqrt(dot(a, a))


def normalized(a) -> np.ndarray:
    """Unit vectors; zero stays zero."""
    size = length(a)
    return a * np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)[..., None]


def divided(a, b) -> np.ndarray:
    """a / b, 0 where b is 0."""
    a, b = np.broadcast_arrays(np.asarray(a, np.float32), np.asarray(b, np.float32))
    return np.divide(a, b, out=np.zeros_like(a), where=b != 0.0)


def clipped(a) -> np.ndarray:
    return np.clip(a, 0.0, 1.0)


def mixed(a, b, t) -> np.ndarray:
    return a + (b - a) * t


def convert(value, source: str, target: str, luminance=LUMINANCE) -> np.ndarray:
    """A value as a socket of another type takes it: NUMBER, VECTOR or COLOR.

    luminance: float32 (3,), the weights of the channels
    """
    if source == target or {source, target} == {"VECTOR", "COLOR"}:
        return value
    if target != "NUMBER":
        return np.repeat(np.asarray(value, np.float32)[..., None], 3, -1)
    if source == "COLOR":
        return value @ luminance
    return row_means(value)


def as_number(value, n: int) -> np.ndarray:
    """float32 (n,), as kernels take it."""
    return _shaped(value, (n,))


def as_vector(value, n: int) -> np.ndarray:
    """float32 (n, 3), as kernels take it."""
    return _shaped(value, (n, 3))


def _shaped(value, shape) -> np.ndarray:
    """C-contiguous and writable: for another kind of array kernels are compiled anew."""
    value = np.asarray(value, np.float32)
    if value.shape != shape:
        value = np.broadcast_to(value, shape)
    return np.require(value, requirements="CW")
