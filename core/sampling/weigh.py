"""What the samples in the lanes carry: radiance x BSDF x cosine over density, and a ray to ask for.

The end of the way for samples of the product: warp.py has given them directions, trace_lanes.py
asks which of them see the light.
"""

from __future__ import annotations

import numpy as np

from .._jit import kernel
from ..bsdf.brdf import (
    eval_facets_at,
    eval_filmed_at,
    eval_lobes_at,
    pdf_facets_at,
    pdf_narrowest_at,
    pdf_round_at,
)
from ..bsdf.bump import bump_gain
from ..bsdf.hair import ALL_ROUND, chiang_at, eval_strand, ray_start
from ..bsdf.hair_samples import pdf_strand, shares_of
from ..bsdf.lambert_kinds import CHIANG, HAIR, TRANSLUCENT_ROUND
from ..bsdf.lobes import DIFFUSE_LOBE, MEASURED_LOBE, THIN_FILM
from ..bsdf.lobes_at import lobes_at
from ..bsdf.merl import eval_measured_at
from ..bsdf.microfacet import INV_PI
from ..bsdf.rough_diffuse import roughened
from ..bsdf.stretched import pdf_stretched, stretched
from ..geometry.terminator import lift_share
from ..light.environment import eval_map
from ..machine.lanes import (
    BLUE,
    DIFFUSE,
    DX,
    DY,
    DZ,
    GLOSSY,
    GREEN,
    LANES,
    OX,
    OY,
    OZ,
    PDF,
    RED,
    U,
    V,
)
from ..unit_square.sequence import sample_number
from .light_rays import is_lifted

_ZERO, _ONE = np.float32(0.0), np.float32(1.0)
_ALL_ALIKE = np.float32(0.25) * INV_PI  # the density of the Hair BSDF's own samples


@kernel
def fill_radiance(lookup, lanes, n):
    """RED, GREEN, BLUE: the radiance from each lane's direction, whose place in the map is U, V."""
    numbers = lanes.numbers
    for s in range(n):
        r, g, b = eval_map(lookup, numbers[U + s], numbers[V + s])
        numbers[RED + s], numbers[GREEN + s], numbers[BLUE + s] = r, g, b


@kernel
def _start_rays(points, p, offset, numbers, s, end):
    """OX, OY, OZ of lanes s ... end - 1; what comes from below the face brings nothing.

    It is occluded, whatever the interpolated normal says (docs/decisions/0005).
    """
    face, position = points.geometric_normal, points.position
    nx, ny, nz = face[p, 0], face[p, 1], face[p, 2]
    ox = position[p, 0] + offset * nx
    oy = position[p, 1] + offset * ny
    oz = position[p, 2] + offset * nz
    for k in range(s, end):
        above = numbers[DX + k] * nx + numbers[DY + k] * ny + numbers[DZ + k] * nz
        lit = _ONE if above > _ZERO else _ZERO
        numbers[RED + k] *= lit
        numbers[GREEN + k] *= lit
        numbers[BLUE + k] *= lit
        numbers[OX + k], numbers[OY + k], numbers[OZ + k] = ox, oy, oz


@kernel
def _lift_rays(task, at, p, lanes, s, end):
    """After _start_rays, for a point with a smooth patch over it (terminator.py).

    Rays that start on the patch bring light from below the face as well.
    """
    numbers, points, light = lanes.numbers, task.points, task.light
    face, normal, lift = points.geometric_normal, points.normal, points.lift
    for k in range(s, end):
        wx, wy, wz = numbers[DX + k], numbers[DY + k], numbers[DZ + k]
        u = sample_number(task.sequence, p, lanes.sample[k])
        if not is_lifted(at, points, light, p, wx, wy, wz, u):
            continue
        above = face[p, 0] * wx + face[p, 1] * wy + face[p, 2] * wz
        if above <= _ZERO:
            r, g, b = eval_map(light.lookup, numbers[U + k], numbers[V + k])
            numbers[RED + k], numbers[GREEN + k], numbers[BLUE + k] = r, g, b
        cosine = normal[p, 0] * wx + normal[p, 1] * wy + normal[p, 2] * wz
        share = lift_share(above, cosine, points.lift_below[p])
        numbers[OX + k] += share * lift[p, 0]
        numbers[OY + k] += share * lift[p, 1]
        numbers[OZ + k] += share * lift[p, 2]


@kernel
def _weigh_matte(at, share, numbers, s, end):
    """DIFFUSE and GLOSSY of the lanes of a point that has a Lambert lobe alone."""
    for k in range(s, end):
        wx, wy, wz = numbers[DX + k], numbers[DY + k], numbers[DZ + k]
        cosine = max(at.normal[0] * wx + at.normal[1] * wy + at.normal[2] * wz, _ZERO)
        scale = cosine * INV_PI
        pdf = share * scale + (_ONE - share) * numbers[PDF + k]
        scale = scale / pdf if pdf > _ZERO else _ZERO
        numbers[DIFFUSE + k] = at.diffuse[0] * scale * numbers[RED + k]
        numbers[DIFFUSE + LANES + k] = at.diffuse[1] * scale * numbers[GREEN + k]
        numbers[DIFFUSE + 2 * LANES + k] = at.diffuse[2] * scale * numbers[BLUE + k]
        numbers[GLOSSY + k] = _ZERO
        numbers[GLOSSY + LANES + k] = _ZERO
        numbers[GLOSSY + 2 * LANES + k] = _ZERO


@kernel(forceinline=True)
def _write_light(numbers, k, pdf, value):
    inverse = _ONE / pdf if pdf > _ZERO else _ZERO
    for c in range(3):
        light = numbers[RED + LANES * c + k] * inverse
        numbers[DIFFUSE + LANES * c + k] = value[c] * light
        numbers[GLOSSY + LANES * c + k] = value[3 + c] * light


@kernel(forceinline=True)
def _weigh_glossy(at, gaussian, share, numbers, s, end):
    """The same for any point with gloss, but without a measured BRDF."""
    for k in range(s, end):
        wx, wy, wz = numbers[DX + k], numbers[DY + k], numbers[DZ + k]
        own = pdf_facets_at(at, gaussian, wx, wy, wz)
        pdf = share * own + (_ONE - share) * numbers[PDF + k]
        _write_light(numbers, k, pdf, eval_facets_at(at, gaussian, wx, wy, wz))


@kernel
def _weigh_measured(at, share, numbers, s, end):
    """The same for a measured BRDF."""
    for k in range(s, end):
        wx, wy, wz = numbers[DX + k], numbers[DY + k], numbers[DZ + k]
        pdf = share * pdf_round_at(at, wx, wy, wz) + (_ONE - share) * numbers[PDF + k]
        _write_light(numbers, k, pdf, eval_measured_at(at, wx, wy, wz))


@kernel
def _shadow_bumps(at, numbers, s, end):
    """Take from the lanes of a point what a turned normal leaves in the shadow of bumps."""
    for k in range(s, end):
        matte = bump_gain(at, numbers[DX + k], numbers[DY + k], numbers[DZ + k])
        for c in range(3):
            numbers[DIFFUSE + LANES * c + k] *= matte


@kernel
def _weigh_rough(at, share, numbers, s, end):
    """The same for a point whose Lambert lobe is rough, sheen or toon, with gloss or without."""
    for k in range(s, end):
        wx, wy, wz = numbers[DX + k], numbers[DY + k], numbers[DZ + k]
        pdf = share * pdf_narrowest_at(at, wx, wy, wz) + (_ONE - share) * numbers[PDF + k]
        value = eval_lobes_at(at, wx, wy, wz)
        _write_light(numbers, k, pdf, roughened(at, wx, wy, wz, value))


@kernel
def _weigh_hair(at, position, share, numbers, s, end):
    """The same for a point of a strand, whose rays start elsewhere; position: a triple."""
    own = chiang_at(at, _ZERO)
    shares = shares_of(at, own)
    for k in range(s, end):
        wx, wy, wz = numbers[DX + k], numbers[DY + k], numbers[DZ + k]
        if at.rough[3] == CHIANG:
            by_lobes = pdf_strand(own, shares, wx, wy, wz)
        elif at.rough[3] == TRANSLUCENT_ROUND:
            by_lobes = pdf_round_at(at, wx, wy, wz)
        else:
            by_lobes = _ALL_ALIKE
        pdf = share * by_lobes + (_ONE - share) * numbers[PDF + k]
        if at.dielectric_f0[0] > _ZERO:
            x, y, z = ray_start(at, position, wx, wy, wz)
            numbers[OX + k], numbers[OY + k], numbers[OZ + k] = x, y, z
        value = eval_strand(at, own, wx, wy, wz)
        _write_light(numbers, k, pdf, value)


@kernel
def _weigh_stretched(at, share, numbers, s, end):
    """The same for a point whose gloss is stretched, with a rough Lambert lobe or without."""
    for k in range(s, end):
        wx, wy, wz = numbers[DX + k], numbers[DY + k], numbers[DZ + k]
        pdf = share * pdf_stretched(at, wx, wy, wz) + (_ONE - share) * numbers[PDF + k]
        value = stretched(at, wx, wy, wz, eval_lobes_at(at, wx, wy, wz))
        if at.rough[3] != _ZERO:
            value = roughened(at, wx, wy, wz, value)
        _write_light(numbers, k, pdf, value)


@kernel
def _weigh_filmed(at, share, numbers, s, end):
    """The same for a point whose gloss has a film, stretched or not, and any Lambert lobe."""
    for k in range(s, end):
        wx, wy, wz = numbers[DX + k], numbers[DY + k], numbers[DZ + k]
        pdf = share * pdf_narrowest_at(at, wx, wy, wz) + (_ONE - share) * numbers[PDF + k]
        value = eval_filmed_at(at, wx, wy, wz)
        if at.narrow > _ZERO:
            value = stretched(at, wx, wy, wz, value)
        if at.rough[3] != _ZERO:
            value = roughened(at, wx, wy, wz, value)
        _write_light(numbers, k, pdf, value)


@kernel(forceinline=True)
def _weigh_run(task, share, p, lanes, s, end):
    """weigh_lanes for lanes s ... end - 1, all of point p."""
    at = lobes_at(task.lobes, p)
    if at.rough[3] > HAIR or at.fresnel[2] != ALL_ROUND:  # whose rays start beyond it
        _start_rays(task.points, p, task.offset, lanes.numbers, s, end)
    if task.points.lift_below[p] > _ZERO:
        _lift_rays(task, at, p, lanes, s, end)
    if at.kind & THIN_FILM:
        _weigh_filmed(at, share, lanes.numbers, s, end)
    elif at.narrow > _ZERO:
        _weigh_stretched(at, share, lanes.numbers, s, end)
    elif at.rough[3] <= HAIR:
        own = task.points.position
        place = own[p, 0], own[p, 1], own[p, 2]
        _weigh_hair(at, place, share, lanes.numbers, s, end)
    elif at.rough[3] != _ZERO and at.kind > 0:
        _weigh_rough(at, share, lanes.numbers, s, end)
    elif at.kind <= DIFFUSE_LOBE:
        _weigh_matte(at, share, lanes.numbers, s, end)
    elif at.kind & MEASURED_LOBE:
        _weigh_measured(at, share, lanes.numbers, s, end)
    elif at.gaussian:
        _weigh_glossy(at, True, share, lanes.numbers, s, end)
    else:
        _weigh_glossy(at, False, share, lanes.numbers, s, end)
    if at.bump > _ZERO:
        _shadow_bumps(at, lanes.numbers, s, end)


@kernel
def weigh_lanes(task, share, lanes, n):
    """Finish lanes 0 ... n - 1, but for the question who sees the light.

    share: float32, of the samples of each lane's point, those that follow the narrowest lobe
    Called once for all of them: a call hands over some 300 numbers, as many as a task has.
    """
    s = np.int64(0)
    while s < n:
        p, end = lanes.point[s], s + 1
        while end < n and lanes.point[end] == p:
            end += 1
        _weigh_run(task, share[s], p, lanes, s, end)
        s = end
