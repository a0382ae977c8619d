"""The roughness of what a tile's points show, as Cycles bakes it: the mean over their BSDFs.

Each counts by its weight, gloss before its Fresnel factor. Perfectly matte ones have no roughness
and do not count; where there is no other it is 1.
"""

from __future__ import annotations

import math

import numpy as np

from ..bsdf.lobe_setup import setup_lobes
from ..bsdf.lobes import Lobes
from ..geometry.shading import ShadingPoints, params_at
from ..scene import Scene
from .surface import closure_layers

_K = math.pi / 2.0 - 2.0 / 3.0  # of rough_diffuse.py


class TileRoughness:
    """Of n pixels of one tile."""

    layer = "roughness"

    def __init__(self, n: int):
        self._sum, self._hits = np.zeros((2, n))

    def add(self, scene: Scene, points: ShadingPoints, place: np.ndarray, weight=None) -> None:
        """See SurfacePasses.add; weight: (k,), None = 1."""
        rough, shares = np.zeros((2, len(place)))
        for of, lobes in _lobes_of(scene, points):
            for own, share in _roughnesses(lobes):
                rough[of] += share * own
                shares[of] += share
        mean = np.divide(rough, shares, out=np.ones_like(rough), where=shares > 0.0)
        weight = 1.0 if weight is None else weight
        np.add.at(self._sum, place, mean * weight)
        np.add.at(self._hits, place, weight)

    def values(self, rows, passes: np.ndarray) -> np.ndarray:
        """(k, 1): the layer of the pixels ``rows``."""
        return (self._sum[rows] / np.maximum(self._hits[rows], 1.0))[:, None]


def _lobes_of(scene: Scene, points: ShadingPoints):
    """(int (m,) rows of points, their lobes) of each closure that points mix."""
    if scene.shaders is not None:
        return [(own.of, own.lobes) for own in closure_layers(scene, points)]
    params = params_at(scene.materials, scene.mesh.material_index[points.triangle])
    own = points.normal, points.geometric_normal, points.wo
    return [(np.arange(len(points.pixel)), setup_lobes(params, *own, scene.measured))]


def _roughnesses(lobes: Lobes):
    """(roughness, weight), float64 (n,), of gloss, and of what is matte and rough."""
    alpha = lobes.alpha.astype(np.float64)
    across = np.where(lobes.narrow > 0.0, lobes.narrow, alpha)
    gloss = lobes.weight.sum(axis=1).mean(axis=1, dtype=np.float64)
    yield (alpha * across) ** 0.25, gloss
    b = np.clip(lobes.rough[:, 3].astype(np.float64), 0.0, None)
    matte = np.where(b > 0.0, lobes.diffuse.mean(axis=1, dtype=np.float64), 0.0)
    yield math.pi * b / (math.pi - _K * b), matte
