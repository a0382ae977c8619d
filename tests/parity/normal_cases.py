"""Normals that lead far from the face: smooth coarse meshes, and maps of one normal."""

import functools

import bpy
from mathutils import Matrix

from . import cases
from .cases import CASES, Case
from .lamp_cases import add_lamp
from .lit_cases import principled

lit = functools.partial(cases.lit, samples=(512, 512))
RED = (0.8, 0.1, 0.1)


def _coarse(name, make):
    """The cube and the floor are smooth too: normals are turned far from their faces."""

    def build(scene, tree):
        for obj in scene.objects:
            if obj.type == "MESH":
                obj.data.shade_smooth()
        tree.surface(make(tree))

    CASES.append(Case(f"{name}, coarse and smooth", build, lit=True, samples=(512, 512)))


def _turned(tree, normal):
    """A metal all of whose normals are one, wherever its surface faces."""
    color = tuple(0.5 + 0.5 * x for x in normal)
    turned = tree.made("ShaderNodeNormalMap", 0, {"Color": color}, space="WORLD")
    return tree.made("ShaderNodeBsdfAnisotropic", 0, {"Roughness": 0.4, "Normal": turned})


for _axis, _normal in {"X": (1, 0, 0), "Y": (0, 1, 0), "-Y": (0, -1, 0), "-Z": (0, 0, -1)}.items():
    lit(f"Glossy, all normals are {_axis}", lambda t, n=_normal: _turned(t, n))


def _turned_to_lamp(name, location, **options):
    """Smooth meshes in the dark, whose normals turn to a sun that is below the surface of some."""

    def build(scene, tree):
        for obj in scene.objects:
            if obj.type == "MESH":
                obj.data.shade_smooth()
        add_lamp(scene, "SUN", location, energy=3.0, angle=0.02)
        tree.surface(_turned(tree, (0, 0, 1)))

    cases.lit_by(name, build, **options)


_turned_to_lamp("Sun behind, all normals are Z, coarse and smooth", (-2, 4, 1.5))
_coarse("Diffuse", lambda t: t.made("ShaderNodeBsdfDiffuse", 0, {"Color": RED}))
_coarse("Glossy", lambda t: t.made("ShaderNodeBsdfAnisotropic", 0, {"Roughness": 0.4}))
_coarse("Translucent", lambda t: t.made("ShaderNodeBsdfTranslucent", 0, {"Color": RED}))
_coarse("Principled, coat", principled(Base_Color=RED, Coat_Weight=1.0, Coat_Roughness=0.3))
_coarse("Principled, sheen", principled(Base_Color=RED, Sheen_Weight=1.0))
for _model in ("MICROFIBER", "ASHIKHMIN"):
    _coarse(
        f"Sheen BSDF {_model}",
        lambda t, m=_model: t.made("ShaderNodeBsdfSheen", 0, distribution=m),
    )


def _without_uv(name, make, smooth, kind="uv_sphere"):
    """Shown as light, on meshes without UV maps, some of them moved off their middle."""

    def build(scene, tree):
        bpy.data.objects.remove(scene.objects["Sphere"])
        adds = {"uv_sphere": {"segments": 24, "ring_count": 12}, "monkey": {"size": 1.9}}
        getattr(bpy.ops.mesh, f"primitive_{kind}_add")(location=(-1.1, 0, 0), **adds[kind])
        bpy.context.object.data.materials.append(bpy.data.materials["M"])
        for obj in scene.objects:
            if obj.type == "MESH":
                while len(obj.data.uv_layers):
                    obj.data.uv_layers.remove(obj.data.uv_layers[0])
                obj.data.polygons.foreach_set("use_smooth", [smooth] * len(obj.data.polygons))
                obj.data.transform(Matrix.Translation((0.2, -0.1, 0.3)))
        inputs = {0: make(tree), 1: (0.5, 0.5, 0.5), 2: (0.5, 0.5, 0.5)}
        tree.glow(tree.made("ShaderNodeVectorMath", 0, inputs, operation="MULTIPLY_ADD"))

    looks = "smooth" if smooth else "flat"
    CASES.append(Case(f"{name}, without a UV map, {kind}, {looks}", build))


def _uv_tangent(tree):
    return tree.made("ShaderNodeTangent", 0, direction_type="UV_MAP")


def _map(tree):
    return tree.made("ShaderNodeNormalMap", 0, {"Color": (0.7, 0.6, 0.9)})


for _smooth in (False, True):
    for _kind in ("uv_sphere", "monkey"):
        _without_uv("Tangent", _uv_tangent, _smooth, _kind)
        _without_uv("Normal Map", _map, _smooth, _kind)


def _coarse_map(color):
    """A cube and a floor that are smooth, so that normals between their corners are short."""

    def build(scene, tree):
        for obj in scene.objects:
            if obj.type == "MESH":
                obj.data.shade_smooth()
        turned = tree.made("ShaderNodeNormalMap", 0, {"Color": color})
        inputs = {0: turned, 1: (0.5, 0.5, 0.5), 2: (0.5, 0.5, 0.5)}
        tree.glow(tree.made("ShaderNodeVectorMath", 0, inputs, operation="MULTIPLY_ADD"))

    return build


for _color in ((0.7, 0.6, 0.9), (0.8, 0.5, 0.9)):
    CASES.append(Case(f"Normal Map TANGENT {_color}, coarse and smooth", _coarse_map(_color)))
