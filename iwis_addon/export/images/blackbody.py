"""Colors of black bodies, as Cycles has them: Blender gives the same to a lamp's temperature."""

from __future__ import annotations

import functools

import bpy
import numpy as np

from ....core.nodes.color import COOLEST, HOTTEST, blackbody
from ...scratch import scratch
from .color_spaces import working_space

_STEPS = 2048


@functools.cache
def _table(_space: str) -> np.ndarray:
    """float32 (n, 3), in the working space, from COOLEST to HOTTEST in logarithmic steps."""
    colors = np.empty((_STEPS, 3), np.float32)
    with scratch(bpy.data.lights, bpy.data.lights.new("Blackbody", "POINT")) as lamp:
        lamp.use_temperature = True
        for row, kelvin in enumerate(np.geomspace(COOLEST, HOTTEST, _STEPS)):
            lamp.temperature = kelvin
            colors[row] = lamp.temperature_color
    return colors


def blackbody_settings() -> dict:
    """The settings of core.nodes.color.blackbody."""
    return {"table": _table(working_space())}


def blackbody_color(kelvin: float) -> tuple[float, ...]:
    """Linear red, green, blue of a temperature."""
    found = blackbody(None, blackbody_settings(), {"Temperature": np.float32([kelvin])})
    return tuple(map(float, found["Color"][0]))
