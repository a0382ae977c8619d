"""A program's operations over shading points. An operation is done when its value is asked for."""

from __future__ import annotations

import numpy as np

from ..data.program import Program, Ref, Value
from ..data.rows import row_maxima
from . import (
    arithmetic,
    color,
    coordinates,
    element_info,
    falloff,
    gabor,
    hair_info,
    ies,
    images,
    layers,
    metals,
    near,
    noise,
    normals,
    patterns,
    voronoi,
    wavelength,
    wireframe,
    world,
)
from .context import ShadeContext
from .values import as_number, as_vector, column, convert

FUNCTIONS = {}
for family in (
    arithmetic,
    color,
    coordinates,
    element_info,
    hair_info,
    images,
    layers,
    metals,
    normals,
    noise,
    gabor,
    voronoi,
    patterns,
    ies,
    falloff,
    near,
    wireframe,
    wavelength,
    world,
):
    FUNCTIONS |= family.FUNCTIONS


def _convert(context, settings, inputs):
    return {"": convert(inputs["Value"], **settings)}


def _scale(context, settings, inputs):
    """Colour times number."""
    return {"": inputs["Color"] * column(inputs["Factor"])}


def _product(context, settings, inputs):
    return {"": inputs["A"] * inputs["B"]}


def _weigh(context, settings, inputs):
    """The part of a weight that one side of a Mix Shader gets. settings: second"""
    factor = np.clip(inputs["Factor"], 0.0, 1.0)
    return {"": inputs["Weight"] * column(factor if settings["second"] else 1.0 - factor)}


def _sum(context, settings, inputs):
    """Values added up, whatever their names."""
    values = list(inputs.values())
    return {"": sum(values[1:], values[0])}


FUNCTIONS |= {
    "convert": _convert,
    "scale": _scale,
    "product": _product,
    "weigh": _weigh,
    "sum": _sum,
}


class Evaluation:
    """The values of one program at the points of one context.

    known: outputs of operations that need not be run, by row
    """

    def __init__(self, program: Program, context: ShadeContext, known=None):
        self._ops, self._context = program.ops, context
        self._done: dict[int, dict] = dict(known or {})

    def number(self, value: Value) -> np.ndarray:
        """float32 (n,)"""
        return as_number(_finite(self.value(value)), len(self._context))

    def vector(self, value: Value) -> np.ndarray:
        """float32 (n, 3)"""
        return as_vector(_finite(self.value(value)), len(self._context))

    def value(self, value: Value):
        """As the node gives it: one value for all points, or one for each."""
        if not isinstance(value, Ref):
            return value
        if value.op not in self._done:
            self._done[value.op] = self._run(self._ops[value.op])
        outputs = self._done[value.op]
        if callable(outputs[value.output]):  # dear, and not always asked for
            outputs[value.output] = outputs[value.output]()
        return outputs[value.output]

    def _run(self, op):
        if op.settings.get("at_rest") and self._context.rest is not None:
            before = Evaluation(_Ops(self._ops), self._context.at_rest())
            return before._run(op._replace(settings={**op.settings, "at_rest": False}))
        settings, inputs = op.settings, op.inputs
        if op.kind == "ShaderNodeBump":
            settings = {**settings, "heights": self._heights(op)}
            inputs = {name: value for name, value in inputs.items() if name != "Height"}
        inputs = {name: self.value(value) for name, value in inputs.items()}
        with np.errstate(all="ignore"):
            return FUNCTIONS[op.kind](self._context, settings, inputs)

    def _heights(self, op):
        """A bump's height here and a part of a pixel aside, and the two steps, (n, 3) each."""
        context, height = self._context, op.inputs["Height"]
        width = as_number(self.value(op.inputs.get("Filter Width", np.float32(0.1))), len(context))
        size = np.maximum(context.footprint * width, _least_step(context))
        steps, places = context.steps(size, op.settings.get("rescaled", False))
        moved = (
            Evaluation(_Ops(self._ops), context.moved(*own)).number(height)
            for own in zip(steps, places, strict=True)
        )
        return self.number(height), *moved, steps


def surface_evaluation(program: Program, context: ShadeContext) -> Evaluation:
    """Of a surface: all but a displacement's bump itself sees the normal that this leaves."""
    first, turned = Evaluation(program, context), program.displaced
    if turned is None:
        return first
    after = context.take(slice(None))
    after.normal = first.vector(turned)
    return Evaluation(program, after, {turned.op: {turned.output: after.normal}})


class _Ops:
    """The operations alone."""

    def __init__(self, ops):
        self.ops = ops


def _least_step(context):
    """Metres: below, float32 positions do not tell the steps apart."""
    return np.float32(2e-5) * row_maxima(np.abs(context.position)).clip(1e-3)


def _finite(value):
    """0 for what is no number, as in Cycles."""
    value = np.asarray(value, np.float32)
    return value if np.isfinite(value).all() else np.nan_to_num(value, posinf=0.0, neginf=0.0)
