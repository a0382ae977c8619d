"""Shader nodes of one material to a list of closures and what it emits.

A shader that the renderer knows is taken as it is. Another one becomes the nearest that it knows,
and a warning names the object, the material and the node.
"""

from __future__ import annotations

import bpy
import numpy as np

from ....core.data.program import Closure, Value
from ....core.scene import (
    DIFFUSE,
    GLOSSY,
    GLOSSY_TOON,
    MULTI_GGX,
    PRINCIPLED,
    SHEEN,
    TOON,
    VELVET_SHEEN,
)
from .hair_shaders import HairShaders
from .node_values import follow
from .surface_parts import BLACK, DISTRIBUTIONS, ONE, WHITE, ZERO, is_constant

# Principled's inputs that are left out, unless they stand at the value where they do nothing.
_PRINCIPLED_IGNORES = {
    "Thin Wall": (0.0, "the surface is solid"),
}
# Shaders that show nothing themselves, or a part of their weight alone.
_WITHOUT_WEIGHT = {
    "ShaderNodeAddShader",
    "ShaderNodeMixShader",
    "ShaderNodeBsdfTransparent",
    "ShaderNodeBsdfRefraction",
    "ShaderNodeBsdfPrincipled",
}


class ShaderReader(HairShaders):
    """Adds what stands behind a shader socket to its ``parts``."""

    def read(self, socket, groups=(), weight: Value = WHITE) -> None:
        """Add the shader behind a socket, all of it times a colour. Nothing: nothing is added."""
        end = follow(socket, groups)
        if end.node is None or is_constant(weight, 0.0):
            return
        if end.socket.type != "SHADER":  # a colour at a shader's place glows, as in Cycles
            color = self._builder.behind(socket, groups, "COLOR")
            self.parts.emission.append(self._times(weight, color))
            self.parts.shown.append(weight)
            return
        if end.node.bl_idname not in _WITHOUT_WEIGHT:
            self.parts.shown.append(weight)
        read = _SHADERS.get(end.node.bl_idname, ShaderReader._other)
        read(self, end.node, end.groups, weight)

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
        self.parts.shown.append(weight)
        weight = self._sheen_layer(node, groups, weight)
        weight = self._coat(node, groups, weight)
        strength = number(node, "Emission Strength", groups)
        # A color without strength is not looked at: Blender's default is white.
        if not is_constant(strength, 0.0):
            glow = self._builder.scaled(color(node, "Emission Color", groups), strength)
            self.parts.emission.append(self._times(weight, glow))
        grain = self._grain(node, groups, ("Anisotropic", "Anisotropic Rotation"))
        film = self._film(node, groups)
        weight = self._transmission(node, groups, weight, params, grain, film)
        distribution = DISTRIBUTIONS[node.distribution]
        self._close(node, groups, weight, PRINCIPLED, distribution, grain, film, **params)
        self._scatter_under(node, groups)

    def _sheen_layer(self, node, groups, weight):
        """Add Principled's sheen; what it leaves of a weight for all under it."""
        number = self._builder.number
        share, tint = (
            number(node, "Sheen Weight", groups),
            self._builder.color(node, "Sheen Tint", groups),
        )
        if is_constant(share) and share <= 0.0:
            return weight
        roughness = number(node, "Sheen Roughness", groups)
        own = self._times(self._builder.scaled(weight, share), tint)
        self._close(
            node, groups, own, SHEEN, base_color=WHITE, roughness=roughness, diffuse_roughness=ZERO
        )
        inputs = {"Weight": weight, "Sheen": share, "Tint": tint, "Roughness": roughness}
        normal = self._builder.normal(node, "Normal", groups)
        if normal is not None:
            inputs["Normal"] = normal
        return self._builder.run_at_points("under_sheen", **inputs)

    def _sheen(self, node, groups, weight):
        params = {
            "base_color": self._builder.color(node, "Color", groups),
            "roughness": self._builder.number(node, "Roughness", groups),
            "diffuse_roughness": ZERO,
        }
        model = SHEEN if node.distribution == "MICROFIBER" else VELVET_SHEEN
        self._close(node, groups, weight, model, **params)

    def _toon(self, node, groups, weight):
        params = {
            "base_color": self._builder.color(node, "Color", groups),
            "roughness": self._builder.number(node, "Size", groups),
            "diffuse_roughness": self._builder.number(node, "Smooth", groups),
        }
        model = TOON if node.component == "DIFFUSE" else GLOSSY_TOON
        self._close(node, groups, weight, model, **params)

    def _coat(self, node, groups, weight):
        """Add Principled's coat; what it leaves of a weight for all under it."""
        number, color = self._builder.number, self._builder.color
        share = number(node, "Coat Weight", groups)
        if is_constant(share) and share <= 0.0:
            return weight
        coat = self._builder.scaled(weight, share)  # a share over 1 counts in full, as in Cycles
        params = {
            "base_color": BLACK,
            "metallic": np.float32(0.0),
            "roughness": number(node, "Coat Roughness", groups),
            "ior": number(node, "Coat IOR", groups),
            "specular_level": np.float32(0.5),
            "specular_tint": WHITE,
        }
        normal = self._builder.normal(node, "Coat Normal", groups)
        # Cycles gives the coat its later bounces whatever the node's distribution.
        self.parts.closures.append(Closure(PRINCIPLED, MULTI_GGX, coat, params, normal))
        inputs = {"Weight": weight, "Coat": share, "Tint": color(node, "Coat Tint", groups)}
        inputs |= {"IOR": params["ior"], "Roughness": params["roughness"]}
        if normal is not None:
            inputs["Normal"] = normal
        return self._builder.run_at_points("under_coat", **inputs)

    def _glossy(self, node, groups, weight):
        params = {
            "base_color": self._builder.color(node, "Color", groups),
            "roughness": self._builder.number(node, "Roughness", groups),
        }
        grain = self._grain(node, groups, model="GLOSSY")
        self._close(node, groups, weight, GLOSSY, DISTRIBUTIONS[node.distribution], grain, **params)

    def _metallic(self, node, groups, weight):
        """A Principled of metallic 1 is the same, but for a conductor given by its two indices."""
        color = self._builder.color
        indices = ()
        if node.fresnel_type == "F82":
            base, tint = color(node, "Base Color", groups), color(node, "Edge Tint", groups)
        else:
            indices = ("IOR", "Extinction")
            inputs = {name: color(node, name, groups) for name in indices}
            inputs["settings"] = {"approximated": bpy.app.version < (5, 0)}  # as Cycles
            names = ("Base Color", "Edge Tint")
            base, tint = (self._builder.run("conductor", name, **inputs) for name in names)
        params = {
            "base_color": base,
            "metallic": ONE,
            "roughness": self._builder.number(node, "Roughness", groups),
            "specular_tint": tint,
        }
        grain, film = self._grain(node, groups), self._film(node, groups, indices)
        distribution = DISTRIBUTIONS[node.distribution]
        self._close(node, groups, weight, PRINCIPLED, distribution, grain, film, **params)

    def _emission(self, node, groups, weight):
        strength = self._builder.number(node, "Strength", groups)
        glow = self._builder.scaled(self._builder.color(node, "Color", groups), strength)
        self.parts.emission.append(self._times(weight, glow))

    def _holdout(self, node, groups, weight):
        self.parts.holdout.append(weight)

    def _other(self, node, groups, weight):
        """A shader that is not supported: its color, diffuse."""
        names = [name for name in ("Color", "Base Color") if name in node.inputs]
        color = np.full(3, 0.8, np.float32)
        if names:
            color = self._builder.color(node, names[0], groups)
        self._warn(node, f"{node.bl_label} is not supported: rendered as Diffuse")
        self._close(node, groups, weight, DIFFUSE, base_color=color, diffuse_roughness=ZERO)

    def _mix(self, node, groups, weight):
        factor = self._builder.number(node, node.inputs[0].name, groups)
        self._both(node, groups, self._shares(weight, factor))

    def _add(self, node, groups, weight):
        clear, shown = len(self.parts.transparent), len(self.parts.shown)
        self._both(node, groups, [weight, weight])
        if len(self.parts.transparent) > clear:
            self.parts.added = True
        else:  # what is opaque shows once, however much it is
            self.parts.shown[shown:] = [weight]

    def _both(self, node, groups, weights):
        for socket, weight in zip(node.inputs[-2:], weights, strict=True):
            self.read(socket, groups, weight)


# Functions, not bound methods: a reader that knew itself would live on, and a render's images with
# it, until Python looks for cycles.
_SHADERS = {
    "ShaderNodeBsdfDiffuse": ShaderReader._diffuse,
    "ShaderNodeBsdfPrincipled": ShaderReader._principled,
    "ShaderNodeBsdfGlossy": ShaderReader._glossy,
    "ShaderNodeBsdfAnisotropic": ShaderReader._glossy,
    "ShaderNodeBsdfMetallic": ShaderReader._metallic,
    "ShaderNodeEmission": ShaderReader._emission,
    "ShaderNodeBsdfTransparent": ShaderReader._transparent,
    "ShaderNodeMixShader": ShaderReader._mix,
    "ShaderNodeAddShader": ShaderReader._add,
    "ShaderNodeHoldout": ShaderReader._holdout,
    "ShaderNodeBsdfSheen": ShaderReader._sheen,
    "ShaderNodeBsdfToon": ShaderReader._toon,
    "ShaderNodeBsdfTranslucent": ShaderReader._translucent,
    "ShaderNodeBsdfGlass": ShaderReader._glass,
    "ShaderNodeBsdfRefraction": ShaderReader._refraction,
    "ShaderNodeSubsurfaceScattering": ShaderReader._subsurface,
    "ShaderNodeBsdfHairPrincipled": ShaderReader._principled_hair,
    "ShaderNodeBsdfHair": ShaderReader._hair,
}
