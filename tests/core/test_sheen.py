"""Sheen as a factor on a Lambert lobe (core/bsdf/sheen.py)."""

import numpy as np
import pytest

from iwis.core._jit import kernel
from iwis.core.bsdf.brdf import pdf_narrowest_at
from iwis.core.bsdf.lobes_at import lobes_at
from iwis.core.bsdf.sheen import diffuse_color, diffuse_colors, microfiber, set_sheen
from iwis.core.nodes.layers import under_sheen
from iwis.core.scene import DIFFUSE
from support.brdf_points import (
    directions,
    evaluated,
    narrowest,
    points,
    reflected,
    sphere_quadrature,
)
from support.scenes import constant_world, diffuse
from support.warps import PointProduct, light_of

_COSINES = (0.9, 0.5, 0.15)


def _lobes(model, roughness):
    wo = directions(_COSINES)
    lobes = points(wo, model=DIFFUSE)
    own = np.full(len(wo), model == "fibers"), np.full(len(wo), model == "velvet")
    set_sheen(lobes, *own, np.full(len(wo), roughness, np.float32))
    return lobes


@pytest.mark.parametrize("roughness", [0.2, 0.5, 1.0])
def test_fibers_reflect_what_the_table_says(roughness):
    """Of light from everywhere R, but for the part of the bent lobe that is below the horizon.

    The map keeps z's sign: nothing is below, the integral over the hemisphere is R.
    """
    lobes = _lobes("fibers", roughness)
    share = microfiber(np.float32(_COSINES), np.full(3, roughness, np.float32))[2]
    quadrature = sphere_quadrature(512, 1024)
    found = [reflected(lobes, p, quadrature=quadrature)[0] for p in range(3)]
    np.testing.assert_allclose(found, share, rtol=5e-3, atol=1e-4)


@kernel
def _density(lobes, p, wi, out):
    at = lobes_at(lobes, p)
    for i in range(len(wi)):
        out[i] = pdf_narrowest_at(at, wi[i, 0], wi[i, 1], wi[i, 2])


@pytest.mark.parametrize("roughness", [0.2, 0.5, 1.0])
def test_samples_of_fibers_follow_the_lobe(roughness, rng):
    """Their density integrates to 1, and BRDF x cosine over it is R, whatever the direction."""
    lobes = _lobes("fibers", roughness)
    share = microfiber(np.float32(_COSINES), np.full(3, roughness, np.float32))[2]
    wi, solid_angle = sphere_quadrature(512, 1024)
    density = np.empty(len(wi), np.float32)
    for p in range(3):
        _density(lobes, p, wi, density)
        assert abs(solid_angle.astype(np.float64) @ density - 1.0) < 5e-3
        found, own = narrowest(lobes, p, rng, 5000)
        np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0, rtol=1e-4)
        value = evaluated(lobes, p, found)[:, 0]
        np.testing.assert_allclose(value, lobes.diffuse[p, 0] * own, rtol=1e-3)
        # Means of directions by samples and by the density: 5 standard errors of 5000.
        mean = (solid_angle * density).astype(np.float64) @ wi
        assert np.abs(found.mean(0) - mean).max() < 5.0 / np.sqrt(len(found))
        assert abs(lobes.diffuse[p, 0] / share[p] - 1.0) < 1e-5


def test_table_is_read_between_its_nodes():
    """Halfway between two roughnesses each number is the mean; past the ends it is the end's."""
    cosine = np.full(3, 0.25, np.float32)
    low, middle, high = (np.float32([x / 31.0] * 3) for x in (20.0, 20.5, 21.0))
    for a, b, c in zip(*(microfiber(cosine, r) for r in (low, middle, high)), strict=True):
        np.testing.assert_allclose(b, (a + c) / 2.0, rtol=1e-5)
    ends = microfiber(np.float32([1.0, 2.0]), np.float32([1.0, 3.0]))
    for values in ends:
        assert values[0] == values[1]


@pytest.mark.parametrize("roughness", [0.3, 0.8])
def test_velvet_is_the_textbook_formula(roughness, rng):
    """D G / (4 cos_o) of an inverted Gaussian [Ashikhmin00], in float64."""
    lobes = _lobes("velvet", roughness)
    wi = rng.normal(size=(2000, 3))
    wi[:, 2] = np.abs(wi[:, 2]) + 0.02
    wi = np.float32(wi / np.linalg.norm(wi, axis=1)[:, None])
    for p, wo in enumerate(directions(_COSINES).astype(np.float64)):
        h = wi + wo
        h /= np.linalg.norm(h, axis=1)[:, None]
        cos_h, half = h[:, 2], h @ wo
        sin2 = 1.0 - cos_h**2
        d = np.exp(-(cos_h**2) / sin2 / roughness**2) / (np.pi * roughness**2 * sin2**2)
        g = np.minimum(1.0, 2.0 * cos_h / half * np.minimum(wi[:, 2], wo[2]))
        ours = evaluated(lobes, p, wi)
        np.testing.assert_allclose(ours[:, 3], d * g / (4.0 * wo[2]), rtol=3e-3, atol=1e-7)
        assert (ours[:, :3] == 0.0).all()


@pytest.mark.parametrize("roughness", [0.3, 0.8])
@pytest.mark.parametrize("model", ["fibers", "velvet"])
def test_product_has_density_wherever_sheen_is_lit(model, roughness, rng):
    """Down to the horizon, where sheen shines most: what only those samples find that follow the
    lobe itself is seldom, and 20 times too bright."""
    fibers, velvet = (np.array([model == kind]) for kind in ("fibers", "velvet"))
    width = np.full(1, roughness, np.float32)
    product = PointProduct(
        light_of(constant_world()),
        diffuse(),
        wo=(0.0, 0.6, 0.8),
        change=lambda lobes: set_sheen(lobes, fibers, velvet, width),
    )
    wi = rng.standard_normal((20_000, 3))
    wi[:, 2] = np.abs(wi[:, 2]) * rng.choice([1.0, 0.05], len(wi))
    wi = np.float32(wi / np.linalg.norm(wi, axis=1)[:, None])
    lit = evaluated(product.lobes, 0, wi).sum(axis=1) > 1e-6
    assert lit.sum() > 1000 and product.pdf(wi[lit]).min() > 0.0


def test_velvet_is_glossy_and_fibers_are_diffuse():
    """In Cycles' passes, and to lights that only one kind of rays sees."""
    velvet, fibers = _lobes("velvet", 0.5), _lobes("fibers", 0.5)
    assert (diffuse_colors(velvet) == 0.0).all() and (velvet.glossy_color == velvet.diffuse).all()
    assert (diffuse_colors(fibers) == fibers.diffuse).all() and (fibers.glossy_color == 0.0).all()
    assert (velvet.diffuse > 0.0).all() and (fibers.diffuse > 0.0).all()


@kernel
def _fill_diffuse_color(lobes, out):
    for p in range(len(out)):
        for c in range(3):
            out[p, c] = diffuse_color(lobes, p, c)


def test_kernels_and_arrays_have_one_diffuse_color():
    """Of every kind of Lambert lobe."""
    lobes = points(directions(np.full(12, 0.5)), model=DIFFUSE)
    lobes.rough[:, 3] = np.arange(12) - 11.0  # the kinds of lambert_kinds.py, and a plain one
    found = np.empty((12, 3), np.float32)
    _fill_diffuse_color(lobes, found)
    np.testing.assert_array_equal(found, diffuse_colors(lobes))
    assert (found == 0.0).all(axis=1).any() and (found > 0.0).all(axis=1).any()


def test_paint_under_fibers_gets_the_rest():
    """1 less weight x brightest tint x R, never below 0."""

    class Straight:
        wo = normal = np.float32([[0.0, 0.0, 1.0]])

        def __len__(self):
            return 1

    share = float(microfiber(np.float32([1.0]), np.float32([0.5]))[2][0])
    inputs = {"Weight": np.float32([0.8] * 3), "Roughness": np.float32(0.5)}
    inputs |= {"Sheen": np.float32(1.0), "Tint": np.float32([0.2, 1.0, 0.5])}
    left = under_sheen(Straight(), {}, inputs)[""]
    np.testing.assert_allclose(left, 0.8 * (1.0 - share), rtol=1e-5)
    left = under_sheen(Straight(), {}, inputs | {"Sheen": np.float32(1e3)})[""]
    assert not left.any()
