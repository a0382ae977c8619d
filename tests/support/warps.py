"""One shading point's product of light and BSDF, warped point by point: for tests of densities."""

import numpy as np

from iwis.core._jit import kernel
from iwis.core.environment import make_lookup
from iwis.core.light_rays import make_light
from iwis.core.lobes import setup_lobes
from iwis.core.product import (
    NARROW_LEVEL,
    build_product,
    choose_level,
    pdf_product,
)
from iwis.core.pyramid import build_pyramid, level_offset
from iwis.core.sphere_map import sphere_to_square
from iwis.core.warp import DX, DY, DZ, LANES, PDF, X, Y, new_lanes, warp_lanes

from .scenes import make_materials


def light_of(world):
    """core.light_rays.Light of an EnvironmentMap."""
    lookup = make_lookup(world)
    return make_light(lookup, build_pyramid(lookup, 1))


@kernel
def _pdfs(trees, level, averages, levels, directions, out):
    for k in range(len(directions)):
        x, y = sphere_to_square(directions[k, 0], directions[k, 1], directions[k, 2])
        out[k] = pdf_product(trees[0], 0, level, averages, levels, x, y)


@kernel
def _finest_pdfs(trees, level, averages, levels, out):
    side = out.shape[0]
    for i in range(side):
        for j in range(side):
            x, y = (j + 0.5) / side, (i + 0.5) / side
            out[i, j] = pdf_product(trees[0], 0, level, averages, levels, x, y)


class PointProduct:
    """The product of ``light`` and one material seen from wo.

    level: of its cells; total: its sum; lobes: Lobes of the one point
    """

    def __init__(self, light, material, normal=(0.0, 0.0, 1.0), wo=(0.0, 0.6, 0.8)):
        normal, wo = np.float32([normal]), np.float32([wo])
        self.lobes = setup_lobes(make_materials(material), normal, normal, wo)
        self.light, self.level = light, choose_level(self.lobes, 0)
        self._cells = light.narrow if self.level == NARROW_LEVEL else light.wide
        self._trees = np.empty((1, level_offset(self.level + 1)), np.float32)
        build_product(self.lobes, 0, self.level, self._cells, self._trees[0])
        self.total = float(self._trees[0, 0])

    def warp(self, points):
        """Points (n, 2) of the square -> (directions float64 (n, 3), pdf (n,))."""
        lanes, products, light = new_lanes(), self._trees[0], self.light.pyramid
        directions, pdf = np.empty((len(points), 3)), np.empty(len(points))
        for first in range(0, len(points), LANES):
            some = points[first : first + LANES]
            n = len(some)
            for row, values in ((X, some[:, 0]), (Y, some[:, 1])):
                lanes.numbers[row : row + n] = np.minimum(values, np.float32(1.0 - 2.0**-24))
            warp_lanes(products, self.level, self._cells.morton, light, lanes, n)
            x, y, z, density = (lanes.numbers[row : row + n] for row in (DX, DY, DZ, PDF))
            directions[first : first + n] = np.stack([x, y, z], -1)
            pdf[first : first + n] = density
        return directions, pdf

    def pdf(self, directions):
        """The density of warp, float64 (n,), sr^-1, at unit directions (n, 3)."""
        out = np.empty(len(directions))
        _pdfs(self._trees, self.level, *self.light.pyramid, directions.astype(np.float64), out)
        return out

    def finest_pdf(self):
        """float64 (side, side): the density in every cell of the light's finest level."""
        side = 1 << self.light.pyramid.levels
        out = np.empty((side, side))
        _finest_pdfs(self._trees, self.level, *self.light.pyramid, out)
        return out


def square_points(directions):
    """float64 (n, 2): (x, y) on the sphere's square of unit directions (n, 3)."""
    return np.array([sphere_to_square(*direction) for direction in directions.astype(np.float64)])
