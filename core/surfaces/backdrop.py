"""What camera rays see that hit nothing: the light's own map, another one, or a program.

A program is evaluated for each ray, so that what the camera sees has no texels: a map with 0.18
degrees a texel is enough to light a scene, but blurs seven pixels of a full-HD picture into one.
"""

from __future__ import annotations

import numpy as np

from ..data.program import WorldProgram
from ..light.environment import EnvironmentLookup, eval_environment_many, make_lookup
from ..nodes.world_map import evaluate_directions, ready
from ..scene import EnvironmentMap

_BLOCK = 1 << 15  # rays at once: a program's values stay in a core's cache
_BRIGHTEST = np.float32(1e15)


class Backdrop:
    """Radiance by direction; may be asked by several threads."""

    def __init__(self, world: EnvironmentMap | WorldProgram | EnvironmentLookup):
        self._program = self._lookup = None
        if isinstance(world, WorldProgram):
            program = ready(world.program, world.value)
            self._program, self._value, self._strength = program, world.value, world.strength
        else:
            self._lookup = make_lookup(world) if isinstance(world, EnvironmentMap) else world

    def radiance(self, directions: np.ndarray) -> np.ndarray:
        """float32 (n, 3), finite. directions: float32 (n, 3), unit, C-contiguous"""
        found = np.empty((len(directions), 3), np.float32)
        if self._program is None:
            eval_environment_many(self._lookup, directions, found)
            return found
        for first in range(0, len(directions), _BLOCK):
            part = slice(first, first + _BLOCK)
            color = evaluate_directions(self._program, self._value, directions[part])
            found[part] = np.clip(color, -_BRIGHTEST, _BRIGHTEST) * self._strength
        return found
