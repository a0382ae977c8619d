"""Which of many lamps a point takes: in proportion to what each may bring there, by the matte lobe
and by the glossy one."""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from ..bsdf.brdf import pdf_narrowest_at
from ..bsdf.lambert_kinds import HAIR
from ..bsdf.lobes import DIFFUSE_LOBE
from ..bsdf.microfacet import MIN_ALPHA
from ..data.channels import LUMINANCE
from ..data.lamps import BEAM, DISC, MESH, NOT_BY_BSDF, ROUND_BEAM, SPHERE, SUN, Lamps
from .lamp_cones import cone_factor, soft_cone_factor
from .lamp_falloff import falloff_at
from .lamp_shares import LEAST_COSINE, LEAST_SHARE, LEAST_SQUARED, knows, share_plain
from .near_meshes import is_near_mesh

# Up to so many lamps all are sampled; of more, so many at each point.
ALL_LAMPS, CHOSEN_LAMPS = 16, 8
_QUARTER = 0.5 * math.pi
_NO_CONE = np.float32(-1.5)
_ZERO = np.float32(0.0)


def powers_of(lamps: Lamps) -> np.ndarray:
    """float64 (n,): radiant intensity of each lamp, or its irradiance where it has no distance."""
    light = lamps.radiance.astype(np.float64) @ LUMINANCE
    width, height = lamps.size.astype(np.float64).T
    area = np.where(height > 0.0, width * height, math.pi * width**2)
    sun = lamps.kind == SUN
    area[sun] = math.pi * np.sin(width[sun]) ** 2
    mesh = lamps.kind == MESH
    area[mesh], light[mesh] = 0.5, lamps.faces.nodes[lamps.span[mesh, 2], 6]
    beam = (lamps.kind == BEAM) | (lamps.kind == ROUND_BEAM)
    return light * np.where(beam | (area == 0.0), 1.0, area)


@kernel(forceinline=True)
def _falloff(lamps, i, far):
    """What the distance to its middle makes of lamp i's light; never 0, for elsewhere on the lamp
    it may be more."""
    if lamps.falloff[i] < 0:
        return 1.0
    r, g, b = falloff_at(lamps, i, far)
    mean = (r + g + b) / 3.0
    return mean if mean > 0.0 else 1.0


@kernel(forceinline=True)
def _cosine(at, x, y, z, width, far):
    """About the cosine at a surface, of a lamp that is so wide, at (x, y, z) from there; 0 only
    where all of it is below. What gloss, which asks for none, has of it is not nothing.

    at: LobesAt; what is glossy may have another normal, hair none
    """
    if at.rough[3] <= HAIR:
        return 1.0
    height = at.normal[0] * x + at.normal[1] * y + at.normal[2] * z
    if at.kind > DIFFUSE_LOBE:
        m = at.glossy_normal
        height = max(height, m[0] * x + m[1] * y + m[2] * z)
    if height + width <= 0.0:
        return 0.0
    return max(min((height + width) / max(far, 1e-12), 1.0), LEAST_COSINE)


@kernel(forceinline=True)
def _lobe_towards(at, x, y, z, radius, far):
    """The greatest density of the glossy lobe over a ball of that radius at (x, y, z) from the
    point, so ``far``; less where the ball holds most of the lobe, whose own samples meet it."""
    m, wo, twice, scale = at.glossy_normal, at.wo, 2.0 * at.cos_o, 1.0 / max(far, 1e-12)
    rx, ry, rz = twice * m[0] - wo[0], twice * m[1] - wo[1], twice * m[2] - wo[2]
    dx, dy, dz = x * scale, y * scale, z * scale
    cosine, sine = dx * rx + dy * ry + dz * rz, min(radius * scale, 1.0)
    along = math.sqrt(1.0 - sine * sine)
    if cosine < along:  # the ball's edge that is nearest to the mirrored direction
        aside = sine / math.sqrt(max(1.0 - cosine * cosine, 1e-12))
        along -= aside * cosine
        rx, ry, rz = along * dx + aside * rx, along * dy + aside * ry, along * dz + aside * rz
    density = np.float64(pdf_narrowest_at(at, np.float32(rx), np.float32(ry), np.float32(rz)))
    held = math.pi * sine * sine * density
    return density / (1.0 + held * held)


@kernel(forceinline=True)
def _reflected(at, x, y, z, extent, radius, far):
    """About pi times what the BSDF makes of light from there, of all that it reflects; 0 only where
    all of the lamp is below. extent: of _cosine; radius: of _lobe_towards"""
    cosine = _cosine(at, x, y, z, extent, far)
    if at.kind <= DIFFUSE_LOBE or at.alpha <= MIN_ALPHA or cosine == 0.0:
        return cosine
    share = np.float64(at.diffuse_share)
    gloss = math.pi * (1.0 - share) * _lobe_towards(at, x, y, z, radius, far)
    return cosine * max(share, LEAST_SHARE) + gloss


@kernel(forceinline=True)
def _towards(lamps, i, x, y, z, width, far):
    """About what lamp i shines towards (x, y, z), so far from its middle, of what it does along its
    axis; 0 only for a spot whose cone ends before. width: of a spot its radius"""
    share = 1.0
    if lamps.size[i, 1] > _ZERO:
        f = lamps.axis
        share = min((x * f[i, 0] + y * f[i, 1] + z * f[i, 2] + width) / max(far, 1e-12), 1.0)
    elif lamps.cone[i, 0] > _NO_CONE and width > 0.0:
        return soft_cone_factor(lamps, i, -x, -y, -z, width / max(far, 1e-12))
    elif lamps.cone[i, 0] > _NO_CONE:
        share = cone_factor(lamps, i, -x, -y, -z)
    return max(share, LEAST_COSINE) if width > 0.0 else share


@kernel(forceinline=True)
def _importance(lamps, powers, i, px, py, pz, at):
    """What lamp i may bring to a point; 0 only where it brings nothing."""
    kind = lamps.kind[i]
    if kind == SUN:
        x, y, z = -lamps.forward[i, 0], -lamps.forward[i, 1], -lamps.forward[i, 2]
        sine = math.sin(min(lamps.size[i, 0], _QUARTER))
        return powers[i] * _reflected(at, x, y, z, sine, sine, 1.0)
    x = px - np.float64(lamps.position[i, 0])
    y = py - np.float64(lamps.position[i, 1])
    z = pz - np.float64(lamps.position[i, 2])
    f = lamps.axis
    if lamps.size[i, 1] > _ZERO and x * f[i, 0] + y * f[i, 1] + z * f[i, 2] <= 0.0:
        return 0.0
    if kind == BEAM or kind == ROUND_BEAM:
        height = x * f[i, 0] + y * f[i, 1] + z * f[i, 2]
        return powers[i] * _falloff(lamps, i, height)
    width, height = np.float64(lamps.size[i, 0]), np.float64(lamps.size[i, 1])
    radius = 0.5 * max(width, height)
    squared = max(x * x + y * y + z * z, max(radius * radius, LEAST_SQUARED))
    far = math.sqrt(squared)
    reach = width if kind == SPHERE or kind == DISC else radius
    share = _falloff(lamps, i, far) * _reflected(at, -x, -y, -z, width + height, reach, far)
    return powers[i] / squared * share * _towards(lamps, i, x, y, z, width + height, far)


@kernel(forceinline=True)
def share_out(lamps, powers, plain, points, p, at, shares):
    """Write how many samples each lamp may expect at point p. plain: of plain_lamps; at: LobesAt of
    it."""
    place = points.position
    px, py, pz = np.float64(place[p, 0]), np.float64(place[p, 1]), np.float64(place[p, 2])
    total, in_rows = 0.0, knows(at)
    if in_rows:
        share_plain(plain, at, px, py, pz)
        for k in range(len(plain.row)):
            shares[plain.row[k]] = plain.most * np.float64(plain.share[k])
    for k in range(len(plain.others) if in_rows else len(powers)):
        i = plain.others[k] if in_rows else k
        shares[i] = _importance(lamps, powers, i, px, py, pz, at)
    for i in range(len(powers)):
        total += shares[i]
    for i in range(len(powers)):
        shares[i] = shares[i] * CHOSEN_LAMPS / total if total > 0.0 else 0.0


@kernel(forceinline=True)
def is_in_mirrors(lamps, i):
    """Whether a perfect mirror shows lamp i: what has a size and is found by the BSDF."""
    finds = not lamps.seen_by[i] & NOT_BY_BSDF
    return finds and lamps.size[i, 0] > _ZERO and lamps.kind[i] < BEAM


@kernel(forceinline=True)
def is_met(lamps, i, sharp, position, p):
    """Whether the BSDF's samples at point p look for lamp i: a sharp lobe's, where mirrors do."""
    if not sharp:
        return is_near_mesh(lamps, i, position, p)
    return is_in_mirrors(lamps, i)
