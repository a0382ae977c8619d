"""Surfaces that let a part of the rays through: leaves, fences, mixtures with Transparent BSDF.

Whether a ray goes on is drawn, with the share that the material lets through as probability; so a
ray is never split. The camera's rays always go on through a pane, which shows nothing itself.
Shadow rays that ask Embree alone (opacity.py) draw for each color; those here are yes or no. What
does not let a ray through is brighter by the inverse of the probability of that
(docs/decisions/0022-closures-and-cut-outs.md).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.program import Program
from ..data.rows import any_in_row, row_means, rows_of
from ..embree.embree_hits import Gone, begin_rays
from ..geometry.poses import points_at_rest, posed_points
from ..geometry.round_points import is_round
from ..geometry.shading import ShadingPoints, points_within
from ..nodes import Evaluation, ShadeContext
from ..scene import BLACK, Scene
from .clear_materials import cut_materials

# Above, a surface that is drawn all the same is not made brighter: there is nothing to be seen.
_ALL = np.float32(0.9999)


class PassedPanes(NamedTuple):
    """Surfaces that rays have gone through.

    ray: int (n,); far: float32 (n,), metres from its origin; color: float32 (n, 3), what it brings
    of what lies behind
    """

    ray: np.ndarray
    far: np.ndarray
    color: np.ndarray


class CrossedSurface(NamedTuple):
    """Surfaces that rays meet and that let a part of them through.

    points: with what comes there of the light as ``through``; color: float32 (n, 3), what goes on
    going: float32 (n,), the probability that a ray does; goes: bool (n,), whether it has
    """

    points: ShadingPoints
    color: np.ndarray
    going: np.ndarray
    goes: np.ndarray

    def at(self, which: np.ndarray) -> CrossedSurface:
        """Some of them."""
        return CrossedSurface(self.points.at(which), *rows_of(self[1:], which))

    @property
    def opacity(self) -> np.ndarray:
        """float32 (n,): what they take."""
        return np.float32(1.0) - share_of(self.color)

    @property
    def is_drawn(self) -> np.ndarray:
        """bool (n,): whether rays may end there, or go on."""
        return (self.opacity > 0.0) & (self.going < 1.0)


def opacity_gain(
    program: Program, evaluation: Evaluation, passed: np.ndarray
) -> np.ndarray | np.float32:
    """Factor of what a surface shows where it has stopped a ray: float32 (n, 1), or 1.

    passed: of ShadingPoints; where a ray could not go on nothing was drawn
    """
    if program.transparent is None and program.holdout is None:
        return np.float32(1.0)
    passing = np.zeros(len(passed), np.float32)
    if program.transparent is not None:
        passing = going_share(program, evaluation)
    if program.holdout is not None:
        passing = passing + row_means(evaluation.vector(program.holdout))
    drawn = (passing < _ALL) & (passed >= 0)
    return np.where(drawn, 1.0 / (1.0 - np.minimum(passing, _ALL)), 1.0)[:, None]


def passing_shares(scene: Scene, points: ShadingPoints, shadow: bool = False) -> np.ndarray:
    """float32 (n,): the probability that a ray goes on at each of its points.

    shadow: whether they are shadow rays, which a material may be told (Light Path)
    """
    return share_of(_passing_colors(scene, points, shadow)[0])


def _passing_colors(
    scene: Scene, points: ShadingPoints, shadow: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Of each point float32 (n, 3): what goes on; (n,): the probability that a camera's ray does,
    which is 1 on a pane."""
    colors = np.zeros((len(points.pixel), 3), np.float32)
    going = np.zeros(len(colors), np.float32)
    rows = scene.mesh.material_index[points.triangle]
    for row in np.unique(rows):
        program = scene.shaders.programs[row]
        if program is not None and program.transparent is not None:
            which = np.flatnonzero(rows == row)
            at_rest = points_at_rest(scene.pose, scene.mesh, points.at(which))
            there = None if shadow else points.at(which)
            context = ShadeContext.of_points(scene, at_rest, shadow, there)
            evaluation = Evaluation(program, context)
            color = passing_color(program, evaluation)
            share = any_in_row(color) if _is_pane(program) else going_share(program, evaluation)
            # Of points and strands Cycles' rays meet the front alone: what goes in goes out behind.
            backs = is_round(scene, points.triangle[which]) & (context.backfacing != 0.0)
            colors[which] = np.where(backs[:, None], np.float32(1.0), color)
            going[which] = np.where(backs, np.float32(1.0), share)
    return colors, going


def _is_pane(program: Program) -> bool:
    """Whether a material that lets rays through shows nothing itself: a lone Transparent BSDF."""
    own = program.emission is not None or program.holdout is not None
    return not own and all(closure.model == BLACK for closure in program.closures)


def passing_color(program: Program, evaluation: Evaluation) -> np.ndarray:
    """float32 (n, 3): what goes on, at the points of an evaluation."""
    return np.maximum(evaluation.vector(program.transparent), 0.0)


def share_of(color: np.ndarray) -> np.ndarray:
    """Of a color that goes on, the probability: its mean, so the opacity of a film is Cycles'."""
    return np.clip(row_means(color), 0.0, 1.0)


def in_holes(scene: Scene, points: ShadingPoints) -> np.ndarray:
    """bool (n,): where a Holdout shader was drawn, by its share of what has stopped the ray."""
    share = hole_shares(scene, points)
    if not share.any():
        return np.zeros(len(share), np.bool_)
    x, y = (np.ascontiguousarray(points.position[:, axis]) for axis in (0, 1))
    return drawn_numbers(x, y, points.wo) < share


def hole_shares(scene: Scene, points: ShadingPoints) -> np.ndarray:
    """float32 (n,): the share of Holdout shaders in what has stopped the rays."""
    out = np.zeros(len(points.pixel), np.float32)
    programs = () if scene.shaders is None else scene.shaders.programs
    holes = [(k, p) for k, p in enumerate(programs) if p is not None and p.holdout is not None]
    if not holes:
        return out
    rows = scene.mesh.material_index[points.triangle]
    for row, program in holes:
        which = np.flatnonzero(rows == row)
        if not len(which):
            continue
        some = points.at(which)
        at_rest = points_at_rest(scene.pose, scene.mesh, some)
        evaluation = Evaluation(program, ShadeContext.of_points(scene, at_rest, there=some))
        share = row_means(evaluation.vector(program.holdout))
        if program.transparent is not None:
            share = share / np.maximum(1.0 - going_share(program, evaluation), 1e-6)
        out[which] = share
    return out


def going_share(program: Program, evaluation: Evaluation) -> np.ndarray:
    """float32 (n,): the probability that a camera's ray goes on, at the points of an evaluation.

    Where what passes and what shows are more than 1 together, a share of both: as the one is
    divided by this, and the other by the rest, either has all of its weight.
    """
    passing = share_of(passing_color(program, evaluation))
    if program.shown is None:
        return passing
    shown = np.maximum(row_means(evaluation.vector(program.shown)), 0.0)
    return passing / np.maximum(passing + shown, np.float32(1.0))


def points_through(
    scene: Scene,
    accel,
    origins: np.ndarray,
    directions: np.ndarray,
    reach: np.ndarray,
    dither: np.ndarray | None,
    most: int,
    tints: np.ndarray | None = None,
    hits: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None,
    passed: list[PassedPanes] | None = None,
    crossed: list[CrossedSurface] | None = None,
    solid: float | None = None,
) -> ShadingPoints:
    """The points where camera rays end; ``pixel`` is the row of the ray, ascending.

    reach: float32 (n,), metres from origins, beyond which nothing is seen
    dither: float (n,) in [0, 1): a ray goes on where it is below the share that passes; over that
        share it is the number for the next surface; None: through what is less opaque than solid
    most: of RenderSettings.transparent_max_bounces; of what a ray meets beyond these surfaces it
        shows what glows alone, as in Cycles
    tints: float32 (n, 3), of ones; gets ShadingPoints.through of each ray, those too that hit
        nothing in the end
    hits: what rays meet, as of accel.intersect, and nothing after that; None: it is asked
    passed, crossed: get what rays go through, and all that may let them
    solid: 0 to 1, None: half, and panes, which let all rays through
    """
    tints = np.ones((len(origins), 3), np.float32) if tints is None else tints
    slots = accel.slots(len(origins)) if hits is None else None
    gone = None if cut_materials(scene) is None else begin_rays(len(origins))
    met = accel.intersect(origins, directions, slots, gone) if hits is None else hits
    points = _points_met(scene, met, directions)
    points = points_within(points, origins, reach)
    if gone is None:
        return points
    ended, numbers = [], None if dither is None else np.array(dither, np.float64)
    for n in range(1, scene.shaders.passes_of_camera(most) + 1):
        color, passing = _passing_colors(scene, points, False)
        goes = _that_go_on(points, color, passing, numbers, solid)
        if crossed is not None:
            crossed.append(_crossed(points, color, passing, goes, tints))
        ended.append(points.at(~goes))
        points, colors = points.at(goes), color[goes] / passing[goes, None]
        tints[points.pixel] *= colors
        if passed is not None and len(points.pixel):
            passed.append(_passed(points, origins, colors))
        if hits is not None:  # nothing is met after those that were given
            points = points.at(slice(0))
        if not len(points.pixel):
            break
        rays = points.pixel, origins, directions, slots, gone
        points = points_within(_points_behind(scene, accel, *rays), origins, reach)
        points.passed[:] = n
    points.passed[:] = ~points.passed
    ended.append(points)
    found = ShadingPoints(*map(np.concatenate, zip(*ended, strict=True)))
    found = found.at(np.argsort(found.pixel, kind="stable"))
    return found._replace(through=tints[found.pixel])


def _points_met(scene: Scene, hits, directions) -> ShadingPoints:
    """The points of rays, float32 (n, 3), that hit something. hits: as of accel.intersect"""
    return posed_points(scene.pose, scene.mesh, *hits, directions, scene.terminator_offset)


def _that_go_on(points: ShadingPoints, color, passing, numbers, solid) -> np.ndarray:
    """bool (n,), at which points rays go on. color, passing: of _passing_colors

    numbers: float64, of all rays, those of rays that go on become the ones for the next surface; or
    None, and solid as of points_through
    """
    number = np.full(len(passing), 0.5) if numbers is None else numbers[points.pixel]
    goes = number < passing
    if numbers is not None:
        numbers[points.pixel[goes]] = number[goes] / passing[goes]
    elif solid is not None:
        opacity = np.float32(1.0) - share_of(color)
        goes = (opacity < np.float32(solid)) & (passing > 0.0)
    return goes


def _crossed(points: ShadingPoints, color, passing, goes, tints) -> CrossedSurface:
    """Those of the points that may let their rays through; tints: of all rays, before these."""
    met = CrossedSurface(points, color, passing, goes).at(share_of(color) > 0.0)
    return met._replace(points=met.points._replace(through=tints[met.points.pixel]))


def _points_behind(
    scene: Scene, accel, rays: np.ndarray, origins, directions, slots, gone: Gone
) -> ShadingPoints:
    """What some rays, int (k,), meet next; the other arrays are of all. gone: written to"""
    onward, own = directions[rays], gone.at(rays)
    hits = accel.intersect(origins[rays], onward, None if slots is None else slots[rays], own)
    gone.far[rays], gone.mark[rays] = own
    met = _points_met(scene, hits, onward)
    return met._replace(pixel=rays[met.pixel])


def _passed(points: ShadingPoints, origins, colors) -> PassedPanes:
    away = points.position - origins[points.pixel]
    return PassedPanes(points.pixel, np.sqrt(np.einsum("ij,ij->i", away, away)), colors)


def opacity_of(tints: np.ndarray) -> np.ndarray:
    """float32 (n,): the opacity of a film where rays with these tints have met nothing; below 0
    where a part of the rays has more than all of the light, for the others that have none."""
    return np.float32(1.0) - row_means(tints)


def drawn_numbers(u: np.ndarray, v: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """float64 (n,) in [0, 1): a hash of hits, the same for the same ray on every machine."""
    mixed = u.view(np.uint32) * np.uint32(0x9E3779B1) ^ v.view(np.uint32)
    for axis in range(3):
        bits = np.ascontiguousarray(directions[:, axis]).view(np.uint32)
        mixed = (mixed ^ bits) * np.uint32(0x85EBCA6B)
        mixed ^= mixed >> np.uint32(15)
    mixed *= np.uint32(0xC2B2AE35)
    mixed ^= mixed >> np.uint32(16)
    return mixed / 4294967296.0
