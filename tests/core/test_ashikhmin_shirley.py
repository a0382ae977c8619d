"""The lobe of Ashikhmin and Shirley in place of Beckmann's (core/bsdf/ashikhmin_shirley.py)."""

import math

import numpy as np
import pytest

from iwis.core.bsdf.ashikhmin_shirley import set_ashikhmin_shirley
from iwis.core.bsdf.microfacet import MIN_ALPHA
from iwis.core.bsdf.stretched import stretch_lobes
from iwis.core.scene import BECKMANN, GLOSSY
from support.brdf_points import directions, evaluated, narrowest, points, sphere_quadrature

_COSINES = (0.95, 0.5, 0.15)
_COLOR = (0.8, 0.5, 0.2)


def _lobes(roughness, ratio=1.0):
    own = {"base_color": _COLOR, "roughness": roughness, "distribution": BECKMANN}
    lobes = points(directions(_COSINES), model=GLOSSY, **own)
    n = len(lobes.kind)
    if ratio != 1.0:
        grain = np.tile(np.float32([ratio, 0.0, 0.0]), (n, 1))
        stretch_lobes(lobes, np.full(n, roughness, np.float32), grain)
    set_ashikhmin_shirley(lobes, np.ones(n, np.bool_))
    return lobes


def _textbook(wo, widths, wi):
    """The formula of the module, float64; the tangent is x."""
    n_x, n_y = (2.0 / width**2 - 2.0 for width in widths)
    h = wi + wo
    h /= np.linalg.norm(h, axis=1)[:, None]
    tangent2 = np.maximum(1.0 - h[:, 2] ** 2, 1e-300)
    power = (n_x * h[:, 0] ** 2 + n_y * h[:, 1] ** 2) / tangent2
    norm = math.sqrt((n_x + 1.0) * (n_y + 1.0)) / (8.0 * math.pi)
    pump = (h @ wo) * np.maximum(wi[:, 2], wo[2])
    value = wi[:, 2] * norm * np.abs(h[:, 2]) ** power / pump
    return np.where(wi[:, 2] > 0.0, value, 0.0)


@pytest.mark.parametrize(
    ("roughness", "ratio"), [(0.15, 1.0), (0.5, 1.0), (1.0, 1.0), (0.5, 1.5), (0.4, 0.6), (0.9, 2)]
)
def test_it_is_the_formula(roughness, ratio, rng):
    """In float64, within what float32 of a half vector is worth: 1e-3 of the brightest."""
    lobes = _lobes(roughness, ratio)
    alpha = roughness**2
    widths = min(alpha * ratio, 1.0), min(alpha / ratio, 1.0)
    for p, wo in enumerate(directions(_COSINES).astype(np.float64)):
        near = wo * [-1.0, -1.0, 1.0] + rng.normal(size=(4000, 3)) * max(alpha, 0.02)
        wi = np.float32(near / np.linalg.norm(near, axis=1)[:, None])
        wanted = _textbook(wo, widths, wi.astype(np.float64))
        found = evaluated(lobes, p, wi)
        sure = np.abs(wi[:, 2]) > 1e-6
        assert (found[:, :3] == 0.0).all() and (wanted[sure] > 0.0).any()
        for c in range(3):
            own = _COLOR[c] * wanted[sure]
            np.testing.assert_allclose(found[sure, 3 + c], own, rtol=2e-3, atol=1e-3 * own.max())


@pytest.mark.parametrize(("roughness", "ratio"), [(0.3, 1.0), (0.6, 1.0), (0.5, 1.6)])
def test_samples_follow_it(roughness, ratio, rng):
    """Value over the density of Beckmann's samples: its mean is the integral, within 4 standard
    errors and the quadrature's 2e-3. (A few of wider facets, at grazing angles, bring much more;
    what samples of the product hold beside them: test_weigh.py.)"""
    lobes = _lobes(roughness, ratio)
    wi, solid_angle = sphere_quadrature(512, 1024)
    for p in range(len(_COSINES)):
        expected = solid_angle @ evaluated(lobes, p, wi)[:, 3].astype(np.float64)
        drawn, pdf = narrowest(lobes, p, rng, 20000)
        weight = evaluated(lobes, p, drawn)[:, 3] / np.maximum(pdf, 1e-30)
        error = weight.std() / math.sqrt(len(weight))
        assert abs(weight.mean() - expected) < 4.0 * error + 2e-3 * expected


def test_a_mirror_stays_one():
    """As smooth as one: the width that Cycles takes for a mirror, too."""
    lobes = _lobes(0.0)
    assert (lobes.rough == 0.0).all() and (lobes.alpha == MIN_ALPHA).all()
