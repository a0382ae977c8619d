"""Products for the points of a block: a point that is like another one uses that one's product.

A product only says where samples go; what they bring is worked out for the point itself. So any
product with a density wherever the point can reflect light will do, and that of a point which is
turned by a degree does as well as its own. It is made for all of them: cells have light while they
are no farther below the horizon than the normals may be apart (docs/decisions/0032-like-points.md).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..bsdf.lambert_kinds import PHONG, TRANSLUCENT_ROUND
from ..bsdf.lobes import DIFFUSE_LOBE
from ..settings import RenderSettings
from .lobe_cells import gloss_at, lambert_at
from .product_build import BlockScratch, build_product, new_block_scratch

# Angles between normals, radians: where a point has few samples a product of its own costs more
# than what a like one lacks.
NEARLY_ALIKE, ALIKE = np.float32(0.0087), np.float32(0.035)
# Mirrored directions may be apart by this, times alpha and the angle of the normals.
_MIRRORED = np.float32(7.0)
# Numbers of two lobes may differ by this part.
_CLOSE = np.float32(0.15)
_MOST = 64  # products that a point is compared with, the newest ones
# Columns of Builders.numbers
_NORMAL, _GLOSSY, _MIRROR, _ALPHA, _COS_O, _ALBEDO, _HEAD_ON, _GRAZING = 0, 3, 6, 9, 10, 11, 12, 13
_ZERO, _HALF, _ONE, _TWO = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(2.0)


def apart_of(settings: RenderSettings) -> np.float32:
    """How far the normals of points of a picture may be apart that share a product, radians."""
    return NEARLY_ALIKE if settings.pixel_filter == "CENTER" else ALIKE


class Builders(NamedTuple):
    """What points are compared by that products were built for; the last row is the point at hand.

    numbers: float32 (_MOST + 1, columns); kind: int32 (_MOST + 1, 2), of Lobes, and the row of the
    product
    """

    numbers: np.ndarray
    kind: np.ndarray


class ProductScratch(NamedTuple):
    """Scratch of build_products; one a thread."""

    blocks: BlockScratch
    builders: Builders


def new_product_scratch() -> ProductScratch:
    """One a thread."""
    numbers = np.zeros((_MOST + 1, _GRAZING + 1), np.float32)
    return ProductScratch(
        new_block_scratch(), Builders(numbers, np.zeros((_MOST + 1, 2), np.int32))
    )


@kernel(forceinline=True)
def _is_plain(lobes, p):
    """Whether the numbers of Builders say all that the product is made of."""
    kind = lobes.rough[p, 3]
    plain = kind >= _ZERO or kind == TRANSLUCENT_ROUND or kind == PHONG
    return plain and lobes.narrow[p] == _ZERO


@kernel
def _describe(lobes, p, into):
    """Write what the product of a plain point is made of."""
    numbers, normal = into.numbers[_MOST], lobes.normal[p]
    into.kind[_MOST, 0], into.kind[_MOST, 1] = lobes.kind[p], p
    for a in range(3):
        numbers[_NORMAL + a] = normal[a]
    if lobes.kind[p] <= DIFFUSE_LOBE:
        return
    matte, gloss = lambert_at(lobes, p, _ZERO), gloss_at(lobes, p, _ZERO)
    n, wo = gloss.normal, gloss.wo
    twice = _TWO * (n[0] * wo[0] + n[1] * wo[1] + n[2] * wo[2])
    for a in range(3):
        numbers[_GLOSSY + a] = lobes.glossy_normal[p, a]
        numbers[_MIRROR + a] = twice * lobes.glossy_normal[p, a] - lobes.wo[p, a]
    numbers[_ALPHA], numbers[_COS_O] = lobes.alpha[p], gloss.cos_o
    numbers[_ALBEDO] = matte.albedo
    numbers[_HEAD_ON], numbers[_GRAZING] = gloss.head_on, gloss.grazing


@kernel(forceinline=True)
def _apart(numbers, k, column, limit):
    """Whether a unit vector of row k is farther from that of the last row: 1 - cos > limit."""
    dot = _ZERO
    for a in range(3):
        dot += numbers[k, column + a] * numbers[_MOST, column + a]
    return dot < _ONE - limit


@kernel(forceinline=True)
def _alike(builders, k, apart):
    """Whether the point of the last row may use the product of row k."""
    numbers, limit = builders.numbers, _HALF * apart * apart
    if builders.kind[k, 0] != builders.kind[_MOST, 0] or _apart(numbers, k, _NORMAL, limit):
        return False
    if builders.kind[k, 0] <= DIFFUSE_LOBE:
        return True
    angle = _MIRRORED * apart * numbers[_MOST, _ALPHA]
    if _apart(numbers, k, _MIRROR, _HALF * angle * angle) or _apart(numbers, k, _GLOSSY, limit):
        return False
    for column in range(_ALPHA, _GRAZING + 1):
        own = numbers[_MOST, column]
        if abs(numbers[k, column] - own) > _CLOSE * own:
            return False
    return True


@kernel(forceinline=True)
def _find(builders, n, apart):
    """The row of a product for the point of the last row, -1 = none. n: those that were kept"""
    k = min(n, _MOST)
    while k > 0:
        k -= 1
        if _alike(builders, k, apart):
            return np.int64(builders.kind[k, 1])
    return np.int64(-1)


@kernel(forceinline=True)
def _keep(builders, n):
    """Keep the last row as number n, in place of the oldest where all rows are taken."""
    k = n % _MOST
    for column in range(_GRAZING + 1):
        builders.numbers[k, column] = builders.numbers[_MOST, column]
    builders.kind[k, 0], builders.kind[k, 1] = builders.kind[_MOST, 0], builders.kind[_MOST, 1]


@kernel
def build_products(lobes, first, end, apart, light, products, scratch):
    """Fill the products of a block, points first ... end - 1 of lobes.

    apart: float32, how far normals of points may be apart that share one, radians
    """
    averages = light.pyramid.averages
    builders, n = scratch.builders, np.int64(0)
    for p in range(first, end):
        plain, q = _is_plain(lobes, p), np.int64(-1)
        if plain:
            _describe(lobes, p, builders)
            q = _find(builders, n, apart)
        if q >= 0:
            products.own[p] = q
            products.blocks[p], products.follow[p] = products.blocks[q], products.follow[q]
            continue
        turned = apart if plain else _ZERO
        build_product(lobes, p, turned, light.cells, averages, products, scratch.blocks)
        if plain and products.trees[p, 0] > _ZERO:
            _keep(builders, n)
            n += 1
