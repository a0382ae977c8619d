"""Shader nodes of one material to a list of closures and what it emits.

A shader that the renderer knows is taken as it is. Another one becomes the nearest that it knows,
and a warning names the object, the material and the node.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...core.program import Closure, Ref, Value
from ...core.scene import BECKMANN, DIFFUSE, GGX, GLOSSY, MULTI_GGX, PRINCIPLED
from .node_values import follow
from .program_builder import ProgramBuilder

_DISTRIBUTIONS = {"GGX": GGX, "MULTI_GGX": MULTI_GGX, "BECKMANN": BECKMANN}
_WHITE, _BLACK = np.ones(3, np.float32), np.zeros(3, np.float32)
_ONE, _SMOOTH = np.float32(1.0), np.float32(0.0)
# Principled's inputs that are left out, unless they stand at the value where they do nothing.
_PRINCIPLED_IGNORES = {
    "Thin Wall": (0.0, "the surface is solid"),
    "Subsurface Weight": (0.0, "rendered as diffuse"),
    "Anisotropic": (0.0, "rendered as isotropic"),
    "Transmission Weight": (0.0, "rendered as opaque"),
    "Sheen Weight": (0.0, "rendered without sheen"),
    "Thin Film Thickness": (0.0, "rendered without thin film"),
}
_AS_GLOSSY = ("ShaderNodeBsdfGlass", "ShaderNodeBsdfRefraction")


def is_constant(value, number=None) -> bool:
    """Whether a value is the same at all points, and equal to a number if one is given."""
    return not isinstance(value, Ref) and (number is None or bool(np.all(value == number)))


def is_plain_diffuse(closure: Closure) -> bool:
    """Whether a closure can be added to another one by its colour."""
    smooth = is_constant(closure.params.get("diffuse_roughness", _SMOOTH), 0.0)
    return closure.model == DIFFUSE and closure.normal is None and smooth


@dataclass(slots=True)
class SurfaceParts:
    """What a tree of shaders comes to: sums of closures, emission, what passes, what is a hole."""

    closures: list[Closure] = field(default_factory=list)
    emission: list[Value] = field(default_factory=list)
    transparent: list[Value] = field(default_factory=list)
    holdout: list[Value] = field(default_factory=list)


def _conductor(cosine, n, k):
    """Fresnel's reflectance of a conductor with index n + ik."""
    sine2 = 1.0 - cosine**2
    t = n**2 - k**2 - sine2
    length = np.sqrt(t**2 + 4.0 * n**2 * k**2)
    across = np.sqrt(2.0 * (length + t)) * cosine
    s = (length + cosine**2 - across) / (length + cosine**2 + across)
    up, side = length * cosine**2 + sine2**2, across * sine2
    return 0.5 * s * (1.0 + (up - side) / (up + side))


def _f82_of_indices(n, k):
    """Base color and edge tint whose F82 curve meets a conductor's at 0 and 82 degrees."""
    base, edge = _conductor(1.0, n, k), _conductor(1.0 / 7.0, n, k)
    schlick = base + (1.0 - base) * (6.0 / 7.0) ** 5
    return base.astype(np.float32), np.minimum(edge / schlick, 1.0).astype(np.float32)


class ShaderReader:
    """Adds what stands behind a shader socket to its ``parts``."""

    def __init__(self, builder: ProgramBuilder):
        self.parts = SurfaceParts()
        self._builder, self._warn = builder, builder.reader.warn
        self._shaders = {
            "ShaderNodeBsdfDiffuse": self._diffuse,
            "ShaderNodeBsdfPrincipled": self._principled,
            "ShaderNodeBsdfGlossy": self._glossy,
            "ShaderNodeBsdfAnisotropic": self._glossy,
            "ShaderNodeBsdfMetallic": self._metallic,
            "ShaderNodeEmission": self._emission,
            "ShaderNodeBsdfTransparent": self._transparent,
            "ShaderNodeMixShader": self._mix,
            "ShaderNodeAddShader": self._add,
            "ShaderNodeHoldout": self._holdout,
        }

    def read(self, socket, groups=(), weight: Value = _WHITE) -> None:
        """Add the shader behind a socket, all of it times a colour. Nothing: nothing is added."""
        end = follow(socket, groups)
        if end.node is None or is_constant(weight, 0.0):
            return
        if end.socket.type != "SHADER":  # a colour at a shader's place glows, as in Cycles
            color = self._builder.behind(socket, groups, "COLOR")
            self.parts.emission.append(self._times(weight, color))
            return
        self._shaders.get(end.node.bl_idname, self._other)(end.node, end.groups, weight)

    def _times(self, weight, color):
        """The product of two colours."""
        if is_constant(weight, 1.0):
            return color
        if is_constant(color, 1.0):
            return weight
        return self._builder.run("product", A=weight, B=color)

    def _close(self, node, groups, weight, model, distribution=GGX, **params):
        """Add a closure with the node's own normal."""
        normal = self._builder.vector_if_linked(node, "Normal", groups)
        self.parts.closures.append(Closure(model, distribution, weight, params, normal))

    def _ignored(self, node, groups, name, neutral, instead):
        if name in node.inputs:
            if not is_constant(self._builder.number(node, name, groups), neutral):
                self._warn(node, f"{name} is not supported: {instead}")

    def _diffuse(self, node, groups, weight):
        color = self._builder.color(node, "Color", groups)
        rough = self._builder.number(node, "Roughness", groups)
        self._close(node, groups, weight, DIFFUSE, base_color=color, diffuse_roughness=rough)

    def _principled(self, node, groups, weight):
        number, color = self._builder.number, self._builder.color
        for name, (neutral, instead) in _PRINCIPLED_IGNORES.items():
            self._ignored(node, groups, name, neutral, instead)
        params = {
            "base_color": color(node, "Base Color", groups),
            "metallic": number(node, "Metallic", groups),
            "roughness": number(node, "Roughness", groups),
            "ior": number(node, "IOR", groups),
            "specular_level": number(node, "Specular IOR Level", groups),
            "specular_tint": color(node, "Specular Tint", groups),
        }
        if "Diffuse Roughness" in node.inputs:
            params["diffuse_roughness"] = number(node, "Diffuse Roughness", groups)
        weight = self._alpha(node, groups, weight)
        weight = self._coat(node, groups, weight)
        strength = number(node, "Emission Strength", groups)
        # A color without strength is not looked at: Blender's default is white.
        if not is_constant(strength, 0.0):
            glow = self._builder.scaled(color(node, "Emission Color", groups), strength)
            self.parts.emission.append(self._times(weight, glow))
        distribution = _DISTRIBUTIONS[node.distribution]
        self._close(node, groups, weight, PRINCIPLED, distribution, **params)

    def _alpha(self, node, groups, weight):
        """What Principled's alpha leaves of a weight; the rest passes through."""
        alpha = self._builder.number(node, "Alpha", groups)
        if is_constant(alpha) and alpha >= 1.0:
            return weight
        passing, kept = self._shares(weight, alpha)
        self.parts.transparent.append(passing)
        return kept

    def _shares(self, weight, factor):
        """The two parts of a weight that a Mix Shader gives its first and its second shader."""
        if is_constant(factor):
            factor = np.clip(factor, 0.0, 1.0)
        return [
            self._builder.run("weigh", Weight=weight, Factor=factor, settings={"second": second})
            for second in (False, True)
        ]

    def _coat(self, node, groups, weight):
        """Add Principled's coat; what it leaves of a weight for all under it."""
        number, color = self._builder.number, self._builder.color
        share = number(node, "Coat Weight", groups)
        if is_constant(share) and share <= 0.0:
            return weight
        _, coat = self._shares(weight, share)
        params = {
            "base_color": _BLACK,
            "metallic": np.float32(0.0),
            "roughness": number(node, "Coat Roughness", groups),
            "ior": number(node, "Coat IOR", groups),
            "specular_level": np.float32(0.5),
            "specular_tint": _WHITE,
        }
        normal = self._builder.vector_if_linked(node, "Coat Normal", groups)
        self.parts.closures.append(Closure(PRINCIPLED, GGX, coat, params, normal))
        inputs = {"Weight": weight, "Coat": share, "Tint": color(node, "Coat Tint", groups)}
        inputs |= {"IOR": params["ior"], "Roughness": params["roughness"]}
        if normal is not None:
            inputs["Normal"] = normal
        return self._builder.run_at_points("under_coat", **inputs)

    def _distribution(self, node):
        if node.distribution not in _DISTRIBUTIONS:
            self._warn(node, f"{node.distribution} is not supported: rendered as GGX")
        return _DISTRIBUTIONS.get(node.distribution, GGX)

    def _glossy(self, node, groups, weight):
        self._ignored(node, groups, "Anisotropy", 0.0, "rendered as isotropic")
        self._mirror(node, groups, weight)

    def _mirror(self, node, groups, weight):
        params = {
            "base_color": self._builder.color(node, "Color", groups),
            "roughness": self._builder.number(node, "Roughness", groups),
        }
        self._close(node, groups, weight, GLOSSY, self._distribution(node), **params)

    def _metallic(self, node, groups, weight):
        """A Principled of metallic 1 is the same, but for a conductor given by its two indices."""
        color = self._builder.color
        for name in ("Anisotropy", "Thin Film Thickness"):
            self._ignored(node, groups, name, 0.0, "left out")
        if node.fresnel_type == "F82":
            base, tint = color(node, "Base Color", groups), color(node, "Edge Tint", groups)
        else:
            indices = (color(node, "IOR", groups), color(node, "Extinction", groups))
            if not all(map(is_constant, indices)):
                self._warn(node, "IOR and Extinction vary: their means are used")
                indices = map(self._builder.mean, indices)
            base, tint = _f82_of_indices(*indices)
            self._warn(node, "a physical conductor is rendered by the nearest F82 curve")
        params = {
            "base_color": base,
            "metallic": _ONE,
            "roughness": self._builder.number(node, "Roughness", groups),
            "specular_tint": tint,
        }
        self._close(node, groups, weight, PRINCIPLED, self._distribution(node), **params)

    def _emission(self, node, groups, weight):
        strength = self._builder.number(node, "Strength", groups)
        glow = self._builder.scaled(self._builder.color(node, "Color", groups), strength)
        self.parts.emission.append(self._times(weight, glow))

    def _holdout(self, node, groups, weight):
        self.parts.holdout.append(weight)

    def _other(self, node, groups, weight):
        """A shader that is not supported: a mirror for what is clear, else its color, diffuse."""
        if node.bl_idname in _AS_GLOSSY:
            self._warn(node, f"{node.bl_label} is not supported: rendered as Glossy")
            self._mirror(node, groups, weight)
            return
        names = [name for name in ("Color", "Base Color") if name in node.inputs]
        color = np.full(3, 0.8, np.float32)
        if names:
            color = self._builder.color(node, names[0], groups)
        self._warn(node, f"{node.bl_label} is not supported: rendered as Diffuse")
        self._close(node, groups, weight, DIFFUSE, base_color=color, diffuse_roughness=_SMOOTH)

    def _transparent(self, node, groups, weight):
        color = self._builder.color(node, "Color", groups)
        if not is_constant(color) or np.ptp(color) > 0.0:
            self._warn(node, "a colored Transparent BSDF lets all colors through by its luminance")
        self.parts.transparent.append(self._times(weight, color))

    def _mix(self, node, groups, weight):
        factor = self._builder.number(node, node.inputs[0].name, groups)
        self._both(node, groups, self._shares(weight, factor))

    def _add(self, node, groups, weight):
        self._both(node, groups, [weight, weight])

    def _both(self, node, groups, weights):
        for socket, weight in zip(node.inputs[-2:], weights, strict=True):
            self.read(socket, groups, weight)
