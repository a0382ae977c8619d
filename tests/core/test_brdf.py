"""The BRDF: energy, reciprocity, its textbook form, its density and its samples."""

import math

import numpy as np
import pytest

from iwis.core._jit import kernel
from iwis.core.bsdf.brdf import pdf_narrowest_at, sample_narrowest_at
from iwis.core.bsdf.lobes_at import lobes_at
from iwis.core.scene import BECKMANN, BLACK, DIFFUSE, GGX, GLOSSY, MULTI_GGX
from support.brdf_points import (
    densities,
    directions,
    evaluated,
    points,
    reflected,
    sampled,
    sphere_quadrature,
)
from support.chi2 import chi2_p_value

COSINES = (0.15, 0.5, 0.9)
# One material for each way through the kernels.
KINDS = {
    "diffuse": {"model": DIFFUSE},
    "glossy": {"model": GLOSSY},
    "beckmann": {"model": GLOSSY, "distribution": BECKMANN},
    "metal": {"metallic": 1.0, "base_color": (0.9, 0.6, 0.3), "specular_tint": (1.0, 0.5, 0.2)},
    "principled": {"distribution": MULTI_GGX},
    "both": {"metallic": 0.5, "roughness": 0.3},
}
kinds = pytest.mark.parametrize("kind", KINDS)


@pytest.mark.parametrize("cosine", COSINES)
def test_diffuse_reflects_its_color(cosine):
    """White furnace: the albedo is the color, whatever the view."""
    lobes = points(directions([cosine]), model=DIFFUSE, base_color=(0.8, 0.5, 0.1))
    assert reflected(lobes, 0)[:3] == pytest.approx([0.8, 0.5, 0.1], rel=1e-4)  # quadrature
    assert not reflected(lobes, 0)[3:].any()


@pytest.mark.parametrize("roughness", (0.3, 0.5, 0.8, 1.0))
@pytest.mark.parametrize("cosine", COSINES)
def test_white_multiscatter_metal_loses_nothing(roughness, cosine):
    """White furnace: 1 leaves; 4e-3 for the table, which is linear between 32 points."""
    lobes = points(directions([cosine]), metallic=1.0, distribution=MULTI_GGX, roughness=roughness)
    assert reflected(lobes, 0)[3:] == pytest.approx([1.0] * 3, abs=4e-3)


@kinds
@pytest.mark.parametrize("cosine", COSINES)
def test_no_surface_makes_light(kind, cosine):
    """White furnace: less than 1 leaves, but for the table's linear interpolation."""
    total = reflected(points(directions([cosine]), **KINDS[kind]), 0)
    assert (total[:3] + total[3:] <= 1.004).all()


@pytest.mark.parametrize("kind", ["diffuse", "glossy", "beckmann", "metal"])
def test_brdf_is_reciprocal(kind, rng):
    """Swapping light and eye changes nothing. (Layers and multiscattering do not hold this.)"""
    v = rng.normal(size=(2, 50, 3))
    v[..., 2] = np.abs(v[..., 2]) + 0.1
    a, b = (v / np.linalg.norm(v, axis=-1, keepdims=True)).astype(np.float32)
    there, back = points(a, **KINDS[kind]), points(b, **KINDS[kind])
    for p in range(50):
        forward = evaluated(there, p, b[p : p + 1])[0] / b[p, 2]
        backward = evaluated(back, p, a[p : p + 1])[0] / a[p, 2]
        assert forward == pytest.approx(backward, rel=2e-5)  # float32


def textbook_ggx(wo, wi, alpha, f0, ior):
    """float64 brdf * cos of a dielectric's surface, term by term as in [Walter07], [Heitz14]."""
    h = wo + wi
    h /= np.linalg.norm(h)
    theta = math.acos(min(h[2], 1.0))
    d = alpha**2 / (math.pi * (math.cos(theta) ** 2 * (alpha**2 + math.tan(theta) ** 2)) ** 2)

    def smith(w):
        return (math.sqrt(1 + alpha**2 * (1 / w[2] ** 2 - 1)) - 1) / 2

    def fresnel(c):
        t = math.sqrt(1 - (1 - c * c) / ior**2)
        s, p = (c - ior * t) / (c + ior * t), (t - ior * c) / (t + ior * c)
        return (s * s + p * p) / 2

    blend = (fresnel(wo @ h) - fresnel(1.0)) / (1 - fresnel(1.0))
    return d * (f0 + (1 - f0) * blend) / (4 * wo[2] * (1 + smith(wo) + smith(wi)))


@pytest.mark.parametrize("roughness", (0.05, 0.3, 1.0))
@pytest.mark.parametrize("ior", (1.1, 1.5, 2.5))
def test_gloss_is_the_textbook_formula(roughness, ior, rng):
    """The float32 kernel, short cuts and all, is the formula in float64."""
    v = rng.normal(size=(40, 3))
    v[:, 2] = np.abs(v[:, 2]) + 0.05
    wi = (v / np.linalg.norm(v, axis=1, keepdims=True)).astype(np.float32)
    wo = directions([0.6])
    wi[:10] = wo * [-1, 1, 1] + 0.02 * wi[:10]  # where a sharp lobe is
    wi /= np.linalg.norm(wi, axis=1, keepdims=True)
    lobes = points(wo, roughness=roughness, ior=ior, base_color=(0.0, 0.0, 0.0))
    f0 = ((ior - 1) / (ior + 1)) ** 2
    got = evaluated(lobes, 0, wi)[:, 3]
    wanted = [textbook_ggx(np.float64(wo[0]), np.float64(w), roughness**2, f0, ior) for w in wi]
    # The density of a lobe of width .0025 turns the last bit of a direction into 1e-4.
    assert got == pytest.approx(wanted, rel=1e-3 if roughness < 0.1 else 3e-5)


@kinds
@pytest.mark.parametrize("cosine", (0.4, 0.9))
def test_density_integrates_to_one(kind, cosine):
    """Over the sphere: what facets mirror to below the horizon is counted."""
    lobes = points(directions([cosine]), **KINDS[kind])
    wi, solid_angle = sphere_quadrature(256, 512)
    # Beckmann's has a pole at wi = -wo: the quadrature's error halves with each finer grid.
    tolerance = 5e-3 if kind == "beckmann" else 1e-3
    total = densities(lobes, 0, wi).astype(np.float64) @ solid_angle
    assert total == pytest.approx(1.0, abs=tolerance)


def _binned(wi, weights, n=24):
    """Sums of weights over cells of cos and phi."""
    cells, _, _ = np.histogram2d(
        wi[:, 2], np.arctan2(wi[:, 1], wi[:, 0]), n, ((-1, 1), (-np.pi, np.pi)), weights=weights
    )
    return cells


def _cell_chances(lobes, n=24, sub=24):
    """Probability of each of n x n cells of cos and phi: the mean of sub x sub densities."""
    z = (np.arange(n * sub) + 0.5) / (n * sub) * 2 - 1
    phi = ((np.arange(n * sub) + 0.5) / (n * sub) * 2 - 1) * np.pi
    r = np.sqrt(1 - z * z)[:, None]
    wi = np.stack([r * np.cos(phi), r * np.sin(phi), np.repeat(z[:, None], n * sub, 1)], -1)
    pdf = densities(lobes, 0, wi.reshape(-1, 3).astype(np.float32)).astype(np.float64)
    return pdf.reshape(n, sub, n, sub).mean(axis=(1, 3)) * (4 * np.pi / n**2)


# 1e-3 for the file, over six kinds [Sidak].
ALPHA = 1 - (1 - 1e-3) ** (1 / len(KINDS))


@pytest.mark.statistical
@kinds
def test_samples_follow_their_density(kind, rng):
    """chi^2 of 200 000 directions from independent numbers; a density 5 % off is rejected."""
    lobes = points(directions([0.6]), **KINDS[kind])
    n = 200_000
    wi, pdf = sampled(lobes, 0, rng.random((n, 2)))
    assert (pdf > 0.0).all()
    observed, chances = _binned(wi, None), _cell_chances(lobes)
    assert chi2_p_value(observed, n * chances) > ALPHA
    tilt = 1 + 0.05 * np.sign(np.arange(24) - 11.5)  # 5 % more on one side of the plane y = 0
    wrong = chances * tilt
    assert chi2_p_value(observed, n * wrong / wrong.sum()) < ALPHA


@pytest.mark.statistical
@kinds
def test_weighted_samples_give_the_albedo(kind, rng):
    """The mean of f cos / pdf is the integral: within four standard errors (alpha 6e-5)."""
    lobes = points(directions([0.3]), **KINDS[kind])
    wi, pdf = sampled(lobes, 0, rng.random((100_000, 2)))
    value = evaluated(lobes, 0, wi).astype(np.float64)
    value = (value[:, :3] + value[:, 3:]) / pdf[:, None]
    integral = reflected(lobes, 0)
    spread = value.std(axis=0) / math.sqrt(len(value))
    assert (np.abs(value.mean(axis=0) - integral[:3] - integral[3:]) < 4 * spread + 1e-4).all()


@pytest.mark.parametrize("distribution", (GGX, MULTI_GGX, BECKMANN))
def test_polished_surface_is_a_mirror(distribution, rng):
    """Roughness 0: samples go where a mirror sends them, weigh 1, and nothing overflows."""
    wo = directions([0.4])
    lobes = points(wo, model=GLOSSY, roughness=0.0, distribution=distribution)
    wi, pdf = sampled(lobes, 0, rng.random((1000, 2)))
    away = np.linalg.norm(wi - wo * [-1, 1, 1], axis=1)
    assert np.median(away) < 4e-4  # twice the width of the lobe
    weight = evaluated(lobes, 0, wi)[:, 3] / pdf
    assert np.isfinite(weight).all()
    assert weight.mean() == pytest.approx(1.0, abs=1e-3)  # rounding of wi, its square in D


def test_black_reflects_nothing():
    """An emitter has no lobes, no density, and its radiance."""
    lobes = points(directions([0.5]), model=BLACK, emission=(1.0, 2.0, 3.0))
    assert lobes.kind[0] == 0 and not reflected(lobes, 0).any()
    assert sampled(lobes, 0, [[0.5, 0.5]])[1][0] == 0.0
    assert lobes.emission[0].tolist() == [1.0, 2.0, 3.0]


@kinds
def test_nothing_from_below_the_horizon(kind):
    """wi below the shading normal's plane brings no light; on it, and grazing, all is finite."""
    lobes = points(directions([1e-4, 0.5]), **KINDS[kind])
    below, _ = sphere_quadrature(16, 16)
    below = np.ascontiguousarray(below[below[:, 2] < 0])
    for p in range(2):
        assert not evaluated(lobes, p, below).any()
        assert np.isfinite(evaluated(lobes, p, directions([0.0, 1e-7, 1e-4, 1.0]))).all()


@kernel
def _narrowest(lobes, u, out):
    at = lobes_at(lobes, 0)
    for k in range(len(u)):
        x, y, z = sample_narrowest_at(at, u[k, 0], u[k, 1])
        out[k, 0], out[k, 1], out[k, 2] = x, y, z
        out[k, 3] = pdf_narrowest_at(at, x, y, z)


@kinds
def test_narrowest_lobe_is_the_gloss_alone(kind, rng):
    """The same directions and densities as if the Lambert lobe had no share: exactly."""
    lobes = points(directions([0.6]), **KINDS[kind])
    u, narrowest = rng.random((500, 2)).astype(np.float32), np.empty((500, 4), np.float32)
    _narrowest(lobes, u, narrowest)
    if kind != "diffuse":
        lobes.diffuse_share[:] = 0.0
    wi, pdf = sampled(lobes, 0, u)
    np.testing.assert_allclose(narrowest[:, :3], wi, atol=1e-6)  # float32, other order
    np.testing.assert_allclose(narrowest[:, 3], pdf, rtol=1e-4)  # sharp lobe: 1e-6 of direction


def test_rough_diffuse_of_white_loses_nothing():
    """White furnace: the later bounces make up; 2e-3: OpenPBR's rounded mean."""
    for cosine in COSINES:
        lobes = points(directions([cosine]), model=DIFFUSE, diffuse_roughness=1.0)
        assert reflected(lobes, 0)[:3] == pytest.approx([1.0] * 3, abs=2e-3)
