"""The light of lamps at shading points: a sample of each lamp, and one by the BSDF.

A sample goes to the lamp; where a lobe is narrow another follows the lobe and brings the light of
the lamps that it meets, for a mirror shows a lamp; and beside a mesh one of the whole BSDF. They
count by the power heuristic [Veach95].
Of many lamps a few are taken, in proportion to their irradiance at the point, were nothing between.

The numbers are Sobol points, scrambled and shuffled for each pixel and lamp (sequence.py), so that
sample 0, 1, 2 ... of a pixel fill each lamp evenly and a picture depends on nothing else.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.brdf import (
    eval_at,
    pdf_at,
    pdf_narrowest_at,
    power_heuristic,
    sample_at,
    sample_narrowest_at,
)
from ..bsdf.lambert_kinds import PHONG
from ..bsdf.lobes import DIFFUSE_LOBE, Lobes
from ..bsdf.lobes_at import lobes_at
from ..bsdf.luminance import luminance
from ..bsdf.microfacet import MIN_ALPHA
from ..bsdf.toon import is_toon
from ..camera.pixel_filter import LAMPS, point_of_pixel
from ..data.lamps import BY_DIFFUSE, BY_GLOSSY, Lamps
from ..embree.accel import Accel
from ..geometry.shading import ShadingPoints
from ..machine.turns import aside
from ..scene import ROUND
from .lamp_choice import ALL_LAMPS, CHOSEN_LAMPS, is_in_mirrors, is_met, powers_of, share_out
from .lamp_falloff import falloff_at
from .lamp_pictures import tint_at
from .lamp_rays import COLUMNS, UNOCCLUDED, LampRays, add_rays, aim, bring, column_of
from .lamp_shapes import meet_lamp, sample_lamp
from .lamp_shares import plain_lamps
from .near_meshes import near_meshes

# Lobes of a greater alpha leave lamps to the lamps' own samples, but for faces that are near.
_NARROW = np.float32(0.3)
_CAPACITY = 8192  # rays that are traced together
_BSDF_SALT, _CHOICE_SALT, _LAMP_SALT = LAMPS, LAMPS + 3, LAMPS + 6
_ZERO, _ROUND = np.float32(0.0), np.float32(ROUND)


class LampSamples(NamedTuple):
    """Which numbers the samples take.

    columns, rows, number: int64 (n,), the points' pixels in the frame, the number of each
    count: how many samples: number x count, and those that follow
    """

    columns: np.ndarray
    rows: np.ndarray
    number: np.ndarray
    seed: int
    count: int = 1


@kernel(forceinline=True)
def _float64(vectors, p):
    return np.float64(vectors[p, 0]), np.float64(vectors[p, 1]), np.float64(vectors[p, 2])


@kernel(forceinline=True)
def _write(at, points, p, lamps, i, face, wi, far, weight, lifted, offset, rays, n, sums):
    """Write the light of lamp i from wi as ray n, or add it at once; returns the next n.

    face: of sample_lamp; weight: factor of its radiance times the BRDF and the cosine
    """
    dr, dg, db, gr, gg, gb = eval_at(at, np.float32(wi[0]), np.float32(wi[1]), np.float32(wi[2]))
    seen_by = lamps.seen_by[i]
    diffuse = weight if seen_by & BY_DIFFUSE else 0.0
    glossy = weight if seen_by & BY_GLOSSY else 0.0
    if at.alpha <= MIN_ALPHA and not is_in_mirrors(lamps, i):
        glossy = 0.0
    r, g, b = lamps.radiance[i, 0], lamps.radiance[i, 1], lamps.radiance[i, 2]
    if face >= 0:
        flat = points.geometric_normal
        above = flat[p, 0] * wi[0] + flat[p, 1] * wi[1] + flat[p, 2] * wi[2]
        if abs(above) * far <= offset:  # the face that the point is on
            return n
        if above <= 0.0 and not (lifted and points.lift_below[p] < _ROUND):  # it turns away
            return n
        own = lamps.faces.radiance
        r, g, b = own[face, 0], own[face, 1], own[face, 2]
    elif lamps.picture[i, 1] > 0:
        tints = tint_at(lamps, i, *_float64(points.position, p), wi[0], wi[1], wi[2], far)
        r, g, b = np.float32(r * tints[0]), np.float32(g * tints[1]), np.float32(b * tints[2])
    if lamps.falloff[i] >= 0:
        by = falloff_at(lamps, i, far)
        r, g, b = np.float32(r * by[0]), np.float32(g * by[1]), np.float32(b * by[2])
    total = (dr * r + dg * g + db * b) * diffuse + (gr * r + gg * g + gb * b) * glossy
    if not 0.0 < total < np.inf:
        return n
    light = rays.light
    light[n, 0], light[n, 1], light[n, 2] = dr * r * diffuse, dg * g * diffuse, db * b * diffuse
    light[n, 3], light[n, 4], light[n, 5] = gr * r * glossy, gg * g * glossy, gb * b * glossy
    light[n, UNOCCLUDED] = luminance(
        light[n, 0] + light[n, 3], light[n, 1] + light[n, 4], light[n, 2] + light[n, 5]
    )
    if not lamps.shadow[i]:
        sums[p, UNOCCLUDED] += light[n, UNOCCLUDED]
        column = column_of(lamps.group[i], sums)
        for color in range(3):
            bring(column, color, light, n, sums, p)
        return n
    if not aim(points, p, wi, far, lifted, offset, rays, n):
        return n
    rays.point[n], rays.lamp[n] = p, i
    return n + 1


@kernel(forceinline=True)
def _pdf(at, near, x, y, z):
    """The density of the BSDF's samples: of its narrow lobe, or beside a mesh of all."""
    return pdf_at(at, x, y, z) if near else pdf_narrowest_at(at, x, y, z)


@kernel(forceinline=True)
def _below_smooth(at, x, y, z):
    """Whether a map has turned the normal, and the light comes from below the smooth surface.

    Matte has none from there (bump_gain), nor has gloss of Cycles' light samples.
    """
    return at.bump > 0.0 and at.smooth[0] * x + at.smooth[1] * y + at.smooth[2] * z <= 0.0


@kernel(forceinline=True)
def _to_lamp(at, points, p, lamps, i, share, follows, a, b, offset, rays, n, sums):
    """A sample of lamp i from point p; share: samples of it that are expected; follows: whether
    samples of the BSDF follow, of a sharp lobe, and beside a mesh."""
    sharp, near = follows
    px, py, pz = _float64(points.position, p)
    nx, ny, nz = np.float64(at.normal[0]), np.float64(at.normal[1]), np.float64(at.normal[2])
    dx, dy, dz, far, factor, pdf, face = sample_lamp(lamps, i, px, py, pz, nx, ny, nz, a, b)
    if not factor > 0.0 or _below_smooth(at, dx, dy, dz):
        return n
    weight = factor / (pdf * share)
    if (sharp or near) and is_met(lamps, i, sharp, points.position, p):
        by_lobe = _pdf(at, near, np.float32(dx), np.float32(dy), np.float32(dz))
        weight *= power_heuristic(pdf * share, np.float64(by_lobe))
    below, flat = np.float64(points.lift_below[p]), points.geometric_normal
    above = flat[p, 0] * dx + flat[p, 1] * dy + flat[p, 2] * dz
    lifted = below > 0.0 and above < below + below
    wi = dx, dy, dz
    return _write(at, points, p, lamps, i, face, wi, far, weight, lifted, offset, rays, n, sums)


@kernel(forceinline=True)
def _by_lobe(at, points, p, lamps, shares, follows, u, v, offset, rays, n, sums):
    """A sample of the narrow lobe, or of all: the light of the lamps that it is to meet."""
    sharp, near = follows
    if near:
        x, y, z, _ = sample_at(at, np.float32(u), np.float32(v))
    else:
        x, y, z = sample_narrowest_at(at, np.float32(u), np.float32(v))
    pdf = np.float64(_pdf(at, near, x, y, z))
    if not 0.0 < pdf < np.inf:
        return n
    dx, dy, dz = np.float64(x), np.float64(y), np.float64(z)
    px, py, pz = _float64(points.position, p)
    nx, ny, nz = np.float64(at.normal[0]), np.float64(at.normal[1]), np.float64(at.normal[2])
    # Not the face that the point is on: _write leaves that out, and no sample would find another.
    flat = points.geometric_normal
    above = flat[p, 0] * dx + flat[p, 1] * dy + flat[p, 2] * dz
    beyond = offset / above if above > 0.0 else np.inf
    for i in range(len(lamps.kind)):
        if not is_met(lamps, i, sharp, points.position, p):
            continue
        ray = px, py, pz, nx, ny, nz, dx, dy, dz
        far, factor, by_lamp, face = meet_lamp(lamps, i, *ray, beyond)
        left = lamps.layers[i]
        while factor > 0.0 and left > 0:
            weight = factor * power_heuristic(pdf, by_lamp * shares[i]) / pdf
            lifted = points.lift_below[p] >= _ROUND
            own = at, points, p, lamps, i, face, (dx, dy, dz), far, weight, lifted
            n = _write(*own, offset, rays, n, sums)
            left -= 1
            if left > 0:
                far, factor, by_lamp, face = meet_lamp(lamps, i, *ray, far)
    return n


@kernel(forceinline=True)
def _draw_one(at, points, p, lamps, shares, follows, choose, place, offset, rays, n, sums):
    """Write a sample of point p as rays; returns the next n. place: of its numbers"""
    n_lamps, start = len(shares), 0.0
    if choose:
        start, _ = point_of_pixel(place, _CHOICE_SALT)
    i, passed = 0, shares[0]
    for k in range(CHOSEN_LAMPS if choose else n_lamps):
        if choose:
            while passed <= start + k and i < n_lamps - 1:
                i += 1
                passed += shares[i]
        else:
            i = k
        if shares[i] > 0.0:
            a, b = point_of_pixel(place, _LAMP_SALT + 3 * k)
            own = at, points, p, lamps, i, shares[i], follows, a, b
            n = _to_lamp(*own, offset, rays, n, sums)
    if follows[0] or follows[1]:
        u, v = point_of_pixel(place, _BSDF_SALT)
        n = _by_lobe(at, points, p, lamps, shares, follows, u, v, offset, rays, n, sums)
    return n


@kernel
def _draw(points, lobes, lamps, powers, plain, shares, samples, offset, first, rays, sums):
    """Write the samples of points from ``first`` on: (the next point, number of rays)."""
    n, p, choose, count = 0, first, len(powers) > ALL_LAMPS, samples.count
    most = count * _most_rays(lamps)
    shares[:] = 1.0
    while p < len(points.pixel) and n + most <= len(rays.reach):
        at = lobes_at(lobes, p)
        if at.kind == 0:
            p += 1
            continue
        sharp = (at.kind > DIFFUSE_LOBE or is_toon(at.rough)) and at.alpha < _NARROW
        of_facets = at.rough[3] >= _ZERO or at.rough[3] == PHONG
        near = of_facets and near_meshes(lamps, points.position, p)
        if choose:
            share_out(lamps, powers, plain, points, p, at, shares)
        for k in range(count):
            number = samples.number[p] * count + k
            place = samples.columns[p], samples.rows[p], number, samples.seed
            own = at, points, p, lamps, shares, (sharp, near), choose, place
            n = _draw_one(*own, offset, rays, n, sums)
        p += 1
    return p, n


@kernel(forceinline=True)
def _most_rays(lamps):
    """Of one sample of a point: to lamps, and along the BSDF to each."""
    most = len(lamps.layers)
    most = CHOSEN_LAMPS if most > ALL_LAMPS else most
    for i in range(len(lamps.layers)):
        most += lamps.layers[i]
    return most


@aside()
def add_lamp_light(
    points: ShadingPoints, lobes: Lobes, lamps: Lamps, accel: Accel, samples: LampSamples, sums
) -> int:
    """Add samples of every lamp to each point; returns how many shadow rays were traced.

    sums: float64 (n, COLUMNS or more), radiance, added to
    """
    n_lamps = len(lamps.kind)
    if not n_lamps or not len(points.pixel):
        return 0
    most = samples.count * _most_rays(lamps)
    capacity = max(min(_CAPACITY, most * len(points.pixel)), most)
    rays = LampRays(
        *(np.empty((capacity, 3), np.float32) for _ in range(2)),
        np.empty(capacity, np.float32),
        *(np.empty(capacity, np.int32) for _ in range(2)),
        np.empty((capacity, COLUMNS), np.float32),
    )
    powers, shares = powers_of(lamps), np.empty(n_lamps)
    plain = plain_lamps(lamps, powers)
    offset, first, traced = np.float32(accel.offset), 0, 0
    while first < len(points.pixel):
        own = points, lobes, lamps, powers, plain, shares, samples, offset, first
        first, n = _draw(*own, rays, sums)
        own = rays.origins[:n], rays.directions[:n], np.empty(n, np.uint8), rays.reach[:n]
        add_rays(lamps, rays, n, accel.occluded(*own, rays.lamp[:n]), sums)
        traced += n
    return traced
