"""The state of walks under surfaces (random_walk.py), and their random numbers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel

# Numbers of a walk for its entry, for two ways and the scattering between them.
PLANNED = 10
_TO_UNIT = np.float32(2.0**-24)


class Walkers(NamedTuple):
    """Walks of n points: where, whereto, what is left, and the normal where they have entered,
    float32 (n, 3); of their last scattering, float32 (n, 3): how often such are guided, the density
    of that over the medium's own, and how far it stretches a way's extinction; the state of random
    numbers, uint64 (n,); the first ones, float32 (n, PLANNED), that cover evenly what a pixel's
    walks do, and how many of these are used up, int32 (n,); the triangle where they have entered
    and its object, and the ways that they have gone, int32 (n,)."""

    position: np.ndarray
    direction: np.ndarray
    throughput: np.ndarray
    outward: np.ndarray
    guide: np.ndarray
    state: np.ndarray
    planned: np.ndarray
    used: np.ndarray
    triangle: np.ndarray
    entered: np.ndarray
    steps: np.ndarray


class Meet(NamedTuple):
    """What walkers meet: Embree's face, instance, u and v; and how far they would have gone."""

    face: np.ndarray
    instance: np.ndarray
    u: np.ndarray
    v: np.ndarray
    way: np.ndarray


def new_meet(n: int) -> Meet:
    """Room for what n walkers meet."""
    numbers = (np.empty(n, np.int32) for _ in range(2))
    return Meet(*numbers, *(np.empty(n, np.float32) for _ in range(3)))


@kernel(forceinline=True)
def next_number(walkers, w):
    """The next number of a walk, float32 in [0, 1): planned, or an LCG's upper bits, mixed."""
    used = walkers.used[w]
    if used < PLANNED:
        walkers.used[w] = used + 1
        return walkers.planned[w, used]
    state = walkers.state
    state[w] = state[w] * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)
    x = state[w]
    x = (x ^ (x >> np.uint64(31))) * np.uint64(0x7FB5D329728EA185)
    x ^= x >> np.uint64(33)
    return np.float32(x >> np.uint64(40)) * _TO_UNIT


@kernel
def seed_states(columns, rows, number, seed, state):
    """columns, rows, number: int64 (n,), place of the pixel in the frame and its pass."""
    for w in range(len(state)):
        x = np.uint64(seed)
        for part in (columns[w], rows[w], number[w]):
            x = (x + np.uint64(part) + np.uint64(0x9E3779B97F4A7C15)) * np.uint64(
                0xBF58476D1CE4E5B9
            )
            x ^= x >> np.uint64(29)
        state[w] = x
