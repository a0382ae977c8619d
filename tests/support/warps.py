"""One shading point's product of light and BSDF, warped point by point: for tests of densities."""

import numpy as np

from iwis.core._jit import kernel
from iwis.core.bsdf.lobe_setup import setup_lobes
from iwis.core.light.environment import make_lookup
from iwis.core.light.light_tree import build_pyramid
from iwis.core.machine.lanes import DX, DY, DZ, LANES, PDF, X, Y, new_lanes
from iwis.core.products.product import new_products, pdf_product
from iwis.core.products.product_build import build_product, new_block_scratch
from iwis.core.products.warp import warp_lanes
from iwis.core.sampling.light_rays import make_light
from iwis.core.unit_square.sphere_map import sphere_to_square

from .scenes import make_materials


def light_of(world):
    """core.sampling.light_rays.Light of an EnvironmentMap."""
    lookup = make_lookup(world)
    return make_light(lookup, build_pyramid(lookup))


@kernel
def _pdfs(products, light, directions, out):
    for k in range(len(directions)):
        x, y = sphere_to_square(directions[k, 0], directions[k, 1], directions[k, 2])
        out[k] = pdf_product(products, 0, light, x, y)


@kernel
def _whole_pdfs(products, light, out):
    side = out.shape[0]
    for i in range(side):
        for j in range(side):
            x, y = (j + 0.5) / side, (i + 0.5) / side
            out[i, j] = pdf_product(products, 0, light, x, y)


class PointProduct:
    """The product of ``light`` and one material seen from wo.

    products: Products of the one point; total: its sum; lobes: Lobes of the point
    change: what changes them before the product is made
    """

    def __init__(
        self,
        light,
        material,
        normal=(0.0, 0.0, 1.0),
        wo=(0.0, 0.6, 0.8),
        turned=0.0,
        change=lambda lobes: None,
    ):
        normal, wo = np.float32([normal]), np.float32([wo])
        self.lobes = setup_lobes(make_materials(material), normal, normal, wo)
        change(self.lobes)
        self.light, self.products = light, new_products(1, True)
        own = self.lobes, 0, np.float32(turned), light.cells, light.pyramid.averages, self.products
        build_product(*own, new_block_scratch())
        self.total = float(self.products.trees[0, 0])

    def warp(self, points):
        """Points (n, 2) of the square -> (directions float64 (n, 3), pdf (n,))."""
        lanes, cut = new_lanes(), bool(self.products.blocks[0] > 0)
        directions, pdf = np.empty((len(points), 3)), np.empty(len(points))
        for first in range(0, len(points), LANES):
            some = points[first : first + LANES]
            n = len(some)
            for row, values in ((X, some[:, 0]), (Y, some[:, 1])):
                lanes.numbers[row : row + n] = np.minimum(values, np.float32(1.0 - 2.0**-24))
            warp_lanes(self.products, cut, self.light.pyramid, self.light.leaves, lanes, n)
            x, y, z, density = (lanes.numbers[row : row + n] for row in (DX, DY, DZ, PDF))
            directions[first : first + n] = np.stack([x, y, z], -1)
            pdf[first : first + n] = density
        return directions, pdf

    def pdf(self, directions):
        """The density of warp, float64 (n,), sr^-1, at unit directions (n, 3)."""
        out = np.empty(len(directions))
        _pdfs(self.products, self.light.pyramid, directions.astype(np.float64), out)
        return out

    def whole_pdf(self):
        """float64 (side, side): the mean density in every cell of the light's last whole level."""
        light = self.light.pyramid
        cut = light._replace(children=np.zeros_like(light.children), deepest=light.levels)
        side = 1 << light.levels
        out = np.empty((side, side))
        _whole_pdfs(self.products, cut, out)
        return out


def square_points(directions):
    """float64 (n, 2): (x, y) on the sphere's square of unit directions (n, 3)."""
    return np.array([sphere_to_square(*direction) for direction in directions.astype(np.float64)])
