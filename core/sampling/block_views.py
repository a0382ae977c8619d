"""Of the arrays of many points those of one block, which are not copied; for kernels."""

from __future__ import annotations

from .._jit import kernel
from ..bsdf.lobes import Lobes
from ..geometry.shading import ShadingPoints
from .incremental import PixelSums


@kernel(inline="always")
def points_at(points, a, b):
    return ShadingPoints(
        points.pixel[a:b],
        points.triangle[a:b],
        points.position[a:b],
        points.wo[a:b],
        points.geometric_normal[a:b],
        points.normal[a:b],
        points.lift[a:b],
        points.lift_below[a:b],
        points.through[a:b],
        points.passed[a:b],
    )


@kernel(inline="always")
def lobes_at(lobes, a, b):
    return Lobes(
        lobes.kind[a:b],
        lobes.distribution[a:b],
        lobes.alpha[a:b],
        lobes.diffuse[a:b],
        lobes.weight[a:b],
        lobes.f0[a:b],
        lobes.edge[a:b],
        lobes.fresnel[a:b],
        lobes.normal[a:b],
        lobes.glossy_normal[a:b],
        lobes.wo[a:b],
        lobes.cos_o[a:b],
        lobes.seen[a:b],
        lobes.diffuse_share[a:b],
        lobes.glossy_color[a:b],
        lobes.emission[a:b],
        lobes.smooth[a:b],
        lobes.bump[a:b],
        lobes.rough[a:b],
        lobes.narrow[a:b],
        lobes.tangent[a:b],
        lobes.tint[a:b],
        lobes.table[a:b],
        lobes.tables,
    )


@kernel(inline="always")
def sums_at(sums, a, b):
    return PixelSums(
        sums.count[a:b],
        sums.visible[a:b],
        sums.diffuse[a:b],
        sums.glossy[a:b],
        sums.unoccluded[a:b],
        sums.seen[a:b],
        sums.seen_squared[a:b],
        sums.hue[a:b],
        sums.error[a:b],
    )
