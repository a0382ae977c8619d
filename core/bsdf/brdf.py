"""The BRDF of a shading point, sample by sample: its value, its density, a direction.

Called once a sample: float32 throughout, and a point without gloss leaves after one dot product.
eval_at, pdf_at and sample_at want a point that lobes_at has loaded, for all samples of that point;
eval_brdf_cos loads it itself, which adds 5 to 8 ns.

wi and wo are unit, world space, away from the surface. wi below the horizon of the *geometric*
normal is not rejected here: whoever traces the shadow ray does that.
"""

import math

import numpy as np

from .._jit import kernel
from .bump import bump_gain
from .hair import eval_hair
from .lambert_kinds import HAIR, MICROFIBER
from .lobes import (
    CONDUCTOR_LOBE,
    DIELECTRIC_LOBE,
    DIFFUSE_LOBE,
    MEASURED_LOBE,
    THIN_FILM,
)
from .lobes_at import lobes_at
from .merl import eval_measured_at
from .microfacet import (
    FOUR,
    HALF,
    INV_PI,
    ONE,
    PI,
    QUARTER,
    TWO,
    ZERO,
    basis,
    beckmann_d,
    beckmann_lambda,
    cross,
    dielectric_blend,
    dot_xyz,
    f82_curve,
    ggx_d,
    ggx_lambda,
    half_vector,
    sample_beckmann_normal,
    sample_ggx_visible_normal,
    schlick_weight,
    to_world,
)
from .rough_diffuse import roughened
from .sheen import pdf_microfiber, sample_microfiber
from .stretched import pdf_stretched, stretched
from .thin_film import film_color
from .toon import is_toon, pdf_toon, sample_toon

_TINY = np.float32(1e-12)
_ALMOST_ONE = np.float32(1.0 - 2.0**-24)


@kernel(forceinline=True)
def _half_angles(at, wi_x, wi_y, wi_z):
    """(sine squared of the angle between h and the glossy normal, their cosine, wo . h)."""
    hx, hy, hz, cos_h = half_vector(at.wo, wi_x, wi_y, wi_z)
    # By the chord between both unit vectors: 1 - cos^2 has no digits left where the lobe is sharp.
    m = at.glossy_normal
    dx, dy, dz = hx - m[0], hy - m[1], hz - m[2]
    chord2 = dx * dx + dy * dy + dz * dz
    return max(chord2 * (ONE - QUARTER * chord2), ZERO), ONE - HALF * chord2, cos_h


@kernel(forceinline=True)
def eval_at(at, wi_x, wi_y, wi_z):
    """The BRDF times the cosine of wi: (r, g, b) of the Lambert lobe, then (r, g, b) of the gloss.

    at: LobesAt; wi_x, wi_y, wi_z: float32
    """
    if at.kind & MEASURED_LOBE:
        value = eval_measured_at(at, wi_x, wi_y, wi_z)
    elif at.rough[3] <= HAIR:
        return eval_hair(at, wi_x, wi_y, wi_z)
    else:
        if at.kind & THIN_FILM:
            value = eval_filmed_at(at, wi_x, wi_y, wi_z)
        else:
            value = eval_lobes_at(at, wi_x, wi_y, wi_z)
        if at.narrow > ZERO:
            value = stretched(at, wi_x, wi_y, wi_z, value)
        if at.rough[3] != ZERO:
            value = roughened(at, wi_x, wi_y, wi_z, value)
    if at.bump == ZERO:
        return value
    dr, dg, db, gr, gg, gb = value
    matte = bump_gain(at, wi_x, wi_y, wi_z)
    return dr * matte, dg * matte, db * matte, gr, gg, gb


@kernel(forceinline=True)
def eval_lobes_at(at, wi_x, wi_y, wi_z):
    """eval_at of a point neither measured, rough, stretched, filmed nor bumped: fewer branches."""
    return eval_facets_at(at, at.gaussian, wi_x, wi_y, wi_z)


@kernel(forceinline=True)
def eval_filmed_at(at, wi_x, wi_y, wi_z):
    """eval_lobes_at of a point whose gloss has a film: at.kind & THIN_FILM."""
    cos_n = max(dot_xyz(at.normal, wi_x, wi_y, wi_z), ZERO)
    scale = cos_n * INV_PI
    dr, dg, db = at.diffuse[0] * scale, at.diffuse[1] * scale, at.diffuse[2] * scale
    cos_i = dot_xyz(at.glossy_normal, wi_x, wi_y, wi_z)
    if cos_i <= ZERO or (cos_n <= ZERO and at.bump == ZERO):
        return dr, dg, db, ZERO, ZERO, ZERO
    scale, cos_h = _facet_light(at, at.gaussian, cos_i, wi_x, wi_y, wi_z)
    dielectric = at.dielectric_weight, at.dielectric_f0, at.fresnel
    conductor = at.conductor_weight, at.conductor_f0, at.edge
    r, g, b = film_color(at.kind, at.tint, dielectric, conductor, cos_h)
    return dr, dg, db, r * scale, g * scale, b * scale


@kernel(forceinline=True)
def _facet_light(at, gaussian, cos_i, wi_x, wi_y, wi_z):
    """(the BRDF times the cosine of wi of facets that reflect all, wo . h)."""
    sin2, _, cos_h = _half_angles(at, wi_x, wi_y, wi_z)
    alpha2 = at.alpha * at.alpha
    if gaussian:
        density, hidden = beckmann_d(alpha2, sin2), beckmann_lambda(alpha2, cos_i)
    else:
        density, hidden = ggx_d(alpha2, sin2), ggx_lambda(alpha2, cos_i)
    return density / (FOUR * at.cos_o * (at.seen + hidden)), cos_h


@kernel(forceinline=True)
def eval_facets_at(at, gaussian, wi_x, wi_y, wi_z):
    """eval_lobes_at, for a caller that knows at.gaussian."""
    cos_n = max(dot_xyz(at.normal, wi_x, wi_y, wi_z), ZERO)
    scale = cos_n * INV_PI
    dr, dg, db = at.diffuse[0] * scale, at.diffuse[1] * scale, at.diffuse[2] * scale
    if at.kind <= DIFFUSE_LOBE:
        return dr, dg, db, ZERO, ZERO, ZERO
    cos_i = dot_xyz(at.glossy_normal, wi_x, wi_y, wi_z)
    # A map may turn the normal so far that gloss, whose normal is turned back, lies below it.
    if cos_i <= ZERO or (cos_n <= ZERO and at.bump == ZERO):
        return dr, dg, db, ZERO, ZERO, ZERO
    scale, cos_h = _facet_light(at, gaussian, cos_i, wi_x, wi_y, wi_z)
    gr = gg = gb = ZERO
    if at.kind & DIELECTRIC_LOBE:
        w, f0 = at.dielectric_weight, at.dielectric_f0
        s = dielectric_blend(cos_h, at.fresnel[0], at.fresnel[1], at.fresnel[2])
        gr = w[0] * (f0[0] + (ONE - f0[0]) * s)
        gg = w[1] * (f0[1] + (ONE - f0[1]) * s)
        gb = w[2] * (f0[2] + (ONE - f0[2]) * s)
    if at.kind & CONDUCTOR_LOBE:
        w, f0, edge = at.conductor_weight, at.conductor_f0, at.edge
        s = schlick_weight(cos_h)
        t = cos_h * s * (ONE - cos_h)
        gr += w[0] * f82_curve(f0[0], edge[0], s, t)
        gg += w[1] * f82_curve(f0[1], edge[1], s, t)
        gb += w[2] * f82_curve(f0[2], edge[2], s, t)
    return dr, dg, db, gr * scale, gg * scale, gb * scale


@kernel(forceinline=True)
def pdf_facets_at(at, gaussian, wi_x, wi_y, wi_z):
    """The density of the glossy lobe, sr^-1, for a caller that knows at.gaussian."""
    sin2, cos_m, cos_h = _half_angles(at, wi_x, wi_y, wi_z)
    alpha2 = at.alpha * at.alpha
    if gaussian:  # facets turned away from wo are taken as well: their h points down
        return beckmann_d(alpha2, sin2) * abs(cos_m) / (FOUR * cos_h)
    if cos_m > ZERO:
        return ggx_d(alpha2, sin2) / (FOUR * at.cos_o * at.seen)
    return ZERO


@kernel(forceinline=True)
def pdf_at(at, wi_x, wi_y, wi_z):
    """The density of sample_at, sr^-1. Its integral over the *sphere* is 1.

    Facets mirror some samples to below the horizon, where the BRDF is 0: they are counted.
    """
    if at.kind == 0:
        return ZERO
    cos_n = dot_xyz(at.normal, wi_x, wi_y, wi_z)
    pdf = at.diffuse_share * max(cos_n, ZERO) * INV_PI
    if at.kind == DIFFUSE_LOBE:
        return pdf
    return pdf + (ONE - at.diffuse_share) * pdf_narrowest_at(at, wi_x, wi_y, wi_z)


@kernel(forceinline=True)
def pdf_narrowest_at(at, wi_x, wi_y, wi_z):
    """The density of sample_narrowest_at, sr^-1; at.kind must not be 0."""
    if at.narrow > ZERO:
        return pdf_stretched(at, wi_x, wi_y, wi_z)
    if at.rough[3] < ZERO:
        if at.rough[3] == MICROFIBER:
            return pdf_microfiber(at, wi_x, wi_y, wi_z)
        if is_toon(at.rough):
            return pdf_toon(at, wi_x, wi_y, wi_z)
    return pdf_round_at(at, wi_x, wi_y, wi_z)


@kernel(forceinline=True)
def pdf_round_at(at, wi_x, wi_y, wi_z):
    """pdf_narrowest_at of a point that is neither stretched, sheen nor toon."""
    if at.kind == DIFFUSE_LOBE:
        return max(dot_xyz(at.normal, wi_x, wi_y, wi_z), ZERO) * INV_PI
    return pdf_facets_at(at, at.gaussian, wi_x, wi_y, wi_z)


@kernel(forceinline=True)
def sample_at(at, u1, u2):
    """A direction and its density: (wi_x, wi_y, wi_z, pdf); u1, u2: float32 in [0, 1).

    wi may be below the horizon (the BRDF is 0 there). pdf is 0 only where nothing reflects.
    """
    share = at.diffuse_share
    if at.kind == 0:
        x, y, z = at.normal
    elif u1 < share:
        x, y, z = _sample_lambert(at, min(u1 / share, _ALMOST_ONE), u2)
    else:
        x, y, z = _sample_gloss(at, min((u1 - share) / (ONE - share), _ALMOST_ONE), u2)
    return x, y, z, pdf_at(at, x, y, z)


@kernel(forceinline=True)
def sample_narrowest_at(at, u1, u2):
    """A direction by the glossy lobe, where there is none by the other one: (x, y, z)."""
    if at.rough[3] < ZERO:
        if at.rough[3] == MICROFIBER:
            return sample_microfiber(at, u1, u2)
        if is_toon(at.rough):
            return sample_toon(at, u1, u2)
    if at.kind == DIFFUSE_LOBE:
        return _sample_lambert(at, u1, u2)
    return _sample_gloss(at, u1, u2)


@kernel(forceinline=True)
def _sample_lambert(at, u1, u2):
    """A direction with density cos / pi."""
    s, t = basis(at.normal)
    phi = TWO * PI * u2
    r = math.sqrt(u1)
    z = math.sqrt(max(ONE - u1, _TINY))
    return to_world(s, t, at.normal, r * math.cos(phi), r * math.sin(phi), z)


@kernel(forceinline=True)
def _sample_gloss(at, u1, u2):
    """wo, mirrored by a facet."""
    wo = at.wo
    s, t = basis(at.glossy_normal)
    across = at.alpha
    if at.narrow > ZERO:
        s, t, across = at.tangent, cross(at.glossy_normal, at.tangent), at.narrow
    if at.gaussian:
        x, y, z = sample_beckmann_normal(at.alpha, across, u1, u2)
    else:
        wo_x, wo_y = dot_xyz(wo, s[0], s[1], s[2]), dot_xyz(wo, t[0], t[1], t[2])
        x, y, z = sample_ggx_visible_normal(wo_x, wo_y, at.cos_o, at.alpha, across, u1, u2)
    hx, hy, hz = to_world(s, t, at.glossy_normal, x, y, z)
    twice = TWO * dot_xyz(wo, hx, hy, hz)
    return twice * hx - wo[0], twice * hy - wo[1], twice * hz - wo[2]


@kernel(forceinline=True)
def power_heuristic(own, other):
    """Share of a sample that another kind of samples has too [Veach95]. Both: expected densities"""
    own, other = own * own, other * other
    return own / (own + other)


@kernel(forceinline=True)
def eval_brdf_cos(lobes, p, wi_x, wi_y, wi_z):
    """eval_at of row p."""
    return eval_at(lobes_at(lobes, p), wi_x, wi_y, wi_z)
