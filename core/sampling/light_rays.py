"""A sample's shadow ray and the light it would bring: where every estimator without tables ends."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.brdf import eval_at, pdf_at
from ..bsdf.lambert_kinds import MICROFIBER, VELVET
from ..bsdf.microfacet import HALF, INV_PI
from ..bsdf.sheen import pdf_microfiber
from ..bsdf.toon import is_toon, pdf_toon
from ..embree.accel import start_shadow_ray
from ..light.environment import EnvironmentLookup
from ..light.light_leaves import LightLeaves, light_leaves
from ..light.pyramid import LightPyramid, pdf_light
from ..products.product import ProductCells, product_cells
from ..scene import ROUND

_ZERO, _ONE, _ROUND = np.float32(0.0), np.float32(1.0), np.float32(ROUND)


class Light(NamedTuple):
    """All that a sampler asks of the environment."""

    lookup: EnvironmentLookup
    pyramid: LightPyramid
    leaves: LightLeaves
    cells: ProductCells


def make_light(lookup: EnvironmentLookup, pyramid: LightPyramid) -> Light:
    """Everything of the light, from its lookup and its quadtree."""
    return Light(lookup, pyramid, light_leaves(pyramid), product_cells(pyramid))


@kernel(forceinline=True)
def _pdf_of_cycles(at, wx, wy, wz):
    """The density of Cycles' samples of the BSDF, sr^-1: of sheen it is not that of ours."""
    if at.rough[3] == MICROFIBER:
        return pdf_microfiber(at, wx, wy, wz)
    if at.rough[3] == VELVET:  # all directions above the surface alike
        above = at.normal[0] * wx + at.normal[1] * wy + at.normal[2] * wz
        return HALF * INV_PI if above > _ZERO else _ZERO
    if is_toon(at.rough):
        return pdf_toon(at, wx, wy, wz)
    return pdf_at(at, wx, wy, wz)


@kernel(forceinline=True)
def is_lifted(at, points, light, p, wx, wy, wz, u):
    """Whether a sample's ray starts on the smooth patch, as Cycles' rays would.

    Cycles lifts the rays of its light samples and not those of its BSDF samples: of the light from
    a direction, the share that the power heuristic gives to light sampling comes over the patch.
    Of what is round all does.
    """
    below, face = points.lift_below[p], points.geometric_normal
    above = face[p, 0] * wx + face[p, 1] * wy + face[p, 2] * wz
    if below <= _ZERO or above >= below + below:  # lift_share would be 0
        return False
    if below >= _ROUND:
        return True
    by_light = pdf_light(light.pyramid, np.float64(wx), np.float64(wy), np.float64(wz))
    by_bsdf = np.float64(_pdf_of_cycles(at, wx, wy, wz))
    return u * (by_light * by_light + by_bsdf * by_bsdf) < by_light * by_light


@kernel(forceinline=True)
def write_ray(at, points, light, p, wi, radiance, pdf, u, offset, rays, n):
    """Write a sample of point p as ray n if it can carry light; returns the next n.

    at: LobesAt of the point; wi: (x, y, z), world space; radiance: (r, g, b) from there; pdf: its
    density, sr^-1; u: sequence.sample_number; all float32 but u
    """
    wx, wy, wz = wi
    lr, lg, lb = radiance
    if not pdf > _ZERO or abs(lr + lg + lb) <= _ZERO:
        return n
    dr, dg, db, gr, gg, gb = eval_at(at, wx, wy, wz)
    if dr + dg + db + gr + gg + gb <= _ZERO:
        return n
    lifted = is_lifted(at, points, light, p, wx, wy, wz, u)
    if not start_shadow_ray(points, p, wx, wy, wz, lifted, offset, rays.origins, n):
        return n
    inverse = _ONE / pdf
    rays.diffuse[n, 0] = dr * lr * inverse
    rays.diffuse[n, 1] = dg * lg * inverse
    rays.diffuse[n, 2] = db * lb * inverse
    rays.glossy[n, 0] = gr * lr * inverse
    rays.glossy[n, 1] = gg * lg * inverse
    rays.glossy[n, 2] = gb * lb * inverse
    rays.directions[n, 0], rays.directions[n, 1], rays.directions[n, 2] = wx, wy, wz
    rays.point[n] = p
    return n + 1
