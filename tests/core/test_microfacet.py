"""core/bsdf/microfacet.py: the means of Fresnel's curves, beside their integrals."""

import numpy as np
import pytest

from iwis.core.bsdf.microfacet import (
    dielectric_blend,
    dielectric_mean,
    f0_of_ior,
    f82_edge,
    f82_mean,
)

_COSINES = (np.arange(4000) + 0.5) / 4000


@pytest.mark.parametrize(("f0", "tint"), [(0.04, 1.0), (0.5, 0.3), (0.9, 0.0)])
def test_mean_of_a_metals_curve(f0, tint):
    """2 int F c dc of F0 + (1 - F0) (1 - c)^5 - edge c (1 - c)^6, whose factor is the tint's."""
    f0, edge = np.float32(f0), f82_edge(np.float32(f0), np.float32(tint))
    curve = f0 + (1.0 - f0) * (1.0 - _COSINES) ** 5 - edge * _COSINES * (1.0 - _COSINES) ** 6
    expected = 2.0 * (curve * _COSINES).mean()
    assert f82_mean(f0, edge) == pytest.approx(expected, rel=1e-5)  # float32
    schlick = f0 + (1.0 - f0) * (6.0 / 7.0) ** 5
    own = schlick - edge * (1.0 / 7.0) * (6.0 / 7.0) ** 6
    assert own == pytest.approx(tint * schlick, abs=1e-6)


@pytest.mark.parametrize("eta", [0.5, 0.7, 0.9, 1.1, 1.5, 2.0, 3.0])
def test_mean_of_a_dielectrics_curve(eta):
    """Beside Fresnel's own curve: the fits are within .01 of it [Kulla17]."""
    eta = np.float32(eta)
    f0 = f0_of_ior(eta)
    numbers = eta * eta - np.float32(1.0), f0, np.float32(1.0) / (np.float32(1.0) - f0)
    blend = np.array([dielectric_blend(np.float32(c), *numbers) for c in _COSINES])
    expected = 2.0 * ((f0 + (1.0 - f0) * blend) * _COSINES).mean()
    assert dielectric_mean(eta) == pytest.approx(expected, abs=0.01)
