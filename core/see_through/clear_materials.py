"""Which materials let rays through; for exporters as well, which load without numba."""

from __future__ import annotations

import numpy as np

from ..scene import Scene


def cut_materials(scene: Scene) -> np.ndarray | None:
    """bool, one a material: whether rays may go through; None: all are opaque."""
    if scene.shaders is None:
        return None
    cut = [p is not None and p.transparent is not None for p in scene.shaders.programs]
    return np.array(cut, np.bool_) if any(cut) else None
