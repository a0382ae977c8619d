"""The surfaces of which data passes tell: the first of a ray that is as opaque as they ask for.

Cycles writes Normal, UV, Vector, Depth, Position and the indices of that surface, whole, whatever
becomes of the ray there; the picture draws where a ray ends. So where both differ, rays are looked
through once more. What lies behind thinner surfaces counts as often as Cycles' rays arrive there:
these choose among a surface's closures by their colors, and from the third surface on end by chance
where little light is left.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..bsdf.sheen import diffuse_colors
from ..data.rows import row_means
from ..geometry.shading import ShadingPoints
from ..scene import Scene
from ..see_through.cutouts import CrossedSurface
from ..surfaces.seen_points import with_all_lobes

_SURE = 2  # surfaces behind which Cycles' rays may end by chance


class WholeSurfaces(NamedTuple):
    """What data passes have of rays.

    own: float32 (n,), 1 of the points where rays have ended that count, 0 of others
    points, weight: those that count in their place, and float32 (k,) as how much
    panes, taken: those that rays have gone through, which show nothing, and float32 (m, 3), what
        they have taken of all light
    ray: int (m,), of the panes
    """

    own: np.ndarray
    points: ShadingPoints
    weight: np.ndarray
    panes: ShadingPoints
    taken: np.ndarray
    ray: np.ndarray

    def at(self, which: np.ndarray) -> WholeSurfaces:
        """Of some of the points where rays have ended."""
        return self._replace(own=self.own[which])

    def of_pixels(self, pixels: np.ndarray, inside: np.ndarray) -> WholeSurfaces:
        """With pixels in place of rays; inside: bool, of each pixel, those that are wanted."""
        found = []
        for points, *own in ((self.points, self.weight), (self.panes, self.taken, self.ray)):
            points = points._replace(pixel=pixels[points.pixel])
            wanted = inside[points.pixel]
            found += [points.at(wanted), *(column[wanted] for column in own)]
        return WholeSurfaces(self.own, *found)


def whole_surfaces(
    scene: Scene,
    points: ShadingPoints,
    crossed: list[CrossedSurface],
    n: int,
    look: Callable[[np.ndarray, list], ShadingPoints],
) -> WholeSurfaces:
    """Of n rays, which have ended at points.

    crossed: of cutouts.points_through
    look: of rays, int (m,), the points where they meet what is opaque enough, and what they cross
    """
    panes = [step.at(step.goes & (step.opacity > 0.0) & ~step.is_drawn) for step in crossed]
    taken = np.concatenate([step.points.through * (1.0 - step.color) for step in panes])
    panes = ShadingPoints(*map(np.concatenate, zip(*(step.points for step in panes), strict=True)))
    rays = np.flatnonzero(_are_looked_through_again(scene.asked.solid, crossed, n))
    own = np.ones(len(points.pixel), np.float32)
    if not len(rays):
        none = points.at(slice(0)), np.zeros(0, np.float32)
        return WholeSurfaces(own, *none, panes, taken, panes.pixel)
    own[np.isin(points.pixel, rays)] = 0.0
    crossed = []
    found = look(rays, crossed)
    weight = _arriving(scene, crossed, found, len(rays))[found.pixel]
    found = found._replace(pixel=rays[found.pixel])
    return WholeSurfaces(own, found, weight, panes, taken, panes.pixel)


def _are_looked_through_again(solid, crossed, n) -> np.ndarray:
    """bool (n,): the rays that end elsewhere, or whose weight is another one."""
    again = np.zeros(n, np.bool_)
    if solid is None:
        return again
    for step in crossed:
        thin = step.opacity < np.float32(solid)
        counts = step.is_drawn | ((step.opacity > 0.0) & (step.points.passed >= _SURE - 1))
        again[step.points.pixel[(thin != step.goes) | (thin & counts)]] = True
    return again


def _arriving(scene: Scene, crossed, found: ShadingPoints, n: int) -> np.ndarray:
    """float32 (n,): the probability that Cycles' rays arrive where rays go through what they have
    crossed, and meet what is found."""
    arriving, light = np.ones(n, np.float32), np.ones((n, 3), np.float32)

    def end_by_chance(rays):
        left = np.sqrt(np.clip(light[rays].max(axis=1), 0.0, 1.0))
        arriving[rays] *= left
        light[rays] /= np.maximum(left, np.float32(1e-6))[:, None]

    for number, step in enumerate(crossed):
        own = step.at(step.goes)
        rays = own.points.pixel
        if number >= _SURE:
            end_by_chance(rays)
        going, drawn = np.ones(len(rays), np.float32), own.is_drawn
        going[drawn] = _going_on(scene, own.at(drawn))
        arriving[rays] *= going
        light[rays] *= own.color / np.maximum(going, np.float32(1e-6))[:, None]
    passed = np.where(found.passed < 0, ~found.passed, found.passed)
    end_by_chance(found.pixel[passed >= _SURE])
    return arriving


def _going_on(scene: Scene, crossed: CrossedSurface) -> np.ndarray:
    """float32 (n,): the probability that Cycles' rays go on."""
    points, opacity = crossed.points, crossed.opacity
    if not len(opacity):
        return opacity
    points = points._replace(through=np.ones_like(points.through))
    reflected = np.zeros(len(opacity), np.float32)
    for layer in with_all_lobes(scene, points):
        lobes = layer.seen.lobes
        color = diffuse_colors(lobes) if layer.color is None else layer.color
        reflected[layer.of] += row_means(color + lobes.glossy_color)
    passing = np.float32(1.0) - opacity
    return passing / (passing + opacity * np.maximum(reflected, np.float32(0.0)))
