"""A row of Lobes as plain numbers: loaded once for all samples of a point."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..scene import BECKMANN
from .lobes import CONDUCTOR, DIELECTRIC


class LobesAt(NamedTuple):
    """One point's row of Lobes as plain numbers, which stay in registers from sample to sample."""

    kind: int
    gaussian: bool  # the distribution is BECKMANN
    alpha: np.float32
    diffuse: tuple
    dielectric_weight: tuple
    dielectric_f0: tuple
    fresnel: tuple
    conductor_weight: tuple
    conductor_f0: tuple
    edge: tuple
    normal: tuple
    glossy_normal: tuple
    wo: tuple
    cos_o: np.float32
    seen: np.float32
    diffuse_share: np.float32
    smooth: tuple
    bump: np.float32
    tint: tuple
    rough: tuple
    narrow: np.float32
    tangent: tuple
    table: int
    tables: np.ndarray


@kernel(forceinline=True)
def _row(a, p):
    return a[p, 0], a[p, 1], a[p, 2]


@kernel(forceinline=True)
def lobes_at(lobes, p):
    """Row p of lobes: load it once for all samples of a point."""
    return LobesAt(
        lobes.kind[p],
        lobes.distribution[p] == BECKMANN,
        lobes.alpha[p],
        _row(lobes.diffuse, p),
        _row(lobes.weight[p], DIELECTRIC),
        _row(lobes.f0[p], DIELECTRIC),
        _row(lobes.fresnel, p),
        _row(lobes.weight[p], CONDUCTOR),
        _row(lobes.f0[p], CONDUCTOR),
        _row(lobes.edge, p),
        _row(lobes.normal, p),
        _row(lobes.glossy_normal, p),
        _row(lobes.wo, p),
        lobes.cos_o[p],
        lobes.seen[p],
        lobes.diffuse_share[p],
        _row(lobes.smooth, p),
        lobes.bump[p],
        _row(lobes.tint, p),
        (*_row(lobes.rough, p), lobes.rough[p, 3]),
        lobes.narrow[p],
        _row(lobes.tangent, p),
        lobes.table[p],
        lobes.tables,
    )
