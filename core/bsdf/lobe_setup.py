"""From a material's parameters to its lobes at a shading point.

The model is Cycles' (4.5 and 5.2 agree): a Lambert lobe under one microsurface. That surface
reflects by up to two Fresnel curves, for Principled gives its dielectric layer and its metal one
roughness and one normal. The layers share the light as in Cycles: by the metallic weight, and what
is under the dielectric gets what that leaves over on average (albedo_tables). MULTI_GGX makes up
for the light that is lost between facets [Kulla17].
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from ..scene import (
    BECKMANN,
    DIFFUSE,
    FIT_ALBEDO,
    FIT_ALPHA,
    FIT_ANGLES,
    FIT_DIFFUSE,
    FIT_WEIGHT,
    GGX,
    GLOSSY,
    MEASURED,
    MULTI_GGX,
    NO_MEASURED,
    PRINCIPLED,
    MaterialParams,
    MeasuredBrdfs,
)
from .albedo_tables import albedo_tables, read_1d, read_2d, read_3d
from .glossy_normal import set_glossy_normal
from .lobes import (
    CONDUCTOR,
    CONDUCTOR_LOBE,
    DIELECTRIC,
    DIELECTRIC_LOBE,
    DIFFUSE_LOBE,
    MEASURED_LOBE,
    Lobes,
)
from .luminance import luminance
from .microfacet import (
    HALF,
    MIN_ALPHA,
    ONE,
    TWO,
    ZERO,
    beckmann_lambda,
    dielectric_mean,
    dot,
    f0_of_ior,
    f82_edge,
    f82_mean,
    ggx_lambda,
    ior_of_f0,
)
from .rough_diffuse import set_rough

METAL_CUTOFF = np.float32(1e-5)  # Cycles leaves out metal that weighs less
_LEAST_IOR = np.float32(1e-5)


def setup_lobes(
    params: MaterialParams,
    normal: np.ndarray,
    geometric_normal: np.ndarray,
    wo: np.ndarray,
    measured: MeasuredBrdfs = NO_MEASURED,
    as_turned: np.ndarray | None = None,
) -> Lobes:
    """The lobes of n points.

    params: one row a point
    normal, geometric_normal: float32 (n, 3), unit, both on the mesh's own front side: where that is
        turned away from wo they are flipped here, for reflection is two-sided
    wo: float32 (n, 3), unit, to the viewer
    measured: of the scene
    as_turned: bool (n,), where glossy light follows the normal wherever it points (glossy_normal);
        None: nowhere
    """
    n = len(normal)
    shapes = {"weight": (n, 2, 3), "f0": (n, 2, 3), "rough": (n, 4)}
    shapes |= dict.fromkeys(("alpha", "narrow", "cos_o", "seen", "diffuse_share", "bump"), (n,))
    out = {name: np.zeros(shapes.get(name, (n, 3)), np.float32) for name in Lobes._fields}
    out |= {name: np.zeros(n, np.int8) for name in ("kind", "distribution")}
    out |= {"table": np.zeros(n, np.int32), "tables": measured.values}
    lobes = Lobes(**out)
    if as_turned is None:
        as_turned = np.zeros(n, np.bool_)
    given = params, normal, geometric_normal, wo, as_turned
    _setup(*given, albedo_tables(), measured.fit, lobes)
    return lobes


@kernel
def _setup(params, normal, geometric_normal, wo, as_turned, tables, fits, out):
    for p in range(normal.shape[0]):
        facing = np.float32(1.0 if dot(geometric_normal[p], wo[p]) >= ZERO else -1.0)
        for c in range(3):
            out.normal[p, c] = normal[p, c] * facing
            out.wo[p, c] = wo[p, c]
            out.emission[p, c] = params.emission[p, c]
        set_glossy_normal(geometric_normal[p], facing, as_turned[p], p, out)
        _set_microsurface(params, p, out)
        model = params.model[p]
        if model == DIFFUSE:
            for c in range(3):
                out.diffuse[p, c] = max(params.base_color[p, c], ZERO)
        elif model == PRINCIPLED:
            rest = _add_metal(params, p, tables, out)
            _add_dielectric(params, p, rest, tables, out)
        elif model == GLOSSY:
            _add_mirror(params, p, tables, out)
        elif model == MEASURED:
            _add_measured(params, p, fits, out)
        if model == DIFFUSE or model == PRINCIPLED:
            set_rough(params, p, dot(out.normal[p], wo[p]), out)
        set_kind(p, out)
        if model == MEASURED and out.kind[p] != 0 and out.cos_o[p] > ZERO:
            out.kind[p] |= MEASURED_LOBE


@kernel(forceinline=True)
def _clip(x):
    return min(max(x, ZERO), ONE)


@kernel
def _set_microsurface(params, p, out):
    roughness = _clip(params.roughness[p])
    distribution = GGX if params.model[p] == MEASURED else params.distribution[p]
    _set_width(max(roughness * roughness, MIN_ALPHA), distribution, p, out)


@kernel
def _set_width(alpha, distribution, p, out):
    out.alpha[p] = alpha
    out.distribution[p] = distribution
    out.seen[p] = ONE
    if out.cos_o[p] > ZERO:
        if distribution == BECKMANN:
            out.seen[p] += beckmann_lambda(alpha * alpha, out.cos_o[p])
        else:
            out.seen[p] += ggx_lambda(alpha * alpha, out.cos_o[p])


@kernel
def facet_albedos(params, p, tables, cos_o):
    """Share of light that leaves at the first facet, for this wo and on average; 1, 1 if all."""
    if params.distribution[p] != MULTI_GGX:
        return ONE, ONE
    roughness = _clip(params.roughness[p])
    return read_2d(tables.albedo, cos_o, roughness), read_1d(tables.mean_albedo, roughness)


@kernel(forceinline=True)
def later_gain(albedo, mean_albedo, fresnel_mean):
    """The factor that brings the later bounces between facets back [Kulla17]."""
    later = fresnel_mean * mean_albedo / (ONE - fresnel_mean * (ONE - mean_albedo))
    return ONE + later * (ONE - albedo) / albedo


@kernel
def _add_metal(params, p, tables, out):
    """Write the metal's curve; what it leaves over of the light is returned."""
    metallic = _clip(params.metallic[p])
    if metallic <= METAL_CUTOFF:
        return ONE
    cos_o = out.cos_o[p]
    albedo, mean_albedo = facet_albedos(params, p, tables, cos_o)
    blend = read_2d(tables.metal, cos_o, _clip(params.roughness[p]))
    for c in range(3):
        f0 = _clip(params.base_color[p, c])
        edge = f82_edge(f0, _clip(params.specular_tint[p, c]))
        gain = later_gain(albedo, mean_albedo, f82_mean(f0, edge))
        out.f0[p, CONDUCTOR, c] = f0
        out.edge[p, c] = edge
        out.weight[p, CONDUCTOR, c] = metallic * gain
        out.glossy_color[p, c] += metallic * gain * albedo * (f0 + (ONE - f0) * blend)
    return ONE - metallic


@kernel
def _dielectric_index(params, p):
    """Index of refraction, and reflectance along the normal: the specular level is in both."""
    eta = max(params.ior[p], _LEAST_IOR)
    f0 = f0_of_ior(eta)
    level = max(params.specular_level[p], ZERO)
    if level != HALF:
        f0 *= TWO * level
        scaled = ior_of_f0(f0)
        eta = ONE / scaled if eta < ONE else scaled
    return eta, f0


@kernel
def _add_dielectric(params, p, rest, tables, out):
    """Write the layer over the Lambert lobe and that lobe; rest: light that is left for both."""
    eta, f0 = _dielectric_index(params, p)
    layer = ZERO  # of the light, the share that does not pass: that of the most reflective channel
    if eta != ONE:
        cos_o = out.cos_o[p]
        albedo, mean_albedo = facet_albedos(params, p, tables, cos_o)
        f0_real = f0_of_ior(eta)
        index = math.sqrt(abs((eta - ONE) / (eta + ONE)))
        blend = read_3d(tables.dielectric, index, cos_o, _clip(params.roughness[p]))
        blend_mean = _clip((dielectric_mean(eta) - f0_real) / (ONE - f0_real))
        out.fresnel[p, 0] = eta * eta - ONE
        out.fresnel[p, 1] = f0_real
        out.fresnel[p, 2] = ONE / (ONE - f0_real)
        for c in range(3):
            f0_c = _clip(f0 * max(params.specular_tint[p, c], ZERO))
            gain = later_gain(albedo, mean_albedo, f0_c + (ONE - f0_c) * blend_mean)
            color = gain * albedo * (f0_c + (ONE - f0_c) * blend)
            out.f0[p, DIELECTRIC, c] = f0_c
            out.weight[p, DIELECTRIC, c] = rest * gain
            out.glossy_color[p, c] += rest * color
            layer = max(layer, color)
    for c in range(3):
        out.diffuse[p, c] = max(params.base_color[p, c], ZERO) * rest * _clip(ONE - layer)


@kernel
def _add_mirror(params, p, tables, out):
    """Write a curve that reflects all, times the color: the Glossy BSDF."""
    albedo, mean_albedo = facet_albedos(params, p, tables, out.cos_o[p])
    for c in range(3):
        color = max(params.base_color[p, c], ZERO)
        gain = later_gain(albedo, mean_albedo, color)
        out.f0[p, CONDUCTOR, c] = ONE
        out.weight[p, CONDUCTOR, c] = color * gain
        out.glossy_color[p, c] = color * gain * albedo


@kernel
def _add_measured(params, p, fits, out):
    """Write the lobes that are fitted to a measured BRDF for this wo, its tint and its table."""
    row = np.int64(params.distribution[p])
    x = _clip(out.cos_o[p]) * np.float32(FIT_ANGLES - 1)
    k = min(int(x), FIT_ANGLES - 2)
    f = x - np.float32(k)
    low, high = fits[row, k], fits[row, k + 1]
    alpha = low[FIT_ALPHA] + f * (high[FIT_ALPHA] - low[FIT_ALPHA])
    weight = low[FIT_WEIGHT] + f * (high[FIT_WEIGHT] - low[FIT_WEIGHT])
    _set_width(alpha, GGX, p, out)
    out.table[p] = row
    for c in range(3):
        tint = max(params.base_color[p, c], ZERO)
        i, j = FIT_ALBEDO + c, FIT_DIFFUSE + c
        diffuse = low[j] + f * (high[j] - low[j])
        albedo = low[i] + f * (high[i] - low[i])
        out.tint[p, c] = tint
        out.diffuse[p, c] = tint * diffuse
        # Never 0: the pass that is divided by it holds all light beyond the Lambert lobe's.
        out.glossy_color[p, c] = tint * max(albedo - diffuse, np.float32(1e-3))
        out.f0[p, CONDUCTOR, c] = ONE
        out.weight[p, CONDUCTOR, c] = tint * weight


@kernel
def set_kind(p, out):
    """Write which lobes are there, and how often each is sampled: by what it reflects in all."""
    kind = 0
    if max(out.diffuse[p, 0], out.diffuse[p, 1], out.diffuse[p, 2]) > ZERO:
        kind |= DIFFUSE_LOBE
    if out.cos_o[p] > ZERO:
        for row, bit in ((DIELECTRIC, DIELECTRIC_LOBE), (CONDUCTOR, CONDUCTOR_LOBE)):
            w = out.weight[p, row]
            if max(w[0], w[1], w[2]) > ZERO:
                kind |= bit
    out.kind[p] = kind
    d, g = out.diffuse[p], out.glossy_color[p]
    diffuse, glossy = luminance(d[0], d[1], d[2]), luminance(g[0], g[1], g[2])
    if kind == DIFFUSE_LOBE:
        out.diffuse_share[p] = ONE
    elif kind & DIFFUSE_LOBE:
        # A glossy lobe may be far brighter than its estimate in some direction: never starve it.
        out.diffuse_share[p] = min(diffuse / (diffuse + glossy), np.float32(0.9))
