"""What a bake looks at, as plain data: a point of a surface for each texel of an image."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class BakePoints(NamedTuple):
    """Points of one object, in place of what a camera's rays meet (bake_rays.py).

    mesh: the scene's TriangleMesh; triangle: int32 (h, w), its rows, -1 = the texel shows nothing;
        row 0 is the image's lowest
    weights: float32 (h, w, 2), of the first and the second corner, at the texel's centre
    steps: float32 (h, w, 4), what the first weight changes by from a texel to the next one to the
        right and to the next one above, and the second
    mirrored: whether the object's winding was turned round, so that these corners are the
        triangle's first and third
    from_camera: whether points are seen from where the camera is, else from along their normals
    """

    mesh: object
    triangle: np.ndarray
    weights: np.ndarray
    steps: np.ndarray
    mirrored: bool = False
    from_camera: bool = False
