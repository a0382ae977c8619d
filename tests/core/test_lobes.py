"""Lobes of shading points: normals, layers, the tables below them."""

import numpy as np
import pytest

from iwis.core.bsdf.albedo_tables import albedo_tables
from iwis.core.bsdf.lobes import CONDUCTOR_LOBE, DIELECTRIC_LOBE, DIFFUSE_LOBE
from iwis.core.scene import DIFFUSE, GLOSSY, MULTI_GGX
from support.brdf_points import densities, directions, evaluated, points, sphere_quadrature


def unit(v):
    return (v / np.linalg.norm(v, axis=-1, keepdims=True)).astype(np.float32)


def test_back_side_is_the_front_seen_from_behind():
    """Normals turn to the viewer: a surface reflects on both sides alike."""
    wo = unit(np.float64([[0.3, 0.2, 0.8]]))
    front, back = points(wo), points(wo, normal=[[0, 0, -1]])
    for name in front._fields:
        assert np.array_equal(getattr(front, name), getattr(back, name)), name


def test_glossy_normal_lets_the_mirrored_view_out(rng):
    """It is the shading normal where that will do, else turned just far enough in their plane."""
    n = 2000
    geometric = unit(rng.normal(size=(n, 3)))
    wo = unit(rng.normal(size=(n, 3)))
    wo *= np.sign((wo * geometric).sum(1, keepdims=True))
    normal = unit(geometric + 0.7 * unit(rng.normal(size=(n, 3))))
    lobes = points(wo, normal, geometric, model=GLOSSY)
    up, g = (wo * geometric).sum(1), lobes.glossy_normal
    mirrored = 2 * (wo * g).sum(1, keepdims=True) * g - wo
    height = np.minimum(0.9 * up, 0.01)
    above = (mirrored * geometric).sum(1)
    assert (above > height - 2e-6).all()  # float32
    kept = (g == normal).all(1)
    assert 0.5 < kept.mean() < 0.99
    assert above[~kept] == pytest.approx(height[~kept], abs=2e-6)
    assert np.linalg.norm(g, axis=1) == pytest.approx(np.ones(n), abs=1e-6)
    volume = np.linalg.det(np.stack([g, normal, geometric], 1))
    assert volume == pytest.approx(np.zeros(n), abs=1e-6)


def test_lobes_are_those_of_the_model():
    """What a material cannot do costs no sample anything."""
    wo = directions([0.7])
    cases = {
        DIFFUSE_LOBE: {"model": DIFFUSE},
        CONDUCTOR_LOBE: {"metallic": 1.0},
        DIFFUSE_LOBE | DIELECTRIC_LOBE: {},
        DIFFUSE_LOBE | DIELECTRIC_LOBE | CONDUCTOR_LOBE: {"metallic": 0.5},
        DIELECTRIC_LOBE: {"base_color": (0.0, 0.0, 0.0)},
    }
    for kind, values in cases.items():
        assert points(wo, **values).kind[0] == kind, values
    for values in ({"ior": 1.0}, {"specular_level": 0.0}):
        assert points(wo, **values).kind[0] == DIFFUSE_LOBE
        assert points(wo, base_color=(0.8, 0.8, 0.8), **values).diffuse[0, 0] == np.float32(0.8)


def test_a_specular_level_leaves_an_index_on_its_side_of_1():
    """What is seen from the denser side still has its critical angle: eta^2 - 1 is below 0."""
    wo = directions([0.7])
    for level in (0.2, 0.5, 0.8):
        assert points(wo, ior=0.7, specular_level=level).fresnel[0, 0] < 0.0
        assert points(wo, ior=1.4, specular_level=level).fresnel[0, 0] > 0.0


def test_viewer_behind_a_glossy_normal_sees_no_gloss():
    """A view along the surface has no facets to see; nothing is divided by its cosine."""
    lobes = points([[1.0, 0.0, 0.0]], metallic=0.5)
    assert lobes.kind[0] == DIFFUSE_LOBE
    assert all(np.isfinite(array).all() for array in lobes)


@pytest.mark.parametrize(("x", "y"), [(31, 31), (31, 8), (16, 5), (12, 20)])
def test_albedo_table_is_the_integral(x, y):
    """An entry is the furnace's albedo of facets that reflect all; 5e-4: the table's lattice."""
    lobes = points(directions([y / 31]), model=GLOSSY, roughness=x / 31)
    wi, solid_angle = sphere_quadrature()
    albedo = evaluated(lobes, 0, wi)[:, 3] @ solid_angle
    assert albedo_tables().albedo[y, x] == pytest.approx(float(albedo), abs=5e-4)


def test_mean_albedo_is_the_mean_of_the_albedo():
    """Its 2 cos weighted mean; 1e-3: the trapezoids of this test over 32 points."""
    tables, cosines = albedo_tables(), np.linspace(0, 1, 32)
    integrand = 2 * cosines[:, None] * tables.albedo
    mean = (integrand[1:] + integrand[:-1]).sum(axis=0) / 62
    assert tables.mean_albedo == pytest.approx(mean, abs=1e-3)


@pytest.mark.parametrize(("x", "y", "z"), [(15, 15, 7), (15, 3, 7), (8, 6, 10), (6, 2, 12)])
def test_dielectric_table_is_the_mean_over_visible_facets(x, y, z):
    """An entry is the Fresnel curve, 0 ... 1, under the density of mirrored directions."""
    f0 = (z / 15) ** 4
    ior = (1 + f0**0.5) / (1 - f0**0.5)
    wo = directions([y / 15])
    lobes = points(wo, model=GLOSSY, roughness=x / 15)
    wi, solid_angle = sphere_quadrature()
    wi, solid_angle = wi[wi[:, 2] > 0], solid_angle[wi[:, 2] > 0]
    c = np.sqrt(0.5 + 0.5 * np.float64(wi) @ np.float64(wo[0]))
    t = np.sqrt(1 - (1 - c * c) / ior**2)
    s, p = (c - ior * t) / (c + ior * t), (t - ior * c) / (t + ior * c)
    blend = np.clip(((s * s + p * p) / 2 - f0) / (1 - f0), 0, 1)  # near Brewster's angle F < F0
    wanted = (densities(lobes, 0, wi) * blend) @ solid_angle
    assert albedo_tables().dielectric[z, y, x] == pytest.approx(wanted, abs=5e-4)


def test_layers_share_the_light():
    """What the dielectric layer reflects on average is missing below it; its whole is stated."""
    lobes = points(directions([0.3, 0.9]), distribution=MULTI_GGX)
    assert lobes.diffuse + lobes.glossy_color == pytest.approx(np.ones((2, 3)), abs=1e-6)
    tinted = points(directions([0.5]), specular_tint=(0.0, 1.0, 0.5), distribution=MULTI_GGX)
    # The most reflective channel decides for all, or the layer would tint what is below.
    assert len(set(tinted.diffuse[0].tolist())) == 1
    assert tinted.diffuse[0, 0] == pytest.approx(1 - tinted.glossy_color[0, 1], abs=1e-6)


def test_no_points_are_no_lobes():
    """A tile of sky."""
    lobes = points(np.zeros((0, 3)))
    assert lobes.weight.shape == (0, 2, 3) and lobes.kind.shape == (0,)
