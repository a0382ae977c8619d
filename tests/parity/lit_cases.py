"""Materials whose parameters vary, under a world."""

import bpy

from .cases import CASES, Case, lit
from .scene import picture


def image_of(tree):
    """The colours of a small image, laid on by UV."""
    return tree.made("ShaderNodeTexImage", 0, {0: tree.coordinates("UV")}, image=picture())


def noise_of(tree):
    """The factor of a noise texture."""
    return tree.made("ShaderNodeTexNoise", 0, {"Vector": tree.coordinates(), "Scale": 3.0})


def _made(value, tree):
    return value(tree) if callable(value) else value


def principled(**inputs):
    """A maker of a Principled BSDF; inputs: by name, spaces as _: values, or makers of outputs."""

    def make(tree):
        made = {name.replace("_", " "): _made(value, tree) for name, value in inputs.items()}
        return tree.made("ShaderNodeBsdfPrincipled", 0, made)

    return make


def _rough(tree, color, roughness):
    return tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": color, "Roughness": roughness})


def _bump(tree):
    return tree.made("ShaderNodeBump", 0, {"Height": noise_of(tree), "Distance": 0.2})


def _normal_map(tree):
    return tree.made("ShaderNodeNormalMap", 0, {"Color": (0.6, 0.35, 0.9)})


def _masked_diffuse(tree):
    red = tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.8, 0.1, 0.1)})
    blue = tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.1, 0.2, 0.8)})
    return tree.made("ShaderNodeMixShader", 0, {0: tree.axis("Z"), 1: red, 2: blue})


def _glow_over_paint(tree):
    light = tree.made("ShaderNodeEmission", 0, {"Color": image_of(tree)})
    paint = tree.made("ShaderNodeBsdfPrincipled", 0, {"Base Color": (0.3, 0.5, 0.2)})
    return tree.made("ShaderNodeMixShader", 0, {0: tree.axis("X"), 1: paint, 2: light})


lit("Diffuse, image", lambda t: t.made("ShaderNodeBsdfDiffuse", 0, {"Color": image_of(t)}))
lit("Principled, image", principled(Base_Color=image_of))
lit("Principled, roughness varies", principled(Roughness=lambda t: t.axis("X", 0.1, 0.9)))
lit("Principled, metallic varies", principled(Metallic=lambda t: t.axis("Z"), Base_Color=image_of))
lit("Principled, specular varies", principled(Specular_IOR_Level=noise_of))
lit("Principled, bump", principled(Normal=_bump), samples=(256, 1024))
lit("Principled, normal map", principled(Normal=_normal_map), samples=(256, 1024))


def _displaced(name, **place):
    """Displacement, which Cycles shows as bump; place: of the sphere"""

    def build(scene, tree):
        tree.surface(tree.made("ShaderNodeBsdfPrincipled", 0, {"Base Color": (0.6, 0.5, 0.4)}))
        inputs = {"Height": noise_of(tree), "Scale": 0.2, "Midlevel": 0.4}
        height = tree.made("ShaderNodeDisplacement", 0, inputs)
        tree.link(height, tree.output.inputs["Displacement"])
        for key, value in place.items():
            setattr(bpy.data.objects["Sphere"], key, value)

    CASES.append(Case(name, build, lit=True, samples=(256, 1024)))


_displaced("Displacement as bump")
_displaced("Displacement as bump, of a large object", scale=(1.3, 1.3, 1.3))


def _uncorrected(name, make):
    """The material setting Bump Map Correction off."""

    def build(scene, tree):
        tree.surface(make(tree))
        for material in bpy.data.materials:
            material.cycles.use_bump_map_correction = False

    CASES.append(Case(name, build, lit=True, samples=(256, 1024)))


_uncorrected("Principled, normal map, not corrected", principled(Normal=_normal_map))
_uncorrected(
    "Diffuse, normal map, not corrected",
    lambda t: t.made("ShaderNodeBsdfDiffuse", 0, {"Normal": _normal_map(t)}),
)
_uncorrected(
    "Metal, normal map, not corrected",
    principled(Metallic=1.0, Roughness=0.3, Normal=_normal_map),
)
lit(
    "Glossy, roughness varies",
    lambda t: t.made("ShaderNodeBsdfGlossy", 0, {"Roughness": t.axis("Z", 0.15, 0.8)}),
)
lit("Diffuse, mixed by a mask", _masked_diffuse)
lit("Principled mixed with a glowing image", _glow_over_paint)
# Two renders of IWIS with other seeds share some of their error: less of it is wanted here.
lit("Diffuse, rough", lambda tree: _rough(tree, (0.8, 0.5, 0.2), 1.0), samples=(512, 512))
lit(
    "Diffuse, rough by noise",
    lambda tree: _rough(tree, (0.9, 0.9, 0.9), noise_of(tree)),
    samples=(512, 512),
)
lit(
    "Principled, rough diffuse",
    principled(Diffuse_Roughness=0.7, Base_Color=image_of, Roughness=0.4),
)
lit(
    "Diffuse, rough mixed with smooth",
    lambda tree: tree.made(
        "ShaderNodeMixShader",
        0,
        {0: 0.4, 1: _rough(tree, (0.8, 0.5, 0.2), 0.6), 2: _rough(tree, (0.1, 0.3, 0.8), 0.0)},
    ),
    samples=(512, 512),
)
