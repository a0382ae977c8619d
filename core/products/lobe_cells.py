"""Light x BSDF at cells of the sphere: the numbers that a product is made of.

A cell stands for all directions in it by the one at its centre, so what is narrower than a cell is
widened to it: the cosine to a disc of the cell's solid angle, the GGX lobe by the cell's width as
the half vector sees it. Seen flat, half vectors run along a cell by half its width in the plane of
wo, and by half its width / (wo . h) across it: the widened lobe has two widths.

What lies inside a cell is then known only roughly. ``spread`` says how much that matters.
"""

import math
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.lobes import THIN_FILM
from ..bsdf.luminance import luminance
from ..bsdf.microfacet import HALF, ONE, QUARTER, ZERO, cross, dot
from ..bsdf.thin_film import film_color_of
from ..unit_square.sphere_map import CELL_REACH

_TINY = np.float32(1e-6)
_REACH = np.float32(CELL_REACH)  # how far the corners of a cell are, in radii of its disc
# What a cell keeps, of the cosine its farthest corner may have.
_CORNER = np.float32(0.05)
# Half of a lobe this narrow is left to those samples that follow the lobe itself: it spans about
# one of the product's smallest cells, and may miss or meet a sun where the cell half does.
_CELL_ALPHA2 = np.float32(0.004**2)


class CellLambert(NamedTuple):
    """A point's Lambert lobe: albedo is its luminance / pi; normal; turned: see CellGloss."""

    albedo: np.float32
    x: np.float32
    y: np.float32
    z: np.float32
    turned: np.float32


class CellGloss(NamedTuple):
    """A point's glossy lobe, as float32: Smith shadowing, Schlick's curve between two ends.

    normal, wo: triples; side, along: triples, a frame with normal; side is normal to wo too
    cos_o, along_o, lambda_o: of wo; alpha2: width squared, where it is stretched of both widths
    in_plane, mixed, across: the facets' covariance, entries of a matrix over along and side
    kept: the part of the lobe's core that the product holds, less than 1 where it is narrow
    head_on, grazing: luminance of the reflectance
    turned: how far other normals may be turned whose horizon is to have light too, radians
    """

    normal: tuple
    wo: tuple
    side: tuple
    along: tuple
    cos_o: np.float32
    along_o: np.float32
    lambda_o: np.float32
    alpha2: np.float32
    in_plane: np.float32
    mixed: np.float32
    across: np.float32
    kept: np.float32
    head_on: np.float32
    grazing: np.float32
    turned: np.float32


@kernel(forceinline=True)
def lambert_at(lobes, p, turned):
    """Row p of lobes."""
    albedo = luminance(lobes.diffuse[p, 0], lobes.diffuse[p, 1], lobes.diffuse[p, 2])
    normal = lobes.normal
    over_pi = albedo * np.float32(1.0 / math.pi)
    return CellLambert(over_pi, normal[p, 0], normal[p, 1], normal[p, 2], turned)


@kernel
def _film_luminance(lobes, p, cosine):
    r, g, b = film_color_of(lobes, p, cosine)
    return luminance(r, g, b)


@kernel
def _under_film(lobes, p, grazing):
    """CellGloss.head_on under a film, whose colors go up and down with the angle: by what it
    mirrors of wo, and never far below what it does elsewhere."""
    cosine = min(max(lobes.cos_o[p], ZERO), ONE)
    elsewhere = _film_luminance(lobes, p, ONE) + _film_luminance(lobes, p, HALF)
    miss = ONE - cosine
    bent = miss * miss * miss * miss * miss
    own = (_film_luminance(lobes, p, cosine) - grazing * bent) / max(ONE - bent, _CORNER)
    return max(own, QUARTER * elsewhere)


@kernel(forceinline=True)
def gloss_at(lobes, p, turned):
    """Row p of lobes."""
    g, w = lobes.glossy_normal, lobes.wo
    normal, wo = (g[p, 0], g[p, 1], g[p, 2]), (w[p, 0], w[p, 1], w[p, 2])
    side = cross(normal, wo)
    if dot(side, side) < _TINY:  # seen from above: any will do
        side = cross(normal, (ZERO, ZERO, ONE) if abs(normal[2]) < HALF else (ONE, ZERO, ZERO))
    inverse = ONE / np.sqrt(dot(side, side))
    side = (side[0] * inverse, side[1] * inverse, side[2] * inverse)
    along = cross(side, normal)
    head_on, grazing = ZERO, ZERO
    for curve in range(2):
        w, f0 = lobes.weight[p, curve], lobes.f0[p, curve]
        head_on += luminance(w[0] * f0[0], w[1] * f0[1], w[2] * f0[2])
        grazing += luminance(w[0], w[1], w[2])
    if lobes.kind[p] & THIN_FILM:
        head_on = _under_film(lobes, p, grazing)
    alpha2 = in_plane = across = lobes.alpha[p] * lobes.alpha[p]
    mixed = ZERO
    if lobes.narrow[p] > ZERO:
        t = lobes.tangent[p]
        wide2, narrow2 = alpha2, lobes.narrow[p] * lobes.narrow[p]
        c, s = dot((t[0], t[1], t[2]), along), dot((t[0], t[1], t[2]), side)
        in_plane, across = c * c * wide2 + s * s * narrow2, s * s * wide2 + c * c * narrow2
        mixed, alpha2 = c * s * (wide2 - narrow2), np.sqrt(wide2 * narrow2)
    kept = alpha2 / (alpha2 + _CELL_ALPHA2)
    cos_o = max(lobes.cos_o[p], np.float32(1e-3))
    lambda_o = np.sqrt(alpha2 + (ONE - alpha2) * cos_o * cos_o)
    frame = (normal, wo, side, along)
    widths, fresnel = (alpha2, in_plane, mixed, across), (head_on, grazing)
    return CellGloss(*frame, cos_o, dot(along, wo), lambda_o, *widths, kept, *fresnel, turned)


@kernel(forceinline=True)
def _lit_cosine(cosine, radius, quarter, turned):
    """Mean of the cosine over a cell; above 0 wherever a corner of the cell is lit."""
    lit = max(cosine + radius, ZERO)
    reached = max(cosine + _REACH * radius + turned, ZERO)
    return cosine if cosine > radius else max(lit * lit * quarter, _CORNER * reached)


@kernel
def fill_lambert(lobe, x, y, z, light, n, radius, scale, values):
    """values = scale x light x Lambert lobe x cosine over n cells; returns their sum.

    radius: of a disc of a cell's solid angle, sr^(1/2)
    """
    albedo, quarter = lobe.albedo * scale, QUARTER / radius
    total = ZERO
    for r in range(n):
        cosine = x[r] * lobe.x + y[r] * lobe.y + z[r] * lobe.z
        value = albedo * _lit_cosine(cosine, radius, quarter, lobe.turned) * light[r]
        values[r] = value
        total += value
    return total


@kernel
def add_gloss(lobe, x, y, z, light, n, radius, scale, values, spread):
    """values += scale x light x GGX lobe x cosine over n cells, widened to the cells.

    spread: written, the variance that the lobe's slope leaves inside each cell, times its value
    """
    nx, ny, nz = lobe.normal
    ox, oy, oz = lobe.wo
    tx, ty, tz = lobe.side
    ax, ay, az = lobe.along
    alpha2, cos_o = lobe.alpha2, lobe.cos_o
    quarter, gain = QUARTER / radius, np.float32(0.5 / math.pi) * scale
    wide = QUARTER * radius * radius
    in_plane, twice_mixed = lobe.in_plane + wide, lobe.mixed + lobe.mixed
    mixed2 = lobe.mixed * lobe.mixed
    lobe_oh = max(cos_o, np.sqrt(alpha2))  # wo . h where the lobe is, if that is in the cell
    for r in range(n):
        cosine = x[r] * nx + y[r] * ny + z[r] * nz
        cos_i = _lit_cosine(cosine, radius, quarter, lobe.turned)
        io = x[r] * ox + y[r] * oy + z[r] * oz
        oh2 = max(HALF * (ONE + io), _TINY)  # (wo . h)^2
        oh = np.sqrt(oh2)
        per_h2 = QUARTER / oh2  # 1 / |wo + wi|^2
        # The centre of a cell at the horizon may be below it: h of its lit part.
        nh = (cosine if cosine > radius else HALF * max(cosine + radius, ZERO)) + cos_o
        th = x[r] * tx + y[r] * ty + z[r] * tz
        ah = x[r] * ax + y[r] * ay + z[r] * az + lobe.along_o
        nh2 = nh * nh * per_h2
        low = max(oh - HALF * radius, min(oh, lobe_oh))
        apart = wide / (low * low)
        across = lobe.across + apart
        area2 = in_plane * across - mixed2
        bent = ah * ah * across + th * th * in_plane - ah * th * twice_mixed
        slope2 = per_h2 * bent / area2
        d = slope2 + nh2
        miss = ONE - oh
        miss2 = miss * miss
        fresnel = lobe.head_on + (lobe.grazing - lobe.head_on) * miss2 * miss2 * miss
        smith = cos_o * np.sqrt(alpha2 + (ONE - alpha2) * cos_i * cos_i) + cos_i * lobe.lambda_o
        # Where the cell's edges stand on the curve of D, in widths of the lobe.
        slope, reach = np.sqrt(slope2), np.sqrt(wide / in_plane + apart / across)
        far, near = slope + reach, max(slope - reach, ZERO)
        widths = np.sqrt(area2)
        # Far from a lobe that is narrower than the cell, its own tail: a widened one is heavier.
        tail = alpha2 * nh2 + near * near * widths
        density = min(lobe.kept / (widths * d * d), alpha2 / (tail * tail))
        value = fresnel * gain * cos_i * light[r] * density / (smith + _TINY)
        values[r] += value
        ratio = (ONE + far * far) / (ONE + near * near)
        range_ = min(ratio * ratio - ONE, np.float32(16.0))
        spread[r] = value * range_ * range_ * np.float32(1.0 / 16.0)
