"""Glossy lobes wider along a tangent than across it (core/bsdf/stretched.py)."""

import numpy as np
import pytest

from iwis.core.bsdf.stretched import mean_roughness, stretch_lobes
from iwis.core.scene import BECKMANN, GGX, GLOSSY, MULTI_GGX, PRINCIPLED
from support.brdf_points import (
    densities,
    directions,
    evaluated,
    points,
    reflected,
    sampled,
    sphere_quadrature,
)
from support.scenes import constant_world, glossy
from support.warps import PointProduct, light_of

_WO = np.float32([[0.3, -0.5, 0.8124], [0.0, 0.0, 1.0], [0.8, 0.1, 0.5916]])
_WIDE, _NARROW = 0.5, 0.125  # of the slopes, along x and y turned by 30 degrees
_ALONG = np.float32([np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0])


def _brushed(distribution, ratio=2.0, along=_ALONG, wo=_WO, **values):
    """Lobes of alpha .25 for each of wo, stretched along a tangent: alpha_x / alpha_y is 4."""
    given = {"model": GLOSSY, "distribution": distribution, "roughness": 0.5} | values
    grain = np.tile(np.float32(ratio) * along, (len(wo), 1))
    own = np.full(len(wo), given["roughness"], np.float32)
    lobes = points(wo, **given | {"roughness": float(mean_roughness(own, grain)[0])})
    stretch_lobes(lobes, own, grain)
    return lobes


def _textbook(distribution, wo, wi):
    """D / (4 cos_o (1 + Lambda_o + Lambda_i)) of wi (n, 3), in float64 [Heitz14]."""
    across = np.cross([0.0, 0.0, 1.0], _ALONG)
    frame = np.stack([_ALONG, across, [0.0, 0.0, 1.0]]).astype(np.float64)
    o, i = frame @ wo, wi.astype(np.float64) @ frame.T
    h = (o + i) / np.linalg.norm(o + i, axis=1)[:, None]
    slopes = ((h[:, :2] / h[:, 2:]) / (_WIDE, _NARROW)) ** 2
    tilt = slopes.sum(1)
    area = np.pi * _WIDE * _NARROW * h[:, 2] ** 4
    d = np.exp(-tilt) / area if distribution == BECKMANN else 1.0 / (area * (1.0 + tilt) ** 2)

    def hidden(v):
        tan = np.sqrt((v[..., 0] * _WIDE) ** 2 + (v[..., 1] * _NARROW) ** 2) / v[..., 2]
        if distribution == GGX:
            return 0.5 * (np.sqrt(1.0 + tan**2) - 1.0)
        a = 1.0 / np.maximum(tan, 1e-9)
        fit = (1.0 - 1.259 * a + 0.396 * a**2) / (3.535 * a + 2.181 * a**2)
        return np.where(tan**2 < 0.39, 0.0, fit)  # as Cycles cuts it

    return d / (4.0 * o[2] * (1.0 + hidden(o) + hidden(i)))


@pytest.mark.parametrize("distribution", [GGX, BECKMANN])
def test_gloss_is_the_textbook_formula(distribution, rng):
    """In a frame turned by 30 degrees, float32 against float64."""
    wi = rng.normal(size=(4000, 3))
    wi[:, 2] = np.abs(wi[:, 2]) + 0.02
    wi = np.float32(wi / np.linalg.norm(wi, axis=1)[:, None])
    lobes = _brushed(distribution)
    for p, wo in enumerate(_WO.astype(np.float64)):
        ours = evaluated(lobes, p, wi)[:, 3] / lobes.weight[p, 1, 0]
        expected = _textbook(distribution, wo, wi)
        np.testing.assert_allclose(ours, expected, rtol=2e-3, atol=1e-6)


@pytest.mark.parametrize("roughness", (0.5, 0.8, 1.0))
@pytest.mark.parametrize("ratio", (1.5, 3.0, 10.0))
def test_later_bounces_bring_no_more_than_there_is(roughness, ratio):
    """White in a white world: widths end at 1, and with them what facets hide of each other.

    That is read off for round facets of the mean width, as Cycles does: up to 4 % too much.
    """
    values = {"roughness": roughness, "base_color": (1.0, 1.0, 1.0)}
    once, in_all = (_brushed(kind, ratio, **values) for kind in (GGX, MULTI_GGX))
    wi, solid_angle = sphere_quadrature(512, 1024)
    for p in range(len(_WO)):
        first, albedo = (evaluated(x, p, wi)[:, 3] @ solid_angle for x in (once, in_all))
        assert first < albedo < 1.04


@pytest.mark.parametrize("distribution", [GGX, BECKMANN])
@pytest.mark.parametrize(
    "values", [{}, {"model": PRINCIPLED, "metallic": 0.5, "diffuse_roughness": 0.5}]
)
def test_samples_follow_their_density(distribution, values, rng):
    """The density integrates to 1, and weighted samples give the integral of the BRDF."""
    lobes = _brushed(distribution, **values)
    wi, solid_angle = sphere_quadrature(512, 1024)
    for p in range(len(_WO)):
        assert abs(solid_angle.astype(np.float64) @ densities(lobes, p, wi) - 1.0) < 2e-3
        directions_of, pdf = sampled(lobes, p, rng.random((200_000, 2)))
        value = evaluated(lobes, p, directions_of).sum(1)
        share = np.where(pdf > 0.0, value / np.maximum(pdf, 1e-20), 0.0)
        error = share.std() / np.sqrt(len(share))
        whole = reflected(lobes, p, quadrature=(wi, solid_angle)).sum()
        assert abs(share.mean() - whole) < 4.0 * error + 2e-3 * whole


def test_round_lobe_stays_as_it_is():
    """A length of 1, none, or one along the normal changes nothing."""
    plain = points(_WO, model=GLOSSY, roughness=0.5)
    for ratio, along in ((1.0, _ALONG), (0.0, _ALONG), (2.0, np.float32([0.0, 0.0, 1.0]))):
        lobes = _brushed(GGX, ratio, along)
        for ours, theirs in zip(lobes[:-1], plain[:-1], strict=True):
            np.testing.assert_array_equal(ours, theirs)


def test_wide_axis_is_the_tangent_or_across_it():
    """alpha is the greater width: along the tangent for a length over 1, across it below."""
    wider, narrower = _brushed(GGX, 2.0), _brushed(GGX, 0.5)
    for lobes in (wider, narrower):
        np.testing.assert_allclose(lobes.alpha, _WIDE, rtol=1e-6)
        np.testing.assert_allclose(lobes.narrow, _NARROW, rtol=1e-6)
    np.testing.assert_allclose(wider.tangent @ _ALONG, 1.0, rtol=1e-6)
    np.testing.assert_allclose(narrower.tangent @ _ALONG, 0.0, atol=1e-6)


@pytest.mark.parametrize("turn", [0.5, -0.5, 2.0])
def test_products_cells_follow_the_brushing(turn, rng):
    """Seen aslant to the brushing, in even light: weights of the product's samples spread by .22 to
    .24 of the mean; by 3 where cells had the brushing mirrored at the plane of wo."""
    along = np.float32([np.cos(turn), np.sin(turn), 0.0])
    width, grain = np.full(1, 0.5, np.float32), 2.0 * along[None]
    product = PointProduct(
        light_of(constant_world()),
        glossy(float(mean_roughness(width, grain)[0])),
        wo=(0.0, 0.6, 0.8),
        change=lambda lobes: stretch_lobes(lobes, width, grain),
    )
    wi, pdf = product.warp(rng.random((20_000, 2)))
    weight = evaluated(product.lobes, 0, np.float32(wi)).sum(axis=1) / pdf
    assert weight.std() < 0.3 * weight.mean()


def test_sharp_brushing_has_no_fireflies(rng):
    """Roughness .1, stretched as Anisotropic .9: no sample is over 6 times what the lobe holds.

    Samples of the lobe itself: BRDF x cosine over density is the share of seen facets, below 1.
    """
    lobes = _brushed(GGX, 5.26**0.5, wo=directions([0.9, 0.3, 0.05]), roughness=0.1)
    for p in range(3):
        wi, pdf = sampled(lobes, p, rng.random((20_000, 2)))
        value = evaluated(lobes, p, wi)[:, 3]
        good = pdf > 0.0
        assert np.isfinite(value).all() and (value[good] / pdf[good]).max() < 6.0
