"""The types of all arguments of the loop of mode UNBIASED, before there are any.

A letter and a digit say an array's type and its dimensions; arrays are C contiguous.
"""

from __future__ import annotations

import numba
import numpy as np

from ..embree.embree_rays import Traversal
from ..geometry.shading import ShadingPoints
from ..machine.watch import StopFlag
from ..products.guide import new_guides
from ..unit_square.sequence import PixelSequence
from .block_loop import Places, new_room
from .incremental import new_sums
from .products_apart import empty_arrays, empty_light, empty_lobes
from .stop_rule import perceptual_rule

_POINTS = "i1 i1 f2 f2 f2 f2 f2 f1 f2 i1"


def loop_signature() -> tuple:
    """numba's types of the arguments of block_loop.continue_blocks, in their order."""
    none = np.int32([0])
    example = (
        none,
        new_guides(0),
        Places(none, none, none),
        ShadingPoints(*empty_arrays(_POINTS)),
        empty_lobes(),
        np.float32(0.0),
        empty_light(),
        PixelSequence(*empty_arrays("u2 u1 u1"), True),
        np.float32(0.0),
        Traversal(0, 0, 0, 0, False, 0.0, 0, 0.0),
        perceptual_rule(1.0, 1),
        new_sums(0),
        new_room(glossy=False, builder=0),
        StopFlag().memory,
    )
    return tuple(map(numba.typeof, example))
