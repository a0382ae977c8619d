"""The types of all arguments of the loop of mode UNBIASED, before there are any.

A letter and a digit say an array's type and its dimensions; arrays are C contiguous.
"""

from __future__ import annotations

import numba
import numpy as np

from ..bsdf.lobes import Lobes
from ..embree.embree_rays import Traversal
from ..geometry.shading import ShadingPoints
from ..light.environment import EnvironmentLookup
from ..light.light_leaves import LightLeaves
from ..light.pyramid import LightPyramid
from ..machine.watch import StopFlag
from ..products.guide import new_guides
from ..products.product import CellDirections, ProductCells
from ..unit_square.sequence import PixelSequence
from .block_loop import Places, new_room
from .incremental import new_sums
from .light_rays import Light
from .stop_rule import perceptual_rule

_KINDS = {"b": np.int8, "i": np.int32, "u": np.uint32, "f": np.float32}
_POINTS = "i1 i1 f2 f2 f2 f2 f2 f1 f2 i1"
_LOBES = "b1 b1 f1 f2 f3 f3 f2 f2 f2 f2 f2 f1 f1 f1 f2 f2 f2 f1 f2 f1 f2 f2 i1 f5"


def loop_signature() -> tuple:
    """numba's types of the arguments of block_loop.continue_blocks, in their order."""
    none = np.int32([0])
    example = (
        none,
        new_guides(0),
        Places(none, none, none),
        ShadingPoints(*_arrays(_POINTS)),
        Lobes(*_arrays(_LOBES)),
        np.float32(0.0),
        _light(),
        PixelSequence(*_arrays("u2 u1 u1"), True),
        np.float32(0.0),
        Traversal(0, 0, 0, 0, False, 0.0, 0, 0.0),
        perceptual_rule(1.0, 1),
        new_sums(0),
        new_room(glossy=False),
        StopFlag().memory,
    )
    return tuple(map(numba.typeof, example))


def _light() -> Light:
    directions = CellDirections(*_arrays("f1 f1 f1"))
    return Light(
        EnvironmentLookup(*_arrays("f3 f2 f1"), 0, 0),
        LightPyramid(*_arrays("f1"), 0, *_arrays("i1"), 0),
        LightLeaves(*_arrays("i1 f2 i2")),
        ProductCells(*_arrays("f1 f1 f1 f1 f2"), directions, directions),
    )


def _arrays(kinds: str) -> list[np.ndarray]:
    """Empty ones: "f2" is float32 (0, 0)."""
    return [np.empty((0,) * int(kind[1]), _KINDS[kind[0]]) for kind in kinds.split()]
