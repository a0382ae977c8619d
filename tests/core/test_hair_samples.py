"""A strand lit from all round: hair_samples.py, and its part of hair.py and hair_cells.py."""

import numpy as np
import pytest

from iwis.core._jit import kernel
from iwis.core.bsdf.hair import ALL_ROUND, LAMPS_ALONE, chiang_at, eval_strand
from iwis.core.bsdf.hair_samples import pdf_strand, sample_strand, shares_of
from iwis.core.bsdf.hair_setup import HairValues, has_world, set_hair
from iwis.core.bsdf.lobes_at import lobes_at
from iwis.core.data.program import HAIR_BELL_REFLECTION, HAIR_BELL_TRANSMISSION, HAIR_CHIANG
from support.brdf_points import evaluated, sphere_quadrature
from support.chi2 import chi2_p_value
from support.scenes import constant_world, diffuse
from support.warps import PointProduct, light_of

_SEEN = [(0.0, 0.1, 0.995), (0.6, 0.3, 0.74), (0.1, 0.8, 0.59), (-0.95, -0.2, 0.24)]
_MODELS = [HAIR_CHIANG, HAIR_BELL_REFLECTION, HAIR_BELL_TRANSMISSION]
_ZERO = np.float32(0.0)
_ALPHA = 1 - (1 - 1e-3) ** (1 / 12)  # 1e-3 for the file, over its 12 strands [Sidak]


def _product(wo, side, model=HAIR_CHIANG, roughness=0.3, absorption=0.3):
    """PointProduct of a strand along x, under a constant world."""

    def prepare(lobes):
        one = np.float32([1.0])
        color = np.full((1, 3), absorption, np.float32)
        own = np.float32([[1.0, 0.0, 0.0]]), color, roughness * one, roughness * one
        values = HairValues(model, *own, 0.0 * one, 1.55 * one, 0.035 * one)
        set_hair(lobes, np.array([0]), values, np.float32([side]))
        lobes.normal[:] *= np.sign(np.float32(side))

    wo = np.array(wo) / np.linalg.norm(wo)
    return PointProduct(light_of(constant_world()), diffuse((1.0, 1.0, 1.0)), wo=wo, change=prepare)


@kernel
def _eval(lobes, wi, out):
    at = lobes_at(lobes, 0)
    hair = chiang_at(at, _ZERO)
    for k in range(len(wi)):
        value = eval_strand(at, hair, wi[k, 0], wi[k, 1], wi[k, 2])
        out[k] = value[3]


@kernel
def _pdf(lobes, wi, out):
    at = lobes_at(lobes, 0)
    hair = chiang_at(at, _ZERO)
    shares = shares_of(at, hair)
    for k in range(len(wi)):
        out[k] = pdf_strand(hair, shares, wi[k, 0], wi[k, 1], wi[k, 2])


@kernel
def _sample(lobes, u, out):
    at = lobes_at(lobes, 0)
    for k in range(len(u)):
        out[k, 0], out[k, 1], out[k, 2] = sample_strand(at, u[k, 0], u[k, 1])


def _of(function, lobes, wi):
    out = np.empty(len(wi), np.float32)
    function(lobes, np.ascontiguousarray(wi, np.float32), out)
    return out


def _samples(lobes, rng, n):
    out = np.empty((n, 3), np.float32)
    _sample(lobes, rng.random((n, 2), np.float32), out)
    return out


def _bins(wi):
    """int (n,): 12 by the height along the strand, of equal solid angles, times 24 round it."""
    height = np.clip(np.int64(6.0 * (wi[:, 0] + 1.0)), 0, 11)
    angle = np.arctan2(wi[:, 1], wi[:, 2]) / (2.0 * np.pi) + 0.5
    return 24 * height + np.clip(np.int64(24.0 * angle), 0, 23)


@pytest.mark.statistical
@pytest.mark.parametrize("roughness", [0.15, 0.3, 0.8])
@pytest.mark.parametrize("wo", _SEEN)
def test_samples_of_a_strand_have_their_density(wo, roughness, rng):
    """chi^2 of 200 000 directions from independent numbers; a density 5 % off is rejected."""
    lobes = _product(wo, ALL_ROUND, roughness=roughness).lobes
    wi, solid_angle = sphere_quadrature(384, 768)
    chances = np.bincount(_bins(wi), _of(_pdf, lobes, wi) * solid_angle, 288)
    n = 200_000
    observed = np.bincount(_bins(_samples(lobes, rng, n)), minlength=288)
    assert chi2_p_value(observed, n * chances / chances.sum()) > _ALPHA
    wrong = chances * (1.0 + 0.05 * np.sign(np.arange(288) % 2 - 0.5))  # more in every other bin
    assert chi2_p_value(observed, n * wrong / wrong.sum()) < _ALPHA


@pytest.mark.parametrize("absorption", [0.0, 0.3, 50.0])
@pytest.mark.parametrize("wo", _SEEN)
def test_density_of_a_strand_is_1_in_all(wo, absorption):
    """But for quadrature, I0 to 2e-4 and float32 of numbers a narrow lobe is made of."""
    wi, solid_angle = sphere_quadrature(384, 768)
    for roughness in (0.3, 0.6, 0.9):
        lobes = _product(wo, ALL_ROUND, roughness=roughness, absorption=absorption).lobes
        whole = _of(_pdf, lobes, wi).astype(np.float64) @ solid_angle
        assert whole == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("model", _MODELS)
@pytest.mark.parametrize("wo", _SEEN)
def test_one_point_has_the_light_of_both_sides(model, wo, rng):
    """Bit for bit but for rounding: the frame of the side behind is made of another normal."""
    wi = rng.normal(size=(4000, 3))
    wi = np.float32(wi / np.linalg.norm(wi, axis=1)[:, None])
    wi = wi[np.abs(wi[:, 2]) > 1e-3]  # on the border neither side has it
    whole = _of(_eval, _product(wo, ALL_ROUND, model).lobes, wi)
    sides = (_of(_eval, _product(wo, side, model).lobes, wi) for side in (1.0, -1.0))
    np.testing.assert_allclose(whole, sum(sides), rtol=1e-4, atol=1e-6)
    assert (whole > 0.0).any()


def test_lamps_see_one_side_of_it():
    """Their rays start at the point: what is behind has a closure of its own for them."""
    wi = np.float32([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    front, behind = (_product(_SEEN[0], side).lobes for side in (ALL_ROUND, LAMPS_ALONE))
    both = [evaluated(lobes, 0, wi)[:, 3] for lobes in (front, behind)]
    assert both[0][0] > 0.0 and both[1][1] > 0.0
    assert both[0][1] == 0.0 and both[1][0] == 0.0


def test_what_is_behind_takes_no_samples_of_the_world():
    front, behind = (_product(_SEEN[0], side) for side in (ALL_ROUND, LAMPS_ALONE))
    assert front.total > 0.0 and behind.total == 0.0
    assert has_world(front.lobes).all() and not has_world(behind.lobes).any()
    np.testing.assert_allclose(front.lobes.glossy_color, 1.0)
    assert not behind.lobes.glossy_color.any()


@pytest.mark.parametrize("model", _MODELS)
@pytest.mark.parametrize("wo", _SEEN)
def test_product_of_a_strand_is_a_density(model, wo):
    product = _product(wo, ALL_ROUND, model)
    assert product.whole_pdf().mean() * 4.0 * np.pi == pytest.approx(1.0, abs=1e-5)


def test_seen_from_its_ends_a_strands_samples_vary_little_too(rng):
    """A cell is wide round the axis there: the spread is .81 of the mean, and .98 where it is taken
    for as narrow as everywhere. 20 000 samples know it to .02."""
    product = _product((0.99, 0.1, 0.1), ALL_ROUND, roughness=0.3)
    by_product, _ = product.warp(rng.random((20_000, 2)))
    by_lobes = _samples(product.lobes, rng, 20_000)
    share = product.products.follow[0]
    both = np.where(rng.random((20_000, 1)) < share, by_lobes, by_product)
    pdf = share * _of(_pdf, product.lobes, both) + (1.0 - share) * product.pdf(both)
    weight = _of(_eval, product.lobes, both) / pdf
    assert weight.std() < 0.9 * weight.mean()


@pytest.mark.parametrize(("roughness", "spread"), [(0.2, 0.9), (0.3, 0.65), (0.6, 0.35)])
def test_samples_of_product_and_lobes_vary_little(roughness, spread, rng):
    """Together, as unbiased.py mixes them, of all directions to look from: measured .75, .5, .25.

    No weight is above 25 times the mean: the lobes' own samples bound them.
    """
    found = []
    for wo in rng.normal(size=(24, 3)):
        product = _product((wo[0], wo[1], abs(wo[2])), ALL_ROUND, roughness=roughness)
        lobes, share, n = product.lobes, product.products.follow[0], 2000
        by_product, _ = product.warp(rng.random((n, 2)))
        by_lobes = _samples(lobes, rng, n)
        both = np.where(rng.random((n, 1)) < share, by_lobes, by_product)
        pdf = share * _of(_pdf, lobes, both) + (1.0 - share) * product.pdf(both)
        found.append(_of(_eval, lobes, both) / pdf)
    found = np.array(found)
    assert np.sqrt(found.var(axis=1).mean()) < spread * found.mean()
    assert found.max() < 25.0 * found.mean()
