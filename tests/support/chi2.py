"""Pearson's chi^2 test of counts against expected counts, without SciPy."""

import math

import numpy as np


def chi2_p_value(observed: np.ndarray, expected: np.ndarray) -> float:
    """Probability of counts at least this far from the expected ones, if these are right.

    Cells that expect fewer than five counts are taken together. The tail is Wilson and Hilferty's:
    the cube root of chi^2 / dof is nearly normal, to 1e-3 from some ten degrees of freedom on.
    """
    observed, expected = np.ravel(observed), np.ravel(expected)
    small = expected < 5.0
    o = np.append(observed[~small], observed[small].sum())
    e = np.append(expected[~small], expected[small].sum())
    o, e = o[e > 0.0], e[e > 0.0]
    dof = len(e) - 1
    statistic = float(((o - e) ** 2 / e).sum())
    spread = 2.0 / (9.0 * dof)
    z = ((statistic / dof) ** (1.0 / 3.0) - (1.0 - spread)) / math.sqrt(spread)
    return 0.5 * math.erfc(z / math.sqrt(2.0))
