"""What many lamps may bring to a point, eight or sixteen at a time: balls and shining meshes, whose
share is a matter of the distance and of the BSDF alone (lamp_choice.py has the formula).

In float32: only how often a lamp is drawn depends on it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.lobes import DIFFUSE_LOBE
from ..bsdf.microfacet import MIN_ALPHA
from ..data.lamps import DISC, EVERYWHERE, MESH, SPHERE, Lamps

LEAST_COSINE, LEAST_SHARE, LEAST_SQUARED = 0.1, 0.1, 1e-12
_ZERO, _ONE = np.float32(0.0), np.float32(1.0)
_LEAST_COSINE, _LEAST_SHARE = np.float32(LEAST_COSINE), np.float32(LEAST_SHARE)
_HALF, _QUARTER = np.float32(0.5), np.float32(0.25)
_SLACK = np.float32(1e-5)  # of a cosine: a lamp that just rises over a surface is not left out
_TINY = np.float32(1e-12)


class PlainLamps(NamedTuple):
    """Lamps that share_plain knows, one a row, and the others.

    row: int32 (k,), of Lamps; others: int32 (m,)
    x, y, z: float32 (k,), world space; power: float32 (k,), of powers_of, of which ``most`` is 1
    extent, reach: float32 (k,), metres, of lamp_choice's _cosine and _lobe_towards
    least: float32 (k,), the square of the distance below which it counts no more
    share: float32 (k,), room
    """

    row: np.ndarray
    others: np.ndarray
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    power: np.ndarray
    extent: np.ndarray
    reach: np.ndarray
    least: np.ndarray
    share: np.ndarray
    most: float


def plain_lamps(lamps: Lamps, powers: np.ndarray) -> PlainLamps:
    """Those of some lamps. powers: of powers_of"""
    kinds = np.isin(lamps.kind, (SPHERE, DISC, MESH)) & (lamps.falloff < 0)
    plain = kinds & (lamps.cone[:, 0] == EVERYWHERE) & (lamps.size[:, 1] == 0.0)
    row = np.flatnonzero(plain).astype(np.int32)
    most = float(powers[row].max(initial=0.0)) or 1.0
    width = lamps.size[row, 0].astype(np.float64)
    reach = np.where(lamps.kind[row] == MESH, 0.5 * width, width)
    columns = *lamps.position[row].T, powers[row] / most, width, reach
    columns += (np.maximum((0.5 * width) ** 2, LEAST_SQUARED),)
    columns = [np.ascontiguousarray(column, np.float32) for column in columns]
    others, room = np.flatnonzero(~plain).astype(np.int32), np.empty(len(row), np.float32)
    return PlainLamps(row, others, *columns, room, most)


@kernel(forceinline=True)
def knows(at):
    """Whether share_plain has the lobes of a point: Lambert's and round GGX. at: LobesAt"""
    return at.rough[3] >= _ZERO and (
        at.kind == DIFFUSE_LOBE or (at.narrow == _ZERO and not at.gaussian)
    )


@kernel(forceinline=True)
def share_plain(plain, at, x, y, z):
    """Write to plain.share what its lamps may bring to (x, y, z), of most. at: LobesAt of it"""
    px, py, pz = np.float32(x), np.float32(y), np.float32(z)
    m = at.normal if at.kind == DIFFUSE_LOBE else at.glossy_normal
    if at.kind == DIFFUSE_LOBE or at.alpha <= np.float32(MIN_ALPHA):
        _share_matte(plain, px, py, pz, at.normal, m)
        return
    matte, gloss = max(at.diffuse_share, _LEAST_SHARE), _ONE - at.diffuse_share
    scale = _QUARTER / (at.cos_o * at.seen)  # 1 / pi of the density and pi of the share are 1
    own = at.normal, m, at.wo, at.cos_o, at.alpha * at.alpha
    _share_glossy(plain, px, py, pz, *own, scale, matte, gloss)


@kernel(forceinline=True)
def _seen_from(plain, k, px, py, pz, normal, m):
    """Where lamp k is from a point, metres; one over how far; about its cosine to both normals."""
    x, y, z = plain.x[k] - px, plain.y[k] - py, plain.z[k] - pz
    by = _ONE / np.sqrt(max(x * x + y * y + z * z, plain.least[k]))
    height = normal[0] * x + normal[1] * y + normal[2] * z
    height = max(height, m[0] * x + m[1] * y + m[2] * z)
    return x, y, z, by, (height + plain.extent[k]) * by


@kernel
def _share_matte(plain, px, py, pz, normal, m):
    for k in range(len(plain.x)):
        _, _, _, by, cosine = _seen_from(plain, k, px, py, pz, normal, m)
        bring = max(min(cosine, _ONE), _LEAST_COSINE) if cosine > -_SLACK else _ZERO
        plain.share[k] = plain.power[k] * by * by * bring


@kernel
def _share_glossy(plain, px, py, pz, normal, m, wo, cos_o, alpha2, scale, matte, gloss):
    twice = cos_o + cos_o
    rx, ry, rz = twice * m[0] - wo[0], twice * m[1] - wo[1], twice * m[2] - wo[2]
    for k in range(len(plain.x)):
        x, y, z, by, cosine = _seen_from(plain, k, px, py, pz, normal, m)
        risen = cosine > -_SLACK
        cosine = max(min(cosine, _ONE), _LEAST_COSINE)
        # The ball's edge that is nearest to the mirrored direction, or that.
        x, y, z = x * by, y * by, z * by
        along, sine = x * rx + y * ry + z * rz, min(plain.reach[k] * by, _ONE)
        edge = np.sqrt(_ONE - sine * sine)
        aside = sine / np.sqrt(max(_ONE - along * along, _TINY))
        outside = along < edge
        edge = edge - aside * along if outside else _ZERO
        aside = aside if outside else _ONE
        x, y, z = edge * x + aside * rx, edge * y + aside * ry, edge * z + aside * rz
        # GGX' density there (brdf.pdf_facets_at).
        x, y, z = x + wo[0], y + wo[1], z + wo[2]
        size = _ONE / np.sqrt(max(x * x + y * y + z * z, _TINY))
        x, y, z = x * size - m[0], y * size - m[1], z * size - m[2]
        chord2 = x * x + y * y + z * z
        sin2 = max(chord2 * (_ONE - _QUARTER * chord2), _ZERO)
        t = sin2 + alpha2 * (_ONE - sin2)
        density = scale * alpha2 / (t * t) if _HALF * chord2 < _ONE else _ZERO
        held = sine * sine * density
        density = density / (_ONE + held * held)
        bring = cosine * matte + gloss * density
        plain.share[k] = plain.power[k] * by * by * bring if risen else _ZERO
