"""MERL's measured BRDFs: the file, and the value between its samples [Matusik03].

A table holds an isotropic BRDF over Rusinkiewicz's angles: theta_h of the half vector h to the
normal, theta_d of wi to h, phi_d of wi about h. Sample (i, j, k) stands at

    theta_h = (i / 90)^2 90 deg,   theta_d = j deg,   phi_d = k deg.

phi_d repeats after 180 degrees (swapping wi and wo turns it by so much: reciprocity). In the file
red, green and blue follow one another, float64, to be multiplied by 1, 1.15, 1.66 over 1500;
negative where undefined (wi or wo below the surface). Between samples we interpolate linearly in
the index, where [Matusik03]'s own reader takes the sample below; undefined samples then stand for
the last defined one of smaller theta_d, so that no lobe is darkened towards the horizon.
"""

from __future__ import annotations

import hashlib
import math
import os
from pathlib import Path

import numpy as np

from .._jit import kernel
from .microfacet import INV_PI, ONE, ZERO, dot

SIDES = THETA_H, THETA_D, PHI_D = 90, 90, 180
_SAMPLES = THETA_H * THETA_D * PHI_D
_HEADER_BYTES = 12
FILE_BYTES = _HEADER_BYTES + 3 * 8 * _SAMPLES
_SCALE = np.array([1.0, 1.15, 1.66]) / 1500.0
_PER_RADIAN = np.float32(90.0 / (0.5 * math.pi))


def read_merl(path: str | os.PathLike) -> tuple[np.ndarray, str]:
    """A file's BRDF, float32 (90, 90, 180, 3), sr^-1, and the sha256 of its bytes.

    Raises FileNotFoundError, or OSError where it cannot be read, ValueError where it is no table.
    """
    try:
        size = os.stat(path).st_size
        with Path(path).open("rb") as file:
            data = file.read(FILE_BYTES)
    except FileNotFoundError:
        raise FileNotFoundError(f"{path}: there is no such file") from None
    except OSError as error:
        raise OSError(f"{path}: cannot be read: {error.strerror}") from None
    _check_size(path, data, size)
    values = np.frombuffer(data, "<f8", offset=_HEADER_BYTES).reshape(3, *SIDES)
    return _defined(path, values), hashlib.sha256(data).hexdigest()


def _check_size(path, data: bytes, size: int) -> None:
    if len(data) < _HEADER_BYTES:
        raise ValueError(f"{path}: is no MERL table: {size} bytes, shorter than its header")
    sides = tuple(int(n) for n in np.frombuffer(data, "<i4", 3))
    if sides != SIDES:
        found, wanted = (" x ".join(map(str, s)) for s in (sides, SIDES))
        raise ValueError(f"{path}: is no MERL table of {wanted} samples: its header says {found}")
    if size != FILE_BYTES:
        what = "is cut off" if size < FILE_BYTES else "is too long for a MERL table"
        raise ValueError(f"{path}: {what}: {size} bytes of {FILE_BYTES}")


def _defined(path, values: np.ndarray) -> np.ndarray:
    """Scaled, channels last; what is undefined is filled from smaller theta_d, or is 0."""
    if not np.isfinite(values).all():
        raise ValueError(f"{path}: holds values that are infinite or no numbers")
    known = (values >= 0.0).all(axis=0)
    if not known.any():
        raise ValueError(f"{path}: has no defined value: all are negative")
    # theta_d of the nearest defined sample below; -1: none.
    rows = np.where(known, np.arange(THETA_D)[None, :, None], -1)
    rows = np.maximum.accumulate(rows, axis=1)
    table = np.empty((*SIDES, 3), np.float32)
    for c in range(3):
        filled = np.take_along_axis(values[c], np.maximum(rows, 0), axis=1)
        table[..., c] = np.where(rows >= 0, filled, 0.0) * _SCALE[c]
    return table


@kernel(forceinline=True)
def _corner(x, last):
    """Index and fraction of a place along an axis that ends at sample ``last``."""
    i = min(int(x), last)
    return i, min(i + 1, last), min(max(x - np.float32(i), ZERO), ONE)


@kernel(forceinline=True)
def _indices(normal, wo, wi):
    """Where wi, wo are in the table, in samples: (theta_h, theta_d, phi_d), float32."""
    hx, hy, hz = wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2]
    vx, vy, vz = wi[0] - wo[0], wi[1] - wo[1], wi[2] - wo[2]
    length = math.sqrt(hx * hx + hy * hy + hz * hz)
    theta_d = math.atan2(math.sqrt(vx * vx + vy * vy + vz * vz), length)
    nx, ny, nz = normal
    # n x h, whose length is sin theta_h |h|; v = wi - wo lies in the plane about h.
    sx, sy, sz = ny * hz - nz * hy, nz * hx - nx * hz, nx * hy - ny * hx
    sine = math.sqrt(sx * sx + sy * sy + sz * sz)
    theta_h = math.atan2(sine, nx * hx + ny * hy + nz * hz)
    along = -(nx * vx + ny * vy + nz * vz) * length
    phi_d = math.atan2(vx * sx + vy * sy + vz * sz, along)
    index_h = math.sqrt(max(theta_h, ZERO) * _PER_RADIAN * np.float32(THETA_H))
    index_p = phi_d * _PER_RADIAN
    if index_p < ZERO:
        index_p += np.float32(PHI_D)
    return index_h, theta_d * _PER_RADIAN, index_p


@kernel(forceinline=True)
def eval_merl(tables, m, normal, wo, wi):
    """Table m's BRDF (without the cosine), interpolated: (r, g, b), float32, sr^-1.

    tables: float32 (n, 90, 90, 180, 3); normal, wo, wi: unit triples, both directions above
    """
    index_h, index_d, index_p = _indices(normal, wo, wi)
    h0, h1, fh = _corner(index_h, THETA_H - 1)
    d0, d1, fd = _corner(index_d, THETA_D - 1)
    p0 = min(int(index_p), PHI_D - 1)
    p1 = p0 + 1 if p0 + 1 < PHI_D else 0
    fp = min(max(index_p - np.float32(p0), ZERO), ONE)
    r = g = b = ZERO
    for corner in range(4):
        i = h1 if corner & 1 else h0
        j = d1 if corner & 2 else d0
        weight = (fh if corner & 1 else ONE - fh) * (fd if corner & 2 else ONE - fd)
        low, high = weight * (ONE - fp), weight * fp
        r += low * tables[m, i, j, p0, 0] + high * tables[m, i, j, p1, 0]
        g += low * tables[m, i, j, p0, 1] + high * tables[m, i, j, p1, 1]
        b += low * tables[m, i, j, p0, 2] + high * tables[m, i, j, p1, 2]
    return r, g, b


@kernel
def eval_measured_at(at, wi_x, wi_y, wi_z):
    """brdf.eval_at of a table: as much of it as the fitted Lambert lobe has counts as diffuse."""
    wi = (wi_x, wi_y, wi_z)
    cos_n = max(dot(at.normal, wi), ZERO)
    scale = cos_n * INV_PI
    dr, dg, db = at.diffuse[0] * scale, at.diffuse[1] * scale, at.diffuse[2] * scale
    if dot(at.glossy_normal, wi) <= ZERO or cos_n <= ZERO:
        return dr, dg, db, ZERO, ZERO, ZERO
    r, g, b = eval_merl(at.tables, at.table, at.glossy_normal, at.wo, wi)
    r, g, b = r * at.tint[0] * cos_n, g * at.tint[1] * cos_n, b * at.tint[2] * cos_n
    dr, dg, db = min(dr, r), min(dg, g), min(db, b)
    return dr, dg, db, r - dr, g - dg, b - db
