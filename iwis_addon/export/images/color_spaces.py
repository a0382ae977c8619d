"""The file's working space of colors, and sRGB's curve."""

from __future__ import annotations

import bpy
import numpy as np

WORKING_SPACE_OF_4 = "Linear Rec.709"
# Y of the primaries, as Cycles has them: ACEScg's are adapted to the white of D65.
_LUMINANCE = {
    "Linear Rec.709": (0.2126, 0.7152, 0.0722),
    "Linear Rec.2020": (0.2627, 0.6780, 0.0593),
    "ACEScg": (0.26767, 0.67434, 0.05799),
}


def working_space() -> str:
    """Blender 5 lets a file choose its scene-linear space; it was Linear Rec.709 before."""
    settings = getattr(bpy.data, "colorspace", None)
    return getattr(settings, "working_space", WORKING_SPACE_OF_4)


def luminance_of_channels() -> np.ndarray:
    """float32 (3,): what red, green and blue of the working space bring of CIE Y."""
    return np.float32(_LUMINANCE.get(working_space(), _LUMINANCE[WORKING_SPACE_OF_4]))


def srgb_decode(encoded: np.ndarray) -> np.ndarray:
    """Linear float32 of sRGB."""
    curve = ((np.maximum(encoded, 0.0) + 0.055) / 1.055) ** 2.4
    return np.where(encoded <= 0.04045, encoded / 12.92, curve).astype(np.float32)


def srgb_encode(linear: np.ndarray) -> np.ndarray:
    """sRGB of linear values: what was decoded before."""
    curve = 1.055 * np.maximum(linear, 0.0) ** np.float32(1.0 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, linear * np.float32(12.92), curve)


def srgb_decode_bytes(encoded: np.ndarray) -> np.ndarray:
    """The same of the 256 levels of a byte, by a table."""
    levels = srgb_decode(np.arange(256) / 255.0)
    return levels[np.rint(encoded * 255.0).astype(np.uint8)]
