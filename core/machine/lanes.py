"""Samples side by side: what a few dozen of them are, row by row, on their way to a shadow ray.

A step of the work (warp.py, weigh.py) is one loop over all lanes, without branches where that can
be, which compiles to vector instructions. So that it does, all numbers of the lanes are rows of one
array at distances known to the compiler, in float32.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

LANES = 128  # rows of 512 bytes: all of them stay in a core's first cache, beside one product
# Where the rows of Lanes.numbers begin. The children's weights in a step of the descent; what is
# left of the point; its direction, and the density of that; its place in the environment's map;
# the radiance there; where its ray starts; the light it would bring over its density, by lobe.
A, B, C, D = (LANES * row for row in range(4))
X, Y = LANES * 4, LANES * 5
DX, DY, DZ, PDF = (LANES * row for row in range(6, 10))
U, V = LANES * 10, LANES * 11
RED, GREEN, BLUE = LANES * 12, LANES * 13, LANES * 14
OX, OY, OZ = LANES * 15, LANES * 16, LANES * 17
DIFFUSE, GLOSSY = LANES * 18, LANES * 21  # three rows each: red, green, blue
_ROWS = 24


class Lanes(NamedTuple):
    """Room for LANES samples.

    numbers: float32 (rows * LANES,): X, Y, DX ... are where a row begins
    cell, quadrant: int32 (LANES,), where a lane is, and where it goes
    base: int32 (LANES,), the cell of its product's base; -1: it follows a lobe
    block: int32 (LANES,), 1 + the block of its product that it is in, 0 = none
    product: int32 (LANES,), the row of its product among all
    tree: int64 (LANES,), where that begins in the array of all
    point, sample: int32 (LANES,), shading point and index of its sample
    ray: int32 (LANES,), the lanes that have a ray; seen: uint8 (LANES,), bits: the colors that come
        through on it
    """

    numbers: np.ndarray
    cell: np.ndarray
    quadrant: np.ndarray
    base: np.ndarray
    block: np.ndarray
    product: np.ndarray
    tree: np.ndarray
    point: np.ndarray
    sample: np.ndarray
    ray: np.ndarray
    seen: np.ndarray


def new_lanes() -> Lanes:
    """Lanes with nothing in them."""
    integers = [np.zeros(LANES, np.int32) for _ in range(8)]
    return Lanes(
        numbers=np.zeros(_ROWS * LANES, np.float32),
        cell=integers[0],
        quadrant=integers[1],
        base=integers[6],
        block=integers[2],
        product=integers[7],
        tree=np.zeros(LANES, np.int64),
        point=integers[3],
        sample=integers[4],
        ray=integers[5],
        seen=np.zeros(LANES, np.uint8),
    )
