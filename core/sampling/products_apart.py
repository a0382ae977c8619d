"""The products of a block by an address: compiled apart from the loop that asks for them.

With what it calls build_products is a fifth of the loop's code. At a machine's first render one
process compiles it while another one compiles the loop (docs/decisions/0021-first-compilation.md).
"""

from __future__ import annotations

import functools

import numba
import numpy as np

from .._jit import c_callback
from ..bsdf.lobes import Lobes
from ..light.environment import EnvironmentLookup
from ..light.light_leaves import LightLeaves
from ..light.pyramid import LightPyramid
from ..machine.addresses import handing_on
from ..products.like_products import build_products, new_product_scratch
from ..products.product import CellDirections, ProductCells, new_products
from .light_rays import Light

_KINDS = {"b": np.int8, "i": np.int32, "u": np.uint32, "f": np.float32}
_LOBES = "b1 b1 f1 f2 f3 f3 f2 f2 f2 f2 f2 f1 f1 f1 f2 f2 f2 f1 f2 f1 f2 f2 i1 f5"


def empty_arrays(kinds: str) -> list[np.ndarray]:
    """C contiguous ones, to ask numba for their types: "f2" is float32 (0, 0)."""
    return [np.empty((0,) * int(kind[1]), _KINDS[kind[0]]) for kind in kinds.split()]


def empty_lobes() -> Lobes:
    """Of no point, as renders have them."""
    return Lobes(*empty_arrays(_LOBES))


def empty_light() -> Light:
    """Of no texel, as renders have it."""
    directions = CellDirections(*empty_arrays("f1 f1 f1"))
    return Light(
        EnvironmentLookup(*empty_arrays("f3 f2 f1"), 0, 0),
        LightPyramid(*empty_arrays("f1"), 0, *empty_arrays("i1"), 0),
        LightLeaves(*empty_arrays("i1 f2 i2")),
        ProductCells(*empty_arrays("f1 f1 f1 f1 f2"), directions, directions),
    )


# (lobes, how many points, apart, light, products, scratch), of build_products.
_GIVEN = (
    empty_lobes(),
    0,
    np.float32(0.0),
    empty_light(),
    new_products(0, False),
    new_product_scratch(),
)
# build_with(address, given) is for kernels: the products of a block, by builder_address().
build_with, _given_at = handing_on(numba.typeof(_GIVEN))


def _build(place):
    lobes, n, apart, light, products, scratch = _given_at(place)
    build_products(lobes, 0, n, apart, light, products, scratch)


def builder_address() -> int:
    """Of void f(place), which builds the products of what build_with hands on.

    It is compiled, or read, when it is first asked for.
    """
    return _builder().address


@functools.cache
def _builder():
    return c_callback(numba.types.void(numba.types.intp), counts_references=False)(_build)
