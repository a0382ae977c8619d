"""The Gabor Texture node: waves of one length, in one direction or in many."""

from __future__ import annotations

import numpy as np

from .noise import noise_place
from .values import as_number, as_vector, clipped, length, normalized, vector

_LEAST_FREQUENCY = np.float32(0.001)


def gabor(context, settings, inputs):
    """settings: gabor_type, 2D or 3D"""
    from ..textures import gabor as kernels  # the exporters load without numba

    n = len(context)
    place = noise_place(context, inputs, settings["gabor_type"])
    p = np.ascontiguousarray(place * as_number(inputs["Scale"], n), np.float32)
    frequency = np.maximum(as_number(inputs["Frequency"], n), _LEAST_FREQUENCY)
    isotropy = as_number(1.0 - clipped(inputs["Anisotropy"]), n)
    room = np.empty((4, kernels.IMPULSES), np.float32), np.empty((2, n), np.float32)
    if settings["gabor_type"] == "2D":
        angle = as_number(inputs["Orientation 2D"], n)
        kernels.gabor_2d(p[0], p[1], frequency, isotropy, angle, *room)
    else:
        direction = normalized(as_vector(inputs["Orientation 3D"], n))
        kernels.gabor_3d(p, frequency, isotropy, np.ascontiguousarray(direction.T), *room)
    cosine, sine = room[1]
    turn = (np.arctan2(sine, cosine) + np.float32(np.pi)) / np.float32(2.0 * np.pi)
    return {
        "Value": 0.5 * sine + 0.5,
        "Phase": turn,
        "Intensity": length(vector(cosine, sine, 0.0 * sine)),
    }


FUNCTIONS = {"ShaderNodeTexGabor": gabor}
