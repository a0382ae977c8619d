"""Blender's materials to core.scene.MaterialParams: one row each, the same all over the surface.

A shader that the renderer knows is taken as it is. Another one becomes the nearest that it knows,
and a warning names the object, the material and the node.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import bpy
import numpy as np

from ...core.scene import (
    BECKMANN,
    BLACK,
    DIFFUSE,
    GGX,
    GLOSSY,
    MULTI_GGX,
    PRINCIPLED,
    MaterialParams,
)
from .node_values import NodeReader, follow

_DISTRIBUTIONS = {"GGX": GGX, "MULTI_GGX": MULTI_GGX, "BECKMANN": BECKMANN}
_WHITE, _NO_LIGHT = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
# Principled's inputs that are left out, unless they stand at the value where they do nothing.
_PRINCIPLED_IGNORES = {
    "Alpha": (1.0, "the surface is opaque"),
    "Thin Wall": (0.0, "the surface is solid"),
    "Diffuse Roughness": (0.0, "rendered as Lambert's"),
    "Subsurface Weight": (0.0, "rendered as diffuse"),
    "Anisotropic": (0.0, "rendered as isotropic"),
    "Transmission Weight": (0.0, "rendered as opaque"),
    "Coat Weight": (0.0, "rendered without coat"),
    "Sheen Weight": (0.0, "rendered without sheen"),
    "Thin Film Thickness": (0.0, "rendered without thin film"),
}
_IGNORED_VECTORS = ("Normal", "Tangent", "Coat Normal")
_AS_GLOSSY = ("ShaderNodeBsdfGlass", "ShaderNodeBsdfRefraction")


@dataclass(frozen=True, slots=True)
class _Surface:
    """A row of MaterialParams."""

    model: int = DIFFUSE
    distribution: int = GGX
    base_color: tuple = (0.8, 0.8, 0.8)
    metallic: float = 0.0
    roughness: float = 0.5
    ior: float = 1.5
    specular_level: float = 0.5
    specular_tint: tuple = _WHITE
    emission: tuple = _NO_LIGHT


_NOTHING = _Surface(model=BLACK)
# Where there is no material, Cycles shows a new Principled BSDF; before Blender 5 a diffuse grey.
_NO_MATERIAL = (
    _Surface(model=PRINCIPLED, distribution=MULTI_GGX) if bpy.app.version >= (5, 0) else _Surface()
)


def export_materials(
    materials: list, warnings: list[str], users: list[list[str]] | None = None
) -> tuple[MaterialParams, np.ndarray]:
    """The table of materials, and the value of the material index pass of each.

    materials: bpy materials, evaluated or not; None is a slot left empty
    warnings: gets a line for all that is rendered otherwise than Cycles would
    users: names of the objects that have each material, for these lines
    Returns MaterialParams with a row a material, in their order, and float32 (n,).
    """
    users = users or [[]] * len(materials)
    surfaces = [
        _surface_of(material, names, warnings)
        for material, names in zip(materials, users, strict=True)
    ]
    columns = {}
    for field in MaterialParams._fields:
        values = [getattr(surface, field) for surface in surfaces]
        if field in ("model", "distribution"):
            columns[field] = np.array(values, np.int8)
        else:
            width = (3,) if isinstance(getattr(_NOTHING, field), tuple) else ()
            columns[field] = np.array(values, np.float32).reshape(len(surfaces), *width)
    index = [0 if material is None else material.pass_index for material in materials]
    return MaterialParams(**columns), np.array(index, np.float32)


def _surface_of(material, users, warnings) -> _Surface:
    if material is None:
        return _NO_MATERIAL
    reader = NodeReader(material.name, users, warnings)
    # From Blender 5 every material has nodes; asking is deprecated there.
    uses_nodes = bpy.app.version >= (5, 0) or material.use_nodes
    if not uses_nodes or material.node_tree is None:
        return _Surface(base_color=tuple(material.diffuse_color[:3]))
    output = material.node_tree.get_output_node("CYCLES")
    if output is None:
        reader.warn(None, "has no Material Output node: black, as in Cycles")
        return _NOTHING
    for name in ("Volume", "Displacement"):
        if follow(output.inputs[name]).node is not None:
            reader.warn(output, f"{name} is not supported and left out")
    if follow(output.inputs["Surface"]).node is None:
        reader.warn(output, "nothing is linked to Surface: black, as in Cycles")
    return _finite(_ShaderReader(reader).behind(output.inputs["Surface"], ()), reader)


def _finite(surface: _Surface, reader) -> _Surface:
    """The surface with 0 for what is no number, as in Cycles."""
    mended = {}
    for field in dataclasses.fields(surface):
        value = np.array(getattr(surface, field.name), np.float32)
        if not np.isfinite(value).all():
            mended[field.name] = np.nan_to_num(value, nan=0.0, posinf=0.0, neginf=0.0).tolist()
            what = field.name.replace("_", " ")
            reader.warn(None, f"{what} is {value}, not finite: {mended[field.name]} instead")
    return dataclasses.replace(surface, **mended)


def _scaled(color, factor):
    return tuple(factor * c for c in color)


def _added(a, b):
    return tuple(x + y for x, y in zip(a, b, strict=True))


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
    return tuple(map(float, base)), tuple(map(float, np.minimum(edge / schlick, 1.0)))


class _ShaderReader:
    """Turns shader nodes into a _Surface."""

    def __init__(self, reader: NodeReader):
        self._reader = reader
        self._shaders = {
            "ShaderNodeBsdfDiffuse": self._diffuse,
            "ShaderNodeBsdfPrincipled": self._principled,
            "ShaderNodeBsdfGlossy": self._glossy,
            "ShaderNodeBsdfAnisotropic": self._glossy,
            "ShaderNodeBsdfMetallic": self._metallic,
            "ShaderNodeEmission": self._emission,
            "ShaderNodeMixShader": self._mix,
            "ShaderNodeAddShader": self._add,
            "ShaderNodeHoldout": self._holdout,
        }

    def behind(self, socket, groups) -> _Surface:
        """The surface that a shader socket is fed with: black if by nothing."""
        end = follow(socket, groups)
        if end.node is None:
            return _NOTHING
        if "Normal" in end.node.inputs:
            self._warn_of_vectors(end)
        return self._shaders.get(end.node.bl_idname, self._other)(end.node, end.groups)

    def _warn_of_vectors(self, end):
        for name in _IGNORED_VECTORS:
            if name in end.node.inputs and follow(end.node.inputs[name], end.groups).node:
                self._reader.warn(end.node, f"{name} is not supported and left out")

    def _diffuse(self, node, groups):
        if self._reader.number(node, "Roughness", groups) > 0.0:
            self._reader.warn(node, "Roughness is not supported: rendered as Lambert's")
        return _Surface(base_color=self._reader.color(node, "Color", groups))

    def _principled(self, node, groups):
        number, color = self._reader.number, self._reader.color
        for name, (neutral, instead) in _PRINCIPLED_IGNORES.items():
            if name in node.inputs and number(node, name, groups) != neutral:
                self._reader.warn(node, f"{name} is not supported: {instead}")
        strength = number(node, "Emission Strength", groups)
        return _Surface(
            model=PRINCIPLED,
            distribution=_DISTRIBUTIONS[node.distribution],
            base_color=color(node, "Base Color", groups),
            metallic=number(node, "Metallic", groups),
            roughness=number(node, "Roughness", groups),
            ior=number(node, "IOR", groups),
            specular_level=number(node, "Specular IOR Level", groups),
            specular_tint=color(node, "Specular Tint", groups),
            # A color without strength is not looked at: Blender's default is white.
            emission=_scaled(color(node, "Emission Color", groups), strength)
            if strength
            else _NO_LIGHT,
        )

    def _distribution(self, node):
        if node.distribution not in _DISTRIBUTIONS:
            self._reader.warn(node, f"{node.distribution} is not supported: rendered as GGX")
        return _DISTRIBUTIONS.get(node.distribution, GGX)

    def _glossy(self, node, groups):
        if self._reader.number(node, "Anisotropy", groups) != 0.0:
            self._reader.warn(node, "Anisotropy is not supported: rendered as isotropic")
        return _Surface(
            model=GLOSSY,
            distribution=self._distribution(node),
            base_color=self._reader.color(node, "Color", groups),
            roughness=self._reader.number(node, "Roughness", groups),
        )

    def _metallic(self, node, groups):
        """A Principled of metallic 1 is the same, but for a conductor given by its two indices."""
        color = self._reader.color
        for name in ("Anisotropy", "Thin Film Thickness"):
            if name in node.inputs and self._reader.number(node, name, groups) != 0.0:
                self._reader.warn(node, f"{name} is not supported and left out")
        if node.fresnel_type == "F82":
            base, tint = color(node, "Base Color", groups), color(node, "Edge Tint", groups)
        else:
            base, tint = _f82_of_indices(
                np.array(color(node, "IOR", groups)), np.array(color(node, "Extinction", groups))
            )
            self._reader.warn(node, "a physical conductor is rendered by the nearest F82 curve")
        return _Surface(
            model=PRINCIPLED,
            distribution=self._distribution(node),
            base_color=base,
            metallic=1.0,
            roughness=self._reader.number(node, "Roughness", groups),
            specular_tint=tint,
        )

    def _emission(self, node, groups):
        strength = self._reader.number(node, "Strength", groups)
        return dataclasses.replace(
            _NOTHING, emission=_scaled(self._reader.color(node, "Color", groups), strength)
        )

    def _holdout(self, node, groups):
        self._reader.warn(node, "Holdout is not supported: black and opaque")
        return _NOTHING

    def _other(self, node, groups):
        """A shader that is not supported: a mirror for what is clear, else its color, diffuse."""
        names = [name for name in ("Color", "Base Color") if name in node.inputs]
        color = self._reader.color(node, names[0], groups) if names else (0.8, 0.8, 0.8)
        if node.bl_idname in _AS_GLOSSY:
            self._reader.warn(node, f"{node.bl_label} is not supported: rendered as Glossy")
            return _Surface(
                model=GLOSSY,
                distribution=self._distribution(node),
                base_color=color,
                roughness=self._reader.number(node, "Roughness", groups),
            )
        self._reader.warn(node, f"{node.bl_label} is not supported: rendered as Diffuse")
        return _Surface(base_color=color)

    def _mix(self, node, groups):
        share = min(max(self._reader.number(node, node.inputs[0].name, groups), 0.0), 1.0)
        if share in (0.0, 1.0):
            return self.behind(node.inputs[1 + int(share)], groups)
        return self._sum(node, groups, 1.0 - share, share)

    def _add(self, node, groups):
        return self._sum(node, groups, 1.0, 1.0)

    def _sum(self, node, groups, weight_a, weight_b):
        """Both inputs, weighted: exact for emission and for two diffuse; else the heavier one."""
        a, b = (self.behind(socket, groups) for socket in node.inputs[-2:])
        emission = _added(_scaled(a.emission, weight_a), _scaled(b.emission, weight_b))
        if BLACK in (a.model, b.model):
            shader, weight = (b, weight_b) if a.model == BLACK else (a, weight_a)
            color = _scaled(shader.base_color, weight)
            if weight != 1.0 and shader.model == PRINCIPLED:
                self._reader.warn(node, "a Principled BSDF is darkened by its base color only")
        elif a.model == b.model == DIFFUSE:
            shader = a
            color = _added(_scaled(a.base_color, weight_a), _scaled(b.base_color, weight_b))
        else:
            shader = a if weight_a >= weight_b else b
            color = shader.base_color
            place = "first" if shader is a else "second"
            self._reader.warn(
                node, f"{node.bl_label} of two surfaces is not supported: only the {place} is used"
            )
        return dataclasses.replace(shader, base_color=color, emission=emission)
