"""Shaders of strands: Principled Hair and the Hair BSDF."""

from __future__ import annotations

from ....core.data.program import (
    HAIR_BELL_REFLECTION,
    HAIR_BELL_TRANSMISSION,
    HAIR_CHIANG,
    Closure,
    Hair,
)
from ....core.scene import DIFFUSE, GGX, TRANSLUCENT
from .subsurface import SubsurfaceShaders
from .surface_parts import BLACK, ONE, ZERO

# Inputs of Principled Hair that its pigment is made of. A parametrization has some of them.
_PIGMENT = {
    "Color": "color",
    "Tint": "color",
    "Absorption": "vector",
    "Melanin": "number",
    "Redness": "number",
    "Roughness": "number",
    "Radial": "number",
    "Random Color": "number",
    "Random Roughness": "number",
}
_SOCKETS = {
    "Absorption": "Absorption Coefficient",
    "Redness": "Melanin Redness",
    "Radial": "Radial Roughness",
}


class HairShaders(SubsurfaceShaders):
    """What a ShaderReader knows of them."""

    def _principled_hair(self, node, groups, weight):
        """All round the strand: a closure for each side."""
        huang = node.model == "HUANG"
        if huang:
            self._warn(node, "Model Huang is not supported: rendered as Chiang")
        inputs = {}
        for name, kind in _PIGMENT.items():
            socket, inputs[name] = _SOCKETS.get(name, name), ZERO if kind == "number" else BLACK
            if socket in node.inputs:
                inputs[name] = getattr(self._builder, kind)(node, socket, groups)
        random = self._builder.number_if_linked(node, "Random", groups)
        if random is not None:
            inputs["Random"] = random
        self._builder.requests.add("element:Random")
        settings = {"parametrization": node.parametrization, "huang": huang}
        absorption, roughness, radial, color = self._builder.run_at_points(
            "hair_pigment",
            *("absorption", "roughness", "radial", "color"),
            settings=settings,
            **inputs,
        )
        number = self._builder.number
        hair = Hair(
            model=HAIR_CHIANG,
            tangent=self._along(),
            absorption=absorption,
            roughness=roughness,
            radial=radial,
            coat=ZERO if huang else number(node, "Coat", groups),
            ior=number(node, "IOR", groups),
            offset=number(node, "Offset", groups),
        )
        for model in (DIFFUSE, TRANSLUCENT):
            self._add_hair(model, weight, color, hair)

    def _hair(self, node, groups, weight):
        """The Hair BSDF: reflection in front of a strand, or transmission behind."""
        number = self._builder.number
        tangent = self._builder.vector_if_linked(node, "Tangent", groups)
        offset = number(node, "Offset", groups)
        if tangent is None:
            self._builder.requests.add("element:Is Strand")
            offset = self._builder.run_at_points("strand_only", Value=offset)
        mirrors = node.component == "Reflection"
        hair = Hair(
            model=HAIR_BELL_REFLECTION if mirrors else HAIR_BELL_TRANSMISSION,
            tangent=self._along() if tangent is None else tangent,
            absorption=BLACK,
            roughness=number(node, "RoughnessU", groups),
            radial=number(node, "RoughnessV", groups),
            coat=ZERO,
            ior=ONE,
            offset=offset,
        )
        color = self._builder.color(node, "Color", groups)
        for model in (DIFFUSE, TRANSLUCENT):
            self._add_hair(model, weight, color, hair)

    def _add_hair(self, model, weight, color, hair):
        params = {"base_color": color, "roughness": ONE, "diffuse_roughness": ZERO}
        self.parts.closures.append(Closure(model, GGX, weight, params, hair=hair))

    def _along(self):
        """Along the strand; on a mesh along its default tangent."""
        self._builder.requests.add("element:Tangent")
        otherwise = self._builder.default_tangent()
        return self._builder.run_at_points("strand_tangent", Otherwise=otherwise)
