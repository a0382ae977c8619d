"""Hypothesis tests from NumPy alone: chi-square of counts, t of means. Each returns a p-value.

Both assume independent samples: drive them by PCG64 numbers or by independently shifted replicates,
never by one set of Halton points.
"""

import math

import numpy as np


def sidak(alpha: float, n_tests: int) -> float:
    """The level of each of n tests for which all together have false-alarm rate alpha."""
    return 1.0 - (1.0 - alpha) ** (1.0 / n_tests)


def chi2_survival(x: float, dof: int) -> float:
    """P(chi-square with ``dof`` degrees of freedom > x): the upper incomplete gamma function."""
    a, x = 0.5 * dof, 0.5 * x
    if x <= 0.0:
        return 1.0
    front = math.exp(a * math.log(x) - x - math.lgamma(a))
    if x < a + 1.0:  # series of the lower one
        term = total = 1.0 / a
        k = a
        while term > total * 1e-16:
            k += 1.0
            term *= x / k
            total += term
        return 1.0 - front * total
    return front / _continued_fraction(lambda k: (x + 1.0 - a + 2.0 * k, (k + 1.0) * (a - k - 1.0)))


def t_survival(t: float, dof: float) -> float:
    """P(|T| > t) of Student's t with ``dof`` degrees of freedom: the incomplete beta function."""
    x, a, b = dof / (dof + t * t), 0.5 * dof, 0.5
    if x >= 1.0:
        return 1.0
    if x < (a + 1.0) / (a + b + 2.0):
        return _incomplete_beta(x, a, b)
    return 1.0 - _incomplete_beta(1.0 - x, b, a)


def _incomplete_beta(x, a, b):
    """Regularised, for x < (a + 1) / (a + b + 2), by its continued fraction (DLMF 8.17.22)."""
    log_front = math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b)
    front = math.exp(log_front + a * math.log(x) + b * math.log1p(-x)) / a

    def term(k):
        m, odd = divmod(k + 1, 2)
        if odd:
            return 1.0, -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))
        return 1.0, m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))

    return front / _continued_fraction(term)


def _continued_fraction(term):
    """b0 + a0 / (b1 + a1 / (b2 + ...)) for term(k) = (b_k, a_k), from 400 terms down.

    Enough for 4000 degrees of freedom: checked against known quantiles in test_statistics.py.
    """
    value = term(400)[0]
    for k in range(399, -1, -1):
        b, a = term(k)
        value = b + a / value
    return value


def chi2_p_value(observed: np.ndarray, expected: np.ndarray) -> float:
    """p of counts against expected counts; cells that expect under 5 are pooled to one.

    A count where nothing is expected gives 0. Totals must be equal, so one degree is lost.
    """
    observed, expected = observed.ravel().astype(np.float64), expected.ravel().astype(np.float64)
    if observed[expected == 0.0].any():
        return 0.0
    rare = expected < 5.0
    pooled_observed = np.append(observed[~rare], observed[rare].sum())
    pooled_expected = np.append(expected[~rare], expected[rare].sum())
    if pooled_expected[-1] < 5.0:  # too few even together: the last ordinary cell takes them
        pooled_observed[-2] += pooled_observed[-1]
        pooled_expected[-2] += pooled_expected[-1]
        pooled_observed, pooled_expected = pooled_observed[:-1], pooled_expected[:-1]
    statistic = ((pooled_observed - pooled_expected) ** 2 / pooled_expected).sum()
    return chi2_survival(statistic, len(pooled_expected) - 1)


def t_p_value(samples: np.ndarray, expected: float) -> float:
    """p of the samples' mean being ``expected``, two-sided."""
    n = len(samples)
    deviation = samples.std(ddof=1)
    if deviation == 0.0:
        return 1.0 if samples.mean() == expected else 0.0
    return t_survival(abs(samples.mean() - expected) / (deviation / math.sqrt(n)), n - 1)


def welch_p_value(a: np.ndarray, b: np.ndarray) -> float:
    """p of two sets of samples having one mean, two-sided, variances unknown and unequal."""
    va, vb = a.var(ddof=1) / len(a), b.var(ddof=1) / len(b)
    t = abs(a.mean() - b.mean()) / math.sqrt(va + vb)
    dof = (va + vb) ** 2 / (va * va / (len(a) - 1) + vb * vb / (len(b) - 1))
    return t_survival(t, dof)
