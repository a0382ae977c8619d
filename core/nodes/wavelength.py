"""Colors of single wavelengths, as Cycles has them: CIE's observer of 1931, and a scale.

Between two rows of its table the observer is linear.
"""

from __future__ import annotations

import numpy as np

from ..data.observer import FIRST_NM, STEP_NM, observer
from .values import column

_SCALE = 1.0 / 2.52  # Cycles' own
_XYZ = observer()[1].astype(np.float32)


def wavelength(context, settings, inputs):
    """settings: to_rgb, float32 (3, 3), of CIE XYZ to the working space; nothing below 0"""
    place = (np.nan_to_num(inputs["Wavelength"]) - np.float32(FIRST_NM)) / np.float32(STEP_NM)
    last = len(_XYZ) - 1
    # Cycles cuts off the fraction: a step before the first row goes on from that.
    seen = column((place > -1.0) & (place < last))
    row = np.clip(place, 0.0, last - 1).astype(np.int32)
    part = column(place - row)
    xyz = (1.0 - part) * _XYZ[row] + part * _XYZ[row + 1]
    color = np.maximum(xyz @ settings["to_rgb"].T * np.float32(_SCALE), 0.0)
    return {"Color": np.where(seen, color, 0.0).astype(np.float32)}


FUNCTIONS = {"ShaderNodeWavelength": wavelength}
