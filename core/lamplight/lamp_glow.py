"""Lamps as the camera sees them: they add their light along its rays, and hide nothing.

So does Cycles, where a ray goes on behind a lamp: what is behind it, and alpha, stay as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..camera.camera import CameraRays
from ..data.lamps import BY_CAMERA, MESH, Lamps
from ..see_through.cutouts import PassedPanes
from .lamp_falloff import falloff_at
from .lamp_pictures import tint_at
from .lamp_shapes import meet_lamp


def shown_lamps(lamps: Lamps) -> Lamps | None:
    """Those that the camera sees, which have a size, but meshes, which are there; None: none is."""
    shown = (lamps.seen_by & BY_CAMERA != 0) & (lamps.size[:, 0] > 0.0) & (lamps.kind < MESH)
    return lamps.at(shown) if shown.any() else None


class _Panes(NamedTuple):
    """Surfaces before and behind lamps, ray by ray.

    first: int64 (n_rays + 1,), of each ray its first row, then that of the next one; far, color: of
    cutouts.PassedPanes
    """

    first: np.ndarray
    far: np.ndarray
    color: np.ndarray


def _by_ray(passed: list[PassedPanes], n: int) -> _Panes:
    if not passed:
        none = np.zeros(0, np.float32)
        return _Panes(np.zeros(n + 1, np.int64), none, none.reshape(0, 3))
    ray, far, color = map(np.concatenate, zip(*passed, strict=True))
    order = np.argsort(ray, kind="stable")
    first = np.searchsorted(ray[order], np.arange(n + 1))
    return _Panes(first, np.float32(far[order]), np.float32(color[order]))


def lamp_glow(
    lamps: Lamps, rays: CameraRays, points, n_groups: int = 0, passed: Sequence[PassedPanes] = ()
) -> np.ndarray:
    """float32 (n, 3 + 3 n_groups), radiance of the lamps that rays meet before they end: of all,
    and of those of each light group.

    points: ShadingPoints, where rays end; ``pixel`` is the row of the ray; passed: what they have
    gone through, which tints the lamps behind it
    """
    reach = np.full(len(rays.reach), np.inf, np.float32)
    away = points.position - rays.origins[points.pixel]
    reach[points.pixel] = np.sqrt(np.einsum("ij,ij->i", away, away))
    glow = np.zeros((len(reach), 3 + 3 * n_groups), np.float32)
    panes = _by_ray(list(passed), len(reach))
    _add_glow(lamps, rays.origins, rays.directions, reach, rays.reach, panes, glow)
    return glow


@kernel(forceinline=True)
def _float64(vectors, k):
    return np.float64(vectors[k, 0]), np.float64(vectors[k, 1]), np.float64(vectors[k, 2])


@kernel(forceinline=True)
def _color_before(panes, ray, far):
    """(r, g, b), what a ray brings of light from ``far`` away."""
    r, g, b = 1.0, 1.0, 1.0
    for k in range(panes.first[ray], panes.first[ray + 1]):
        if panes.far[k] < far:
            r, g, b = r * panes.color[k, 0], g * panes.color[k, 1], b * panes.color[k, 2]
    return r, g, b


@kernel
def _add_glow(lamps, origins, directions, reach, far_plane, panes, glow):
    for k in range(len(reach)):
        x, y, z = _float64(directions, k)
        if x * x + y * y + z * z == 0.0:
            continue
        px, py, pz = _float64(origins, k)
        for i in range(len(lamps.kind)):
            far, factor, _, _ = meet_lamp(lamps, i, px, py, pz, x, y, z, x, y, z, 0.0)
            near = far < far_plane[k] or far == np.inf
            if factor > 0.0 and near and (far < reach[k] or reach[k] == np.inf):
                column = 3 + 3 * lamps.group[i]
                tints = tint_at(lamps, i, px, py, pz, x, y, z, far)
                if lamps.falloff[i] >= 0:
                    by = falloff_at(lamps, i, far)
                    tints = tints[0] * by[0], tints[1] * by[1], tints[2] * by[2]
                through = _color_before(panes, k, far)
                for a in range(3):
                    own = np.float64(lamps.radiance[i, a]) * factor
                    light = np.float32(own * tints[a] * through[a])
                    glow[k, a] += light
                    if 3 <= column < glow.shape[1]:
                        glow[k, column + a] += light
