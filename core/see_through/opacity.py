"""What cut-outs let through, on a grid over each triangle: so that a shadow ray can ask Embree.

A leaf is a card with an image of its alpha. Its program is evaluated once, at the corners of R^2
small triangles on each triangle, about as far apart as the texels that it looks up; triangles
that look up the same texels share a grid. Embree's filter (embree_filter.py) interpolates between
the corners. What depends on the angle between ray and normal, and on the side that is met
(Fresnel, Backfacing, ...), has a grid for each of some angles; what depends on the ray in other
ways has none (docs/decisions/0022-closures-and-cut-outs.md).
"""

from __future__ import annotations

import itertools

import numpy as np

from ..data.program import Program
from ..data.program_ops import (
    COORDINATES,
    is_of_corners,
    ops_behind,
    passes_alike,
    passes_by_place,
)
from ..embree.opacity_grids import ANGLES, BENDS, Opacity
from ..geometry.round_points import is_round
from ..nodes import Evaluation, ShadeContext
from ..nodes.values import normalized
from ..scene import Scene
from .cutouts import passing_color, share_of

# Grids are as fine as this at the most; more corners than this are not made for one material: some
# seconds of work, and as many bytes. Coarser ones that have more are not worth the name.
FINEST = 512
MOST_CORNERS = 1 << 24
# Where no image says how fine the pattern is: steps along an edge, of many triangles at the most
# and at the least, and about how many corners all triangles get together, of few half of that.
_PROCEDURAL, _COARSEST, _CORNERS = 64, 4, 1 << 20
# Of neighbouring corners, those of which one is open and the other is not: with more the pattern is
# as fine as the grid. Places aside of the corners then keep its mean, if not its threads.
_ROUGH = 0.1
# What texels show bends between them: where few corners do, so many steps to a texel.
_WITHIN_TEXEL = 4
_POINTS_AT_ONCE = 1 << 18


def bake_opacity(scene: Scene, triangles: np.ndarray, colored: bool = True) -> Opacity:
    """Grids for some triangles, bool (m,), whose materials have programs that can be baked.

    A material that would need more than MOST_CORNERS gets coarser ones, or none.
    colored: whether the grids may be; they are if some material lets one color through more than
        another
    """
    materials = scene.mesh.material_index
    row = np.full(len(materials), -1, np.int32)
    sides, values, angled = [np.zeros(0, np.int32)], [], [np.zeros(0, np.uint8)]
    n = 0
    for material in np.unique(materials[triangles]):
        program = scene.shaders.programs[material]
        which = np.flatnonzero(triangles & (materials == material)).astype(np.int32)
        first, again = _shared(scene, program, which)
        angles = _angles(program)
        fine = _sides(scene, program, which[first])
        side = _that_fit(fine, MOST_CORNERS // len(angles))
        if side is None:
            continue
        coarse = bool((side < fine).any())
        order = np.argsort(side, kind="stable")
        place = np.empty(len(order), np.int32)
        place[order] = np.arange(len(order))
        row[which] = n + place[again]
        first, side = first[order], side[order]
        for size in np.unique(side):
            own = program, which[first[side == size]], int(size), colored, angles
            grids = _grids(scene, *own, aside=coarse)
            if not (coarse or _has_images(program)) and _is_rough(grids):
                grids = _grids(scene, *own, aside=True)
            values.append(grids)
        sides.append(side)
        angled.append(np.full(len(side), len(angles) > 1, np.uint8))
        n += len(side)
    if all((grids == grids[:, :1]).all() for grids in values):
        values, colored = [grids[:, :1] for grids in values], False
    side, by_angle = np.concatenate(sides), np.concatenate(angled)
    sizes = _corners(side.astype(np.int64)) * np.where(by_angle, ANGLES, 1) * (3 if colored else 1)
    whole = np.concatenate([np.zeros(0, np.uint8), *(grids.ravel() for grids in values)])
    normals = scene.mesh.corner_normals if by_angle.any() else np.zeros((0, 3, 3), np.float32)
    return Opacity(row, np.cumsum(sizes) - sizes, side, whole, by_angle, normals, colored)


def _angles(program: Program) -> list[tuple[float, bool] | None]:
    """(cosine to the normal, whether the back is met) of the rays of each grid; None: straight."""
    if passes_by_place(program):
        return [None]
    cosines = (np.arange(BENDS + 1) / BENDS) ** 2
    return [(float(cosine), back) for back in (False, True) for cosine in cosines]


def _context(scene: Scene, triangle, barycentric, angle=None) -> ShadeContext:
    """Places on triangles, met by a shadow ray. angle: of _angles; None: from straight above"""
    mesh, shaders = scene.mesh, scene.shaders
    u, v = barycentric[:, :1], barycentric[:, 1:]
    weights = 1.0 - u - v, u, v
    a, b, c = (mesh.vertices[corner] for corner in mesh.triangles[triangle].T)
    position = sum(w * corner for w, corner in zip(weights, (a, b, c), strict=True))
    normals = mesh.corner_normals[triangle]
    normal = normalized(sum(w * normals[:, k] for k, w in enumerate(weights)))
    face = normalized(np.cross(b - a, c - a))
    wo = face
    if angle is not None:
        cosine, back = angle
        normal, face = (-normal, -face) if back else (normal, face)
        least = np.abs(normal).argmin(axis=1)
        aside = normalized(np.cross(normal, np.eye(3, dtype=np.float32)[least]))
        wo = np.float32(cosine) * normal + np.float32((1.0 - cosine * cosine) ** 0.5) * aside
    own = shaders.material_pass_index, triangle, barycentric, position, wo, normal, face, True
    return ShadeContext(mesh, shaders.surface, scene.camera, *own)


def _shared(scene: Scene, program: Program, which) -> tuple[np.ndarray, np.ndarray]:
    """(rows of ``which`` that have a grid of their own, for each of which the grid that it has)."""
    ops = ops_behind(program, program.transparent)
    alone = np.arange(len(which))
    alike = passes_alike(program)
    if not (alike or all(is_of_corners(op) for op in ops)):
        return alone, alone
    surface = scene.shaders.surface
    rows = surface.row[which]
    columns = [surface.mirrored[scene.mesh.object_index[which]][:, None], (rows < 0)[:, None]]
    columns += [is_round(scene, which)[:, None]]
    if not alike:
        columns += [table[rows].reshape(len(rows), -1) for table in surface.tables.values()]
    keys = np.concatenate([np.asarray(c, np.float32) for c in columns], axis=1)
    _, first, again = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return first, again.ravel().astype(np.int32)


def _has_images(program: Program) -> bool:
    """Whether images say how fine its grids are to be."""
    return any(op.kind == "ShaderNodeTexImage" for op in ops_behind(program, program.transparent))


def _is_rough(grids: np.ndarray) -> bool:
    """Whether a pattern is as fine as its grids, uint8 (n, channels, corners)."""
    differs = np.abs(np.diff(grids.astype(np.int16), axis=-1)) > 127
    return bool(differs.mean() > _ROUGH)


def _sides(scene: Scene, program: Program, triangles) -> np.ndarray:
    """int32 (n,): R of each grid, a power of two, by the texels that its images have there."""
    n = len(triangles)
    if passes_alike(program):
        return np.ones(n, np.int32)
    corners = np.tile(np.float32([[0, 0], [1, 0], [0, 1]]), (n, 1))
    context = _context(scene, np.repeat(triangles, 3), corners)
    evaluation, wanted = Evaluation(program, context), np.ones(n)
    for op in ops_behind(program, program.transparent):
        if op.kind == "ShaderNodeTexImage" and op.settings["image"] is not None:
            size = max(max(t.shape[:2]) for t in op.settings["image"].tiles.values())
            vector = op.inputs.get("Vector")
            place = context.uv() if vector is None else evaluation.vector(vector)
            spread = np.ptp(place.reshape(n, 3, 3), axis=1).max(axis=1)
            wanted = np.maximum(wanted, np.nan_to_num(spread) * size)
        elif op.settings.get("outputs") and op.kind not in COORDINATES:
            wanted = np.maximum(wanted, _steps(n))
    if wanted.max() == 1.0 and not isinstance(program.transparent, np.ndarray):
        wanted[:] = _steps(n)
    sides = (2.0 ** np.ceil(np.log2(np.clip(wanted, 1.0, FINEST)))).astype(np.int64)
    finer = np.maximum(sides, np.minimum(_WITHIN_TEXEL * sides, _PROCEDURAL))
    few = (wanted > 1.0).any() and _corners(finer).sum() <= _CORNERS
    return (finer if few else sides).astype(np.int32)


def _steps(n: int) -> float:
    """Along an edge, where nothing says how fine the pattern of n triangles is.

    A curtain of two triangles has hundreds of threads: with 64 steps its pattern was met in step,
    and let through half as much again, or less by a third.
    """
    few = (_CORNERS / (2.0 * n)) ** 0.5
    if few > _PROCEDURAL:
        return min(few, FINEST)
    return float(np.clip((2 * _CORNERS / n) ** 0.5, _COARSEST, _PROCEDURAL))


def _that_fit(side: np.ndarray, corners: int) -> np.ndarray | None:
    """Sides, int32 (n,), of so many corners in all at the most; None: there are too many."""
    while _corners(side.astype(np.int64)).sum() > corners:
        if side.max() <= _COARSEST:
            return None
        side = np.maximum(side // 2, 1)
    return side


def _corners(side):
    """Of the small triangles of a grid."""
    return (side + 1) * (side + 2) // 2


def _grids(
    scene: Scene, program: Program, triangles, side: int, colored: bool, angles, aside: bool = False
) -> np.ndarray:
    """uint8 (n, 3 if colored else 1, angles, corners): what passes at the corners of the small
    triangles of n triangles. angles: of _angles; aside: up to half a step from them, at random"""
    v, u = np.divmod(np.arange((side + 1) ** 2), side + 1)
    places = np.stack([u, v], -1)[u + v <= side]
    if aside:
        places = places + np.random.default_rng(side).uniform(-0.5, 0.5, places.shape)
    places = (places / side).astype(np.float32)
    many = np.repeat(triangles, len(places))
    out = np.empty((len(angles), len(many), 3 if colored else 1), np.uint8)
    step = max(_POINTS_AT_ONCE // len(places), 1) * len(places)
    for first, (row, angle) in itertools.product(range(0, len(many), step), enumerate(angles)):
        some = many[first : first + step]
        barycentric = np.tile(places, (len(some) // len(places), 1))
        evaluation = Evaluation(program, _context(scene, some, barycentric, angle))
        passing = passing_color(program, evaluation)
        passing = np.minimum(passing, 1.0) if colored else share_of(passing)[:, None]
        # A ray goes through a point or strand by two faces, by which it passes once in Cycles:
        # the front's, which is the one of all where the angle does not matter.
        round_ = is_round(scene, some)[:, None]
        once = np.sqrt(passing) if angle is None else 1.0 if angle[1] else passing
        passing = np.where(round_, once, passing)
        out[row, first : first + step] = np.rint(passing * 255.0)
    return out.reshape(len(angles), len(triangles), len(places), -1).transpose(1, 3, 0, 2)
