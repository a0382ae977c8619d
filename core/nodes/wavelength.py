"""Colors of single wavelengths, as Cycles has them: CIE's observer of 1931, and a scale.

The table is that of the 2 degree observer from 380 to 780 nm, every 5 nm, in parts of 10 000 as it
is printed; between two rows it is linear.
"""

from __future__ import annotations

import numpy as np

from .values import column

_SHORTEST, _STEP = 380.0, 5.0
_SCALE = 1.0 / 2.52  # Cycles' own
_X = (
    "14 22 42 76 143 232 435 776 1344 2148 2839 3285 3483 3481 3362 3187 2908 2511 1954 1421 "
    "956 580 320 147 49 24 93 291 633 1096 1655 2257 2904 3597 4334 5121 5945 6784 7621 8425 "
    "9163 9786 10263 10567 10622 10456 10026 9384 8544 7514 6424 5419 4479 3608 2835 2187 "
    "1649 1212 874 636 468 329 227 158 114 81 58 41 29 20 14 10 7 5 3 2 2 1 1 1 0"
)
_Y = (
    "0 1 1 2 4 6 12 22 40 73 116 168 230 298 380 480 600 739 910 1126 1390 1693 2080 2586 "
    "3230 4073 5030 6082 7100 7932 8620 9149 9540 9803 9950 10000 9950 9786 9520 9154 8700 "
    "8163 7570 6949 6310 5668 5030 4412 3810 3210 2650 2170 1750 1382 1070 816 610 446 320 "
    "232 170 119 82 57 41 29 21 15 10 7 5 4 2 2 1 1 1 0 0 0 0"
)
_Z = (
    "65 105 201 362 679 1102 2074 3713 6456 10391 13856 16230 17471 17826 17721 17441 16692 "
    "15281 12876 10419 8130 6162 4652 3533 2720 2123 1582 1117 782 573 422 298 203 134 87 57 "
    "39 27 21 18 17 14 11 10 8 6 3 2 2 1 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 "
    "0 0 0 0 0"
)
_XYZ = np.stack([np.array(row.split(), np.float32) for row in (_X, _Y, _Z)], -1) * np.float32(1e-4)


def wavelength(context, settings, inputs):
    """settings: to_rgb, float32 (3, 3), of CIE XYZ to the working space; nothing below 0"""
    place = (np.nan_to_num(inputs["Wavelength"]) - np.float32(_SHORTEST)) / np.float32(_STEP)
    last = len(_XYZ) - 1
    # Cycles cuts off the fraction: a step before the first row goes on from that.
    seen = column((place > -1.0) & (place < last))
    row = np.clip(place, 0.0, last - 1).astype(np.int32)
    part = column(place - row)
    xyz = (1.0 - part) * _XYZ[row] + part * _XYZ[row + 1]
    color = np.maximum(xyz @ settings["to_rgb"].T * np.float32(_SCALE), 0.0)
    return {"Color": np.where(seen, color, 0.0).astype(np.float32)}


FUNCTIONS = {"ShaderNodeWavelength": wavelength}
