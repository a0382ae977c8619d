"""Materials whose parameters vary, under a world."""

from .cases import lit
from .scene import picture


def _image(tree):
    return tree.made("ShaderNodeTexImage", 0, {0: tree.coordinates("UV")}, image=picture())


def _noise(tree):
    return tree.made("ShaderNodeTexNoise", 0, {"Vector": tree.coordinates(), "Scale": 3.0})


def _principled(**inputs):
    def make(tree):
        made = {name.replace("_", " "): value(tree) for name, value in inputs.items()}
        return tree.made("ShaderNodeBsdfPrincipled", 0, made)

    return make


def _bump(tree):
    return tree.made("ShaderNodeBump", 0, {"Height": _noise(tree), "Distance": 0.2})


def _normal_map(tree):
    return tree.made("ShaderNodeNormalMap", 0, {"Color": (0.6, 0.35, 0.9)})


def _masked_diffuse(tree):
    red = tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.8, 0.1, 0.1)})
    blue = tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.1, 0.2, 0.8)})
    return tree.made("ShaderNodeMixShader", 0, {0: tree.axis("Z"), 1: red, 2: blue})


def _glow_over_paint(tree):
    light = tree.made("ShaderNodeEmission", 0, {"Color": _image(tree)})
    paint = tree.made("ShaderNodeBsdfPrincipled", 0, {"Base Color": (0.3, 0.5, 0.2)})
    return tree.made("ShaderNodeMixShader", 0, {0: tree.axis("X"), 1: paint, 2: light})


lit("Diffuse, image", lambda t: t.made("ShaderNodeBsdfDiffuse", 0, {"Color": _image(t)}))
lit("Principled, image", _principled(Base_Color=_image))
lit("Principled, roughness varies", _principled(Roughness=lambda t: t.axis("X", 0.1, 0.9)))
lit("Principled, metallic varies", _principled(Metallic=lambda t: t.axis("Z"), Base_Color=_image))
lit("Principled, specular varies", _principled(Specular_IOR_Level=_noise))
lit("Principled, bump", _principled(Normal=_bump))
lit("Principled, normal map", _principled(Normal=_normal_map))
lit(
    "Glossy, roughness varies",
    lambda t: t.made("ShaderNodeBsdfGlossy", 0, {"Roughness": t.axis("Z", 0.15, 0.8)}),
)
lit("Diffuse, mixed by a mask", _masked_diffuse)
lit("Principled mixed with a glowing image", _glow_over_paint)
