"""Lobes of shading points whose materials vary over the surface: programs evaluated, one point one
closure (docs/decisions/0017-shader-programs.md).
"""

from __future__ import annotations

import numpy as np

from .lobe_setup import setup_lobes
from .lobes import Lobes
from .nodes import Evaluation, ShadeContext
from .program import Program
from .scene import MaterialParams, Scene
from .shading import ShadingPoints, params_at


def surface_lobes(scene: Scene, points: ShadingPoints) -> Lobes:
    """The lobes of points, float32, one row each: by programs where materials have one."""
    rows = scene.mesh.material_index[points.triangle]
    params = params_at(scene.materials, rows)
    normal = points.normal.copy()
    weight = np.ones((len(rows), 3), np.float32)
    context = ShadeContext.of_points(scene, points)
    for row in np.unique(rows):
        program = scene.shaders.programs[row]
        if program is not None:
            which = np.flatnonzero(rows == row)
            _fill(program, context.take(which), which, params, normal, weight)
    lobes = setup_lobes(params, normal, points.geometric_normal, points.wo, scene.measured)
    if (weight == 1.0).all():
        return lobes
    return lobes._replace(
        diffuse=lobes.diffuse * weight,
        glossy_color=lobes.glossy_color * weight,
        weight=lobes.weight * weight[:, None],
    )


def _fill(program: Program, context, which, params: MaterialParams, normal, weight) -> None:
    """Write one material's points into the columns of all."""
    evaluation = Evaluation(program, context)
    params.emission[which] = 0.0
    if program.emission is not None:
        params.emission[which] = evaluation.vector(program.emission)  # negative too, as Cycles
    shares = [np.maximum(evaluation.vector(c.weight), 0.0) for c in program.closures]
    heaviest = np.argmax([share.mean(axis=1) for share in shares], axis=0)
    total = shares[0] if len(shares) == 1 else np.minimum(sum(shares), 1.0)
    weight[which] = total
    for k, closure in enumerate(program.closures):
        here = heaviest == k
        rows = which[here]
        params.model[rows], params.distribution[rows] = closure.model, closure.distribution
        for name, value in closure.params.items():
            column = getattr(params, name)
            found = evaluation.vector(value) if column.ndim == 2 else evaluation.number(value)
            column[rows] = found[here]
        if closure.normal is not None:
            turned = evaluation.vector(closure.normal)[here]
            kept = turned.any(axis=1)
            normal[rows[kept]] = turned[kept]
