"""Toon as a cap in place of a Lambert lobe (core/bsdf/toon.py)."""

import math

import numpy as np
import pytest

from iwis.core.bsdf.microfacet import MIN_ALPHA
from iwis.core.bsdf.sheen import diffuse_colors
from iwis.core.bsdf.toon import set_toon
from iwis.core.sampling.unbiased import bsdf_share
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

_COSINES = (0.95, 0.5, 0.15)
_CAPS = [(0.5, 0.0), (0.2, 0.3), (0.05, 0.0), (1.0, 1.0)]
_KINDS = ("diffuse", "glossy")


def _make(lobes, kind, size, smooth):
    n = len(lobes.kind)
    is_kind = [np.full(n, kind == name) for name in _KINDS]
    set_toon(lobes, *is_kind, np.full(n, size, np.float32), np.full(n, smooth, np.float32))


def _lobes(kind, size, smooth):
    lobes = points(directions(_COSINES), model=DIFFUSE)
    _make(lobes, kind, size, smooth)
    return lobes


def _axes(kind):
    """float64 (3, 3): the middle of each cap."""
    wo = directions(_COSINES).astype(np.float64)
    return np.tile([0.0, 0.0, 1.0], (3, 1)) if kind == "diffuse" else wo * [-1.0, -1.0, 1.0]


def _textbook(axis, size, smooth, wi):
    """(value, density), float64: the formula, cut at the horizon, and the cap."""
    size, smooth = (max(size, 1e-5) * math.pi / 2.0, smooth * math.pi / 2.0)
    reach = min(size + smooth, math.pi / 2.0)
    angle = np.arccos(np.clip(wi.astype(np.float64) @ axis, -1.0, 1.0))
    intensity = np.ones_like(angle)
    if smooth > 0.0:
        intensity = np.clip(1.0 - (angle - size) / smooth, 0.0, 1.0)
    density = (angle < reach) / (2.0 * math.pi * (1.0 - math.cos(reach)))
    return density * intensity * (wi[:, 2] > 0.0), density


@pytest.mark.parametrize("kind", _KINDS)
@pytest.mark.parametrize(("size", "smooth"), _CAPS)
def test_toon_is_the_formula(kind, size, smooth, rng):
    """In float64, but for directions within 1e-5 of the cap's edge, where float32 may differ."""
    lobes = _lobes(kind, size, smooth)
    for p, axis in enumerate(_axes(kind)):
        near = axis + rng.normal(size=(4000, 3)) * max(size + smooth, 0.1)
        wi = np.float32(near / np.linalg.norm(near, axis=1)[:, None])
        wanted, _ = _textbook(axis, size, smooth, wi)
        angle = np.arccos(np.clip(wi.astype(np.float64) @ axis, -1.0, 1.0))
        reach = min((size + smooth) * math.pi / 2.0, math.pi / 2.0)
        sure = (abs(angle - reach) > 1e-5) & (abs(wi[:, 2]) > 1e-6)
        found = evaluated(lobes, p, wi)
        own, other = (
            (found[:, :3], found[:, 3:]) if kind == "diffuse" else (found[:, 3:], found[:, :3])
        )
        assert (wanted[sure] > 0.0).any() and (other == 0.0).all()
        scale = wanted.max()
        # float32 of an angle of 1e-3 to 1.6 radians, over the width of the rim
        np.testing.assert_allclose(own[sure, 0], wanted[sure], rtol=1e-4, atol=1e-5 * scale)


@pytest.mark.parametrize("kind", _KINDS)
def test_what_toon_reflects_of_white_light(kind):
    """The color where the cap has no rim and no horizon cuts it, less with one."""
    quadrature = sphere_quadrature(512, 1024)
    for p in range(2):  # of the third the mirrored cap goes below the horizon
        whole = reflected(_lobes(kind, 0.3, 0.0), p, quadrature=quadrature)
        rim = reflected(_lobes(kind, 0.1, 0.2), p, quadrature=quadrature)
        full, smooth = 0.1 * math.pi / 2.0, 0.2 * math.pi / 2.0
        angles = np.linspace(0.0, full + smooth, 100_001)[1:]
        lit = np.sin(angles) * np.clip(1.0 - (angles - full) / smooth, 0.0, 1.0)
        wanted = lit.sum() * (angles[1] - angles[0]) / (1.0 - math.cos(full + smooth))
        place = slice(0, 3) if kind == "diffuse" else slice(3, 6)
        # The edge runs along one row of directions, a hundredth of the cap; a rim has no edge.
        np.testing.assert_allclose(whole[place], 1.0, rtol=1.5e-2)
        np.testing.assert_allclose(rim[place], wanted, rtol=2e-3)


@pytest.mark.parametrize("kind", _KINDS)
@pytest.mark.parametrize(("size", "smooth"), [*_CAPS, (0.001, 0.0), (0.0, 0.0)])
def test_samples_fill_the_cap(kind, size, smooth, rng):
    """Unit vectors in it, all alike: their mean is the axis times (1 + cos reach) / 2."""
    lobes = _lobes(kind, size, smooth)
    for p, axis in enumerate(_axes(kind)):
        wi, pdf = narrowest(lobes, p, rng, 4000)
        np.testing.assert_allclose(np.linalg.norm(wi, axis=1), 1.0, rtol=1e-5)
        reach = min((max(size, 1e-5) + smooth) * math.pi / 2.0, math.pi / 2.0)
        chord2 = 4.0 * math.sin(reach / 2.0) ** 2
        # A direction has 1e-7 of a float32: that is a hundredth of the narrowest cap.
        away = np.sqrt(((wi - axis) ** 2).sum(1))
        assert away.max() < math.sqrt(chord2) * 1.02 + 2e-7
        inside = away < math.sqrt(chord2) * 0.97 - 2e-7
        np.testing.assert_allclose(pdf[inside], 1.0 / (math.pi * chord2), rtol=1e-4)
        # 5 standard errors: the cosine is even between cos reach and 1.
        half = chord2 / 4.0
        spread = 5.0 * half / math.sqrt(3.0 * len(wi))
        assert abs(0.5 * (away**2).mean() - half) < spread + 1e-7 * math.sqrt(chord2)


@pytest.mark.parametrize("kind", _KINDS)
@pytest.mark.parametrize(("size", "smooth"), [*_CAPS, (0.15, 0.0), (0.01, 0.0)])
def test_product_has_density_wherever_the_cap_is_lit(kind, size, smooth, rng):
    """Up to the rim; and the narrower a cap is, the more samples follow it."""
    light, follow = light_of(constant_world()), []
    for _ in range(8):
        normal, wo = rng.standard_normal((2, 3))
        normal /= np.linalg.norm(normal)
        wo = normal + 0.7 * wo / np.linalg.norm(wo)
        product = PointProduct(
            light,
            diffuse((0.7, 0.5, 0.2)),
            normal,
            wo / np.linalg.norm(wo),
            change=lambda lobes: _make(lobes, kind, size, smooth),
        )
        wi, _ = narrowest(product.lobes, 0, rng, 2000)
        lit = evaluated(product.lobes, 0, wi).sum(axis=1) > 0.0
        assert lit.any() and product.pdf(wi[lit]).min() > 0.0
        follow.append(float(bsdf_share(product.products.follow[0], product.lobes.kind[0])))
    assert min(follow) == max(follow)
    reach = min((size + smooth) * math.pi / 2.0, math.pi / 2.0)
    assert follow[0] >= 0.05 and (follow[0] > 0.5) == (reach < 0.13)


def test_the_narrowest_cap_is_no_mirror():
    """Point lamps light it: what is as narrow as MIN_ALPHA shows none of them."""
    for kind in _KINDS:
        assert (_lobes(kind, 0.0, 0.0).alpha > MIN_ALPHA).all()


def test_glossy_toon_is_glossy_and_diffuse_toon_diffuse():
    """In Cycles' passes: each has its color whatever the cap."""
    matte, shiny = (_lobes(kind, 0.2, 0.3) for kind in _KINDS)
    assert (diffuse_colors(shiny) == 0.0).all() and (shiny.glossy_color == shiny.diffuse).all()
    assert (diffuse_colors(matte) == matte.diffuse).all() and (matte.glossy_color == 0.0).all()
    assert (shiny.diffuse > 0.0).all()
