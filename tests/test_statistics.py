"""tests/support/statistics.py: the p-values that other tests rely on."""

import numpy as np
import pytest

from support.statistics import (
    chi2_p_value,
    chi2_survival,
    sidak,
    t_p_value,
    t_survival,
    welch_p_value,
)


@pytest.mark.parametrize(
    ("x", "dof", "p"),
    [
        (3.841459, 1, 0.05),
        (5.991465, 2, 0.05),
        (10.827566, 1, 0.001),
        (124.342113, 100, 0.05),
        (1143.917, 1000, 0.001),
        (4282.1, 4000, 0.001),  # by Wilson and Hilferty's formula
        (90.0, 100, 0.7532),
    ],
)
def test_chi2_survival_equals_published_quantiles(x, dof, p):
    """Tables of the chi-square distribution, from 1 to 4000 degrees of freedom."""
    assert chi2_survival(x, dof) == pytest.approx(p, rel=0.02)  # quantiles have 4 to 8 digits


@pytest.mark.parametrize(
    ("t", "dof", "p"),
    [(12.7062, 1, 0.05), (2.2281, 10, 0.05), (3.2909, 100000, 0.001), (0.0, 5, 1.0)],
)
def test_t_survival_equals_published_quantiles(t, dof, p):
    """Two-sided quantiles of Student's t."""
    assert t_survival(t, dof) == pytest.approx(p, rel=1e-3)  # quantiles have 5 digits


@pytest.mark.statistical
def test_p_values_of_true_hypotheses_are_uniform(rng):
    """A 5 % level is crossed by about 5 % of 2000 true hypotheses (alpha 1e-3 each: 3.3 sigma)."""
    band = 3.3 * np.sqrt(0.05 * 0.95 / 2000)
    chi2 = [
        chi2_p_value(rng.multinomial(5000, np.full(50, 0.02)), np.full(50, 100.0))
        for _ in range(2000)
    ]
    t = [t_p_value(rng.standard_normal(20) + 3.0, 3.0) for _ in range(2000)]
    welch = [
        welch_p_value(rng.standard_normal(12), 5.0 * rng.standard_normal(30)) for _ in range(2000)
    ]
    for p in (chi2, t, welch):
        assert abs(np.mean(np.array(p) < 0.05) - 0.05) < band


def test_chi2_rejects_a_sample_where_none_can_be():
    """A count in a cell of density zero is not pooled away."""
    assert chi2_p_value(np.array([10, 90, 1]), np.array([10.0, 91.0, 0.0])) == 0.0


def test_sidak_level_gives_the_familys_rate():
    """n tests at the corrected level together have rate alpha."""
    assert 1.0 - (1.0 - sidak(1e-3, 7)) ** 7 == pytest.approx(1e-3)
