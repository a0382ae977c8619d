"""Depth of field: points of the aperture, and how wide what is out of focus gets."""

import numpy as np

from .._jit import kernel
from ..scene import ORTHOGRAPHIC, PANORAMIC, Camera
from .panorama import pixel_angle


@kernel
def aperture_point(u, v, blades, rotation):
    """(x, y) in the unit disc, or in the regular polygon inscribed in it from 3 blades on.

    Area is kept, and points that are near stay near [Shirley97]; the polygon's has each sector of
    the disc for one of its triangles. The first corner is at rotation - pi / blades.
    """
    a, b = 2.0 * u - 1.0, 2.0 * v - 1.0
    if a == 0.0 and b == 0.0:
        return 0.0, 0.0
    if np.abs(a) > np.abs(b):
        r, turn = a, 0.125 * (b / a)
    else:
        r, turn = b, 0.25 - 0.125 * (a / b)
    if blades < 3:
        return r * np.cos(2.0 * np.pi * turn), r * np.sin(2.0 * np.pi * turn)
    if r < 0.0:
        r, turn = -r, turn + 0.5
    place = (turn - np.floor(turn)) * blades
    side = np.floor(place)
    part, step = place - side, 2.0 * np.pi / blades
    first = rotation + (side - 0.5) * step
    second = first + step
    x = (1.0 - part) * np.cos(first) + part * np.cos(second)
    y = (1.0 - part) * np.sin(first) + part * np.sin(second)
    return r * x, r * y


def blur_widths(camera: Camera, depth: np.ndarray) -> np.ndarray:
    """float64 (n,): pixels that a point is spread over by the lens.

    depth: metres, as camera.view_depth counts them; infinite for the world
    """
    lens = camera.lens
    if lens is None:
        return np.zeros(len(depth))
    left, right, _, _ = camera.window
    pixel = pixel_angle(camera) if camera.kind == PANORAMIC else (right - left) / camera.width
    if camera.kind == ORTHOGRAPHIC:
        spread = np.abs(1.0 - depth / lens.focus)
    else:
        spread = np.abs(1.0 / np.maximum(depth, 1e-9) - 1.0 / lens.focus)
    return 2.0 * lens.radius * max(1.0, 1.0 / lens.ratio) * spread / abs(pixel)
