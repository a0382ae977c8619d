"""Lobes of shading points whose materials vary over the surface: programs evaluated
(docs/decisions/0017-shader-programs.md, 0022-closures-and-cut-outs.md).

A row of Lobes holds one closure: the points of a mixture are taken once for each that is there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .bump import turns
from .cutouts import opacity_gain
from .lobe_setup import setup_lobes
from .lobes import Lobes
from .nodes import Evaluation, ShadeContext
from .nodes.values import dot
from .poses import points_at_rest, posed_normals
from .program import Program
from .rows import any_in_row, row_means, rows_of
from .scene import DIFFUSE, SHEEN, TRANSLUCENT, VELVET_SHEEN, MaterialParams, Scene
from .shading import ShadingPoints, params_at
from .sheen import set_sheen
from .stretched import mean_roughness, stretch_lobes

_VECTORS = ("base_color", "specular_tint")  # columns of MaterialParams


class _Layer(NamedTuple):
    """A closure at m points.

    which: int (m,), rows of the points; weight: float32 (m, 3); normal: float32 (m, 3), 0 where it
    is the surface's own, or None; params: column of MaterialParams -> values at the points; grain:
    float32 (m, 3), as Closure.grain, or None
    """

    closure: tuple
    which: np.ndarray
    weight: np.ndarray
    normal: np.ndarray | None
    params: dict[str, np.ndarray]
    grain: np.ndarray | None
    shadows: bool  # light on a turned normal
    corrects: bool  # Program.corrects_bumps

    def at(self, some) -> _Layer:
        which, weight, *values = rows_of((self.which, self.weight, *self.params.values()), some)
        params = dict(zip(self.params, values, strict=True))
        normal, grain = (
            None if vectors is None else rows_of((vectors,), some)[0]
            for vectors in (self.normal, self.grain)
        )
        rest = self.shadows, self.corrects
        return _Layer(self.closure, which, weight, normal, params, grain, *rest)


class _Columns:
    """What setup_lobes wants of n points, to be overwritten by layers."""

    def __init__(self, scene: Scene, points: ShadingPoints):
        self.points, self._measured = points, scene.measured
        self.params = params_at(scene.materials, scene.mesh.material_index[points.triangle])
        self.normal = points.normal.copy()
        self.weight = points.through.copy()
        self._maps_normals = False
        self._turned = np.zeros(len(points.pixel), np.bool_)  # the normal, by a map, and shadowed
        self._as_turned = np.zeros(len(points.pixel), np.bool_)  # Program.corrects_bumps is off
        self._grain = np.zeros((len(points.pixel), 3), np.float32)
        self._sheen = np.zeros(len(points.pixel), np.int8)  # SHEEN, VELVET_SHEEN
        self._behind = np.zeros(len(points.pixel), np.bool_)  # TRANSLUCENT

    def write(self, layer: _Layer, rows: np.ndarray) -> None:
        """Give rows the layer's closure."""
        params: MaterialParams = self.params
        model, params.distribution[rows] = layer.closure
        lambert = model in (TRANSLUCENT, SHEEN, VELVET_SHEEN)
        params.model[rows] = DIFFUSE if lambert else model
        self._sheen[rows] = model if model in (SHEEN, VELVET_SHEEN) else 0
        self._behind[rows] = model == TRANSLUCENT
        for name, values in layer.params.items():
            getattr(params, name)[rows] = values
        self.weight[rows] = layer.weight * self.points.through[rows]
        self._as_turned[rows] = not layer.corrects
        if layer.grain is not None:
            self._grain[rows] = layer.grain
        if layer.normal is not None:
            self._maps_normals = True
            kept = any_in_row(layer.normal)
            self.normal[rows[kept]] = layer.normal[kept]
            self._turned[rows[kept]] = layer.shadows

    def made(self) -> tuple[ShadingPoints, Lobes]:
        """The points, on the side that their closure shines from, and its lobes."""
        lobes = self._lobes()
        if not self._behind.any():
            return self.points, lobes
        side = np.where(self._behind, np.float32(-1.0), np.float32(1.0))[:, None]
        lobes = lobes._replace(normal=lobes.normal * side, smooth=lobes.smooth * side)
        return self.points.from_behind(self._behind), lobes

    def _lobes(self) -> Lobes:
        points, weight = self.points, self.weight
        params, brushed = self.params, self._grain.any()
        if brushed:
            params = params._replace(roughness=mean_roughness(params.roughness, self._grain))
        own = params, self.normal, points.geometric_normal, points.wo
        lobes = setup_lobes(*own, self._measured, self._as_turned)
        if self._maps_normals:  # below the surface: lit by what no light comes from, as in Cycles
            lobes.diffuse[dot(points.normal, lobes.normal) < 0.0] = 0.0
        if self._sheen.any():
            roughness = self.params.roughness
            set_sheen(lobes, self._sheen == SHEEN, self._sheen == VELVET_SHEEN, roughness)
        if brushed:
            stretch_lobes(lobes, self.params.roughness, self._grain)
        if self._turned.any():
            bump = np.where(self._turned, turns(points.normal, lobes.normal), np.float32(0.0))
            lobes = lobes._replace(smooth=points.normal, bump=bump)
        if (weight == 1.0).all():
            return lobes
        return lobes._replace(
            diffuse=lobes.diffuse * weight,
            glossy_color=lobes.glossy_color * weight,
            weight=lobes.weight * weight[:, None],
            tint=lobes.tint * weight,
        )


def surface_lobes(scene: Scene, points: ShadingPoints) -> tuple[ShadingPoints, Lobes]:
    """The points, on the side that they shine from, and their lobes, float32, one row each: of
    several closures the one of the greatest weight, with the weight of all."""
    columns = _Columns(scene, points)
    programs = scene.shaders.programs
    for which, number, context in _contexts(scene, points, programs):
        layers, glow = _evaluate(programs[number], context, which, scene.pose)
        columns.params.emission[which] = glow
        picked, layers = _heaviest(layers)
        for k, layer in enumerate(layers):
            here = picked == k
            columns.write(layer.at(here), which[here])
    columns.params.emission[:] *= points.through
    return columns.made()


def closure_layers(
    scene: Scene, points: ShadingPoints
) -> list[tuple[np.ndarray, ShadingPoints, Lobes]]:
    """The closures of points in layers: (int64 (m,), ascending, which points; these, on the side
    that they shine from; their lobes) of each.

    The first layer has a closure of every point, and what glows; the next ones those of the points
    that have more.
    """
    n = len(points.pixel)
    glow = scene.materials.emission[scene.mesh.material_index[points.triangle]]
    found: list[list[_Layer]] = [[]]
    programs = scene.shaders.programs
    for which, number, context in _contexts(scene, points, programs):
        layers, glow[which] = _evaluate(programs[number], context, which, scene.pose)
        for k, layer in enumerate(_packed(layers)):
            if k == len(found):
                found.append([])
            found[k].append(layer)
    out = []
    for k, layers in enumerate(found):
        source = np.arange(n) if k == 0 else np.sort(np.concatenate([x.which for x in layers]))
        columns = _Columns(scene, points.at(source) if k else points)
        for layer in layers:
            columns.write(layer, np.searchsorted(source, layer.which))
        columns.params.emission[:] = 0.0 if k else glow * points.through
        out.append((source, *columns.made()))
    return out


def _packed(layers: list[_Layer]) -> list[_Layer]:
    """The same; the first one at all points, the others where they weigh anything."""
    there = (layer.at(any_in_row(layer.weight)) for layer in layers[1:])
    return [layers[0], *(layer for layer in there if len(layer.which))]


def materials_of(scene: Scene, points: ShadingPoints, programs):
    """(rows of the points, number, Evaluation) of each material that has a program.

    programs: one a material, or None
    """
    for which, number, context in _contexts(scene, points, programs):
        yield which, number, Evaluation(programs[number], context)


def _contexts(scene: Scene, points: ShadingPoints, programs):
    """(rows of the points, number, context) of each material that has a program."""
    rows = scene.mesh.material_index[points.triangle]
    there = [row for row in np.unique(rows) if programs[row] is not None]
    if not there:
        return
    at_rest = points_at_rest(scene.pose, scene.mesh, points)
    context = ShadeContext.of_points(scene, at_rest)
    for row in there:
        which = np.flatnonzero(rows == row)
        yield which, row, context.take(which)


def _evaluate(program: Program, context, which, pose) -> tuple[list[_Layer], np.ndarray]:
    """The closures of one material's points, and what these emit: negative too, as in Cycles."""
    evaluation = Evaluation(program, context)
    opaque = opacity_gain(program, evaluation, len(which))
    layers = []
    for closure in program.closures:
        params = {
            name: evaluation.vector(value) if name in _VECTORS else evaluation.number(value)
            for name, value in closure.params.items()
        }
        weight = np.maximum(evaluation.vector(closure.weight), 0.0) * opaque
        normal = None if closure.normal is None else evaluation.vector(closure.normal)
        if normal is not None:
            normal = posed_normals(pose, context.mesh, context.triangle, normal)
        kind, grain = (closure.model, closure.distribution), None
        if closure.grain is not None:
            grain = evaluation.vector(closure.grain)
            length = np.linalg.norm(grain, axis=1)[:, None].astype(np.float32)
            along = grain / np.maximum(length, np.float32(1e-20))
            grain = length * posed_normals(pose, context.mesh, context.triangle, along)
        corrects = program.corrects_bumps
        shadows = corrects and (closure.normal is None or closure.normal is not program.displaced)
        layers.append(_Layer(kind, which, weight, normal, params, grain, shadows, corrects))
    glow = 0.0 if program.emission is None else evaluation.vector(program.emission) * opaque
    return layers, glow


def _heaviest(layers: list[_Layer]) -> tuple[np.ndarray, list[_Layer]]:
    """For each point the layer of the greatest weight, with the weight of all, 1 at the most."""
    if len(layers) == 1:
        return np.zeros(len(layers[0].which), np.int64), layers
    picked = np.argmax([row_means(layer.weight) for layer in layers], axis=0)
    total = np.minimum(sum(layer.weight for layer in layers), 1.0)
    return picked, [layer._replace(weight=total) for layer in layers]
