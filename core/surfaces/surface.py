"""Lobes of shading points whose materials vary over the surface: programs evaluated
(docs/decisions/0017-shader-programs.md, 0022-closures-and-cut-outs.md).

A row of Lobes holds one closure: the points of a mixture are taken once for each that is there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..bsdf.hair_setup import HairValues
from ..bsdf.lobes import Lobes, matte_alone
from ..bsdf.thin_film_setup import FilmValues
from ..data.program import Hair, Program, Subsurface, ThinFilm
from ..data.rows import any_in_row, row_means
from ..geometry.poses import points_at_rest, posed_normals
from ..geometry.round_points import is_round
from ..geometry.shading import ShadingPoints
from ..nodes import Evaluation, ShadeContext, surface_evaluation
from ..scene import DIFFUSE, GGX, TRANSLUCENT, Scene
from ..see_through.cutouts import opacity_gain
from ..walks.subsurface import Media, walked
from .closure_columns import ClosureValues, Columns

_VECTORS = ("base_color", "specular_tint")  # columns of MaterialParams
_NOWHERE = np.zeros(1, np.bool_)


def surface_lobes(scene: Scene, points: ShadingPoints) -> tuple[ShadingPoints, Lobes]:
    """The points, on the side that they shine from, and their lobes, float32, one row each: of
    several closures the one of the greatest weight, with the weight of all."""
    columns = Columns(scene, points)
    programs = scene.shaders.programs
    for which, number, context in _contexts(scene, points, programs):
        seen = which, points.passed[which], scene.pose
        layers, glow = _evaluate(programs[number], context, *seen, whole=True)
        columns.params.emission[which] = glow
        picked, layers = _heaviest(layers)
        for k, layer in enumerate(layers):
            here = picked == k
            columns.write(layer.at(here), which[here])
    columns.params.emission[:] *= points.through
    return columns.made()


class PointClosures(NamedTuple):
    """A closure of some points.

    of: int64 (m,), ascending, which points; points: these, on the side that they shine from
    media: what is under them, where that is to be walked through (random_walk.py); None: nothing
    """

    of: np.ndarray
    points: ShadingPoints
    lobes: Lobes
    media: Media | None = None


def closure_layers(scene: Scene, points: ShadingPoints) -> list[PointClosures]:
    """The closures of points in layers.

    The first layer has a closure of every point, and what glows; the next ones those of the points
    that have more; the last ones what of them is light from under the surface.
    """
    n = len(points.pixel)
    glow = scene.materials.emission[scene.mesh.material_index[points.triangle]]
    found: list[list[ClosureValues]] = [[]]
    under: list[list[ClosureValues]] = []
    programs = scene.shaders.programs
    for which, number, context in _contexts(scene, points, programs):
        unlit = _unlit_behind(scene, programs[number], points.triangle[which])
        seen = which, points.passed[which], scene.pose, unlit
        layers, glow[which] = _evaluate(programs[number], context, *seen)
        packed = _packed(layers)
        for kind, own in (
            (found, [layer for layer in packed if layer.media is None]),
            (under, [layer for layer in packed if layer.media is not None]),
        ):
            kind.extend([] for _ in range(len(own) - len(kind)))
            for into, layer in zip(kind, own, strict=False):
                into.append(layer)
    first = _written(scene, points, found[0], np.arange(n))
    first.lobes.emission[:] = glow * points.through
    rest = (layers for layers in (*found[1:], *under))
    return [first, *(_of_some(scene, points, layers) for layers in rest)]


def _unlit_behind(scene: Scene, program: Program, triangle: np.ndarray) -> np.ndarray:
    """bool (m,), or one for all: whether hair's closure for the side away from the viewer has no
    light, as the world's comes to the other one (hair.ALL_ROUND)."""
    if len(scene.lamps.kind) or all(closure.hair is None for closure in program.closures):
        return _NOWHERE
    return is_round(scene, triangle)


def _of_some(scene: Scene, points: ShadingPoints, layers: list[ClosureValues]) -> PointClosures:
    source = np.sort(np.concatenate([layer.which for layer in layers]))
    return _written(scene, points.at(source), layers, source)


def _written(scene: Scene, points: ShadingPoints, layers: list[ClosureValues], of) -> PointClosures:
    """Closures of the points ``of``, that do not glow."""
    columns = Columns(scene, points)
    columns.params.emission[:] = 0.0
    for layer in layers:
        columns.write(layer, np.searchsorted(of, layer.which))
    seen, lobes = columns.made()
    if not layers or layers[0].media is None:
        return PointClosures(of, seen, lobes)
    order = np.argsort(np.concatenate([layer.which for layer in layers]))
    parts = zip(*(layer.media for layer in layers), strict=True)
    media = Media(*(np.concatenate(part)[order] for part in parts))
    return PointClosures(of, seen, matte_alone(lobes), media)


def lambert_lobes(
    scene: Scene, points: ShadingPoints, color: np.ndarray
) -> tuple[ShadingPoints, Lobes]:
    """The points, and Lambert lobes of a color, float32 (n, 3), on the normals that their own
    closures over media have, bumps and all: where walks end."""
    columns = Columns(scene, points)
    columns.params.emission[:] = 0.0
    ones, none = np.ones_like(color), np.zeros(len(color), np.float32)
    params = {"base_color": ones, "diffuse_roughness": none}
    whole = ClosureValues(
        (DIFFUSE, GGX), np.arange(len(color)), color, None, params, None, True, True
    )
    columns.write(whole, whole.which)
    programs = [p if p is not None and _bumps_media(p) else None for p in scene.shaders.programs]
    for which, number, context in _contexts(scene, points, programs):
        seen = which, points.passed[which], scene.pose
        layers, _ = _evaluate(programs[number], context, *seen)
        layer = next(own for own in layers if own.media is not None and own.normal is not None)
        columns.write(whole.at(which)._replace(normal=layer.normal, shadows=layer.shadows), which)
    return columns.made()


def _bumps_media(program: Program) -> bool:
    return any(c.subsurface is not None and c.normal is not None for c in program.closures)


def _packed(layers: list[ClosureValues]) -> list[ClosureValues]:
    """The same; the first one at all points, the others where they weigh anything."""
    there = (layer.at(any_in_row(layer.weight)) for layer in layers[1:])
    return [layers[0], *(layer for layer in there if len(layer.which))]


def materials_of(scene: Scene, points: ShadingPoints, programs):
    """(rows of the points, number, Evaluation) of each material that has a program.

    programs: one a material, or None
    """
    for which, number, context in _contexts(scene, points, programs):
        yield which, number, surface_evaluation(programs[number], context)


def _contexts(scene: Scene, points: ShadingPoints, programs):
    """(rows of the points, number, context) of each material that has a program."""
    rows = scene.mesh.material_index[points.triangle]
    there = [row for row in np.unique(rows) if programs[row] is not None]
    if not there:
        return
    at_rest = points_at_rest(scene.pose, scene.mesh, points)
    context = ShadeContext.of_points(scene, at_rest, there=points)
    for row in there:
        which = np.flatnonzero(rows == row)
        yield which, row, context.take(which)


def _evaluate(
    program: Program, context, which, passed, pose, unlit=_NOWHERE, whole=False
) -> tuple[list[ClosureValues], np.ndarray]:
    """The closures of one material's points, and what these emit: negative too, as in Cycles.

    passed: of ShadingPoints, of these; unlit: bool (m,), or one for all: of _unlit_behind;
    whole: whether light from under the surface counts as the surface's own, and hair is matte
    """
    evaluation = surface_evaluation(program, context)

    def turned(vectors):
        return posed_normals(pose, context.mesh, context.triangle, vectors)

    opaque = opacity_gain(program, evaluation, passed)
    layers = []
    for closure in program.closures:
        weight = np.maximum(evaluation.vector(closure.weight), 0.0) * opaque
        if closure.hair is not None and closure.model == TRANSLUCENT:
            if unlit.all():
                continue
            weight = np.where(unlit[:, None], np.float32(0.0), weight)
        layer = _layer(program, closure, evaluation, which, weight, turned)
        if closure.hair is not None and not whole:
            layer = layer._replace(hair=_hair_values(closure.hair, evaluation, turned, len(which)))
        if closure.film is not None:
            layer = layer._replace(film=_film_values(closure.film, evaluation, len(which)))
        split = closure.subsurface is not None and not whole
        layers += _split(closure.subsurface, evaluation, layer) if split else [layer]
    glow = 0.0 if program.emission is None else evaluation.vector(program.emission) * opaque
    return layers, glow


def _layer(program, closure, evaluation: Evaluation, which, weight, turned) -> ClosureValues:
    """A closure at points, but for its hair and what is under its surface.

    turned: makes vectors of the pose of those of the mesh table
    """
    params = {
        name: evaluation.vector(value) if name in _VECTORS else evaluation.number(value)
        for name, value in closure.params.items()
    }
    normal = None if closure.normal is None else turned(evaluation.vector(closure.normal))
    grain = None
    if closure.grain is not None:
        grain = evaluation.vector(closure.grain)
        length = np.linalg.norm(grain, axis=1)[:, None].astype(np.float32)
        grain = length * turned(grain / np.maximum(length, np.float32(1e-20)))
    corrects = program.corrects_bumps
    shadows = corrects and (closure.normal is None or closure.normal is not program.displaced)
    kind = closure.model, closure.distribution
    return ClosureValues(kind, which, weight, normal, params, grain, shadows, corrects)


def _hair_values(hair: Hair, evaluation: Evaluation, turned, n: int) -> HairValues:
    def each(value, width=()):
        return np.broadcast_to(value, (n, *width)).astype(np.float32)

    tangent, absorption = (each(evaluation.vector(v), (3,)) for v in hair[1:3])
    numbers = (each(evaluation.number(value)) for value in hair[3:])
    return HairValues(hair.model, turned(tangent), absorption, *numbers)


def _film_values(film: ThinFilm, evaluation: Evaluation, n: int) -> FilmValues:
    thickness, ior = (np.broadcast_to(evaluation.number(v), (n,)) for v in film[:2])
    metal = (None, None)
    if film.index is not None:
        metal = (np.broadcast_to(evaluation.vector(v), (n, 3)) for v in film[3:])
    return FilmValues(film.space, np.float32(thickness), np.float32(ior), *metal)


def _split(under: Subsurface, evaluation: Evaluation, layer: ClosureValues) -> list[ClosureValues]:
    """A closure without, and of, its light from under the surface."""
    n, number = len(layer.which), evaluation.number

    def each(values, width=()):
        return np.broadcast_to(values, (n, *width)).astype(np.float32)

    radius = each(np.maximum(evaluation.vector(under.radius), 0.0), (3,))
    share = each(np.clip(number(under.share), 0.0, 1.0))[:, None] * walked(radius)
    media = Media(
        each(layer.params["base_color"], (3,)),
        radius,
        *(each(number(value)) for value in (under.anisotropy, under.ior, under.roughness)),
        np.full(n, under.method, np.int8),
    )
    weight = layer.weight * share
    return [
        layer._replace(matte=1.0 - share),
        layer._replace(weight=weight, grain=None, media=media),
    ]


def _heaviest(layers: list[ClosureValues]) -> tuple[np.ndarray, list[ClosureValues]]:
    """For each point the layer of the greatest weight, with the weight of all, 1 at the most."""
    if len(layers) == 1:
        return np.zeros(len(layers[0].which), np.int64), layers
    picked = np.argmax([row_means(layer.weight) for layer in layers], axis=0)
    total = np.minimum(sum(layer.weight for layer in layers), 1.0)
    return picked, [layer._replace(weight=total) for layer in layers]
