"""What a tree of shaders comes to, and what all shaders do to add to it."""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
import numpy as np

from ....core.bsdf.thin_film_tables import GAUSSIANS, THINNEST, film_space
from ....core.data.program import Closure, Ref, ThinFilm, Value
from ....core.scene import ASHIKHMIN_SHIRLEY, BECKMANN, DIFFUSE, GGX, MULTI_GGX
from ..images.color_spaces import working_space
from .program_builder import ProgramBuilder

DISTRIBUTIONS = {
    "GGX": GGX,
    "MULTI_GGX": MULTI_GGX,
    "BECKMANN": BECKMANN,
    "ASHIKHMIN_SHIRLEY": ASHIKHMIN_SHIRLEY,
}
WHITE, BLACK = np.ones(3, np.float32), np.zeros(3, np.float32)
ONE, ZERO = np.float32(1.0), np.float32(0.0)


def is_constant(value, number=None) -> bool:
    """Whether a value is the same at all points, and equal to a number if one is given."""
    return not isinstance(value, Ref) and (number is None or bool(np.all(value == number)))


def is_plain_diffuse(closure: Closure) -> bool:
    """Whether a closure can be added to another one by its colour."""
    smooth = is_constant(closure.params.get("diffuse_roughness", ZERO), 0.0)
    plain = (closure.normal, closure.subsurface, closure.hair) == (None, None, None)
    return closure.model == DIFFUSE and plain and smooth


@dataclass(slots=True)
class SurfaceParts:
    """What a tree of shaders comes to: sums of closures, emission, what passes, what is a hole.

    shown: weights of all shaders but what lets light through; added: whether there is an Add
        Shader over what does, so that weights may be more than 1 together
    tinted: the nodes whose shadows have a color
    """

    closures: list[Closure] = field(default_factory=list)
    emission: list[Value] = field(default_factory=list)
    transparent: list[Value] = field(default_factory=list)
    holdout: list[Value] = field(default_factory=list)
    shown: list[Value] = field(default_factory=list)
    added: bool = False
    tinted: list = field(default_factory=list)


class SurfaceBuilder:
    """Adds closures to its ``parts``."""

    def __init__(self, builder: ProgramBuilder):
        self.parts = SurfaceParts()
        self._builder, self._warn = builder, builder.reader.warn

    def _times(self, weight, color):
        """The product of two colours."""
        if is_constant(weight, 1.0):
            return color
        if is_constant(color, 1.0):
            return weight
        return self._builder.run("product", A=weight, B=color)

    def _shares(self, weight, factor):
        """The two parts of a weight that a Mix Shader gives its first and its second shader."""
        if is_constant(factor):
            factor = np.clip(factor, 0.0, 1.0)
        return [
            self._builder.run("weigh", Weight=weight, Factor=factor, settings={"second": second})
            for second in (False, True)
        ]

    def _close(
        self, node, groups, weight, model, distribution=GGX, grain=None, film=None, **params
    ):
        """Add a closure with the node's own normal."""
        normal = self._builder.normal(node, "Normal", groups)
        closure = Closure(model, distribution, weight, params, normal, grain, film=film)
        self.parts.closures.append(closure)

    def _film(self, node, groups, indices=()) -> ThinFilm | None:
        """Closure.film of a node; indices: names of its inputs that say what metal is under it."""
        name = "Thin Film Thickness"
        if name not in node.inputs:  # Metallic BSDFs before Blender 5
            return None
        thickness = self._builder.number(node, name, groups)
        if is_constant(thickness) and not thickness > THINNEST:
            return None
        ior = self._builder.number(node, "Thin Film IOR", groups)
        metal = [self._builder.color(node, index, groups) for index in indices]
        space = GAUSSIANS if bpy.app.version < (5, 0) else film_space(working_space())
        return ThinFilm(thickness, ior, space, *metal)

    def _grain(self, node, groups, names=("Anisotropy", "Rotation"), model="ASPECT"):
        """Closure.grain of a node with inputs of these names; model: of nodes.layers.grain."""
        anisotropy = self._builder.number(node, names[0], groups)
        if is_constant(anisotropy):
            # Below 0 a Glossy BSDF is stretched the other way, the others are round.
            used = max(anisotropy, 0.0) if model == "ASPECT" else anisotropy
            if used == 0.0:
                return None
        tangent = self._builder.vector_if_linked(node, "Tangent", groups)
        inputs = {
            "Anisotropy": anisotropy,
            "Rotation": self._builder.number(node, names[1], groups),
        }
        inputs["Tangent"] = self._builder.default_tangent() if tangent is None else tangent
        normal = self._builder.normal(node, "Normal", groups)
        if normal is not None:
            inputs["Normal"] = normal
        return self._builder.run_at_points("grain", settings={"model": model}, **inputs)

    def _ignored(self, node, groups, name, neutral, instead):
        if name in node.inputs:
            if not is_constant(self._builder.number(node, name, groups), neutral):
                self._warn(node, f"{name} is not supported: {instead}")
