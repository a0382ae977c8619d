"""Nodes that look up tables of light: wavelengths, and luminaires on surfaces.

Not in worlds: Cycles of either version ends in a crash there."""

from .cases import lit, shown, world
from .lamp_picture_cases import luminaire, wedges


def _rainbow(tree):
    number = tree.axis("X", 370.0, 790.0)
    return tree.made("ShaderNodeWavelength", 0, {"Wavelength": number})


def _of_one(tree):
    return tree.made("ShaderNodeWavelength", 0, {"Wavelength": 589.3})


shown("Wavelength", _rainbow)
shown("Wavelength, constant", _of_one)


def _sky(tree):
    height = tree.made("ShaderNodeSeparateXYZ", "Z", {0: tree.coordinates("Generated")})
    spread = {"Value": height, "From Min": -1.0, "To Min": 380.0, "To Max": 780.0}
    number = tree.made("ShaderNodeMapRange", 0, spread)
    return tree.made("ShaderNodeWavelength", 0, {"Wavelength": number})


world("Wavelength in a world", _sky)


def _table(vector=None, strength=0.02):
    table = luminaire(range(0, 361, 20), range(0, 181, 10), wedges)

    def make(tree):
        node = table(tree).node
        if vector is not None:
            tree.link(vector(tree), node.inputs["Vector"])
        node.inputs["Strength"].default_value = strength
        return node.outputs[0]

    return make


def _place(tree):
    return tree.coordinates("Object")


def _normal(tree):
    return tree.coordinates("Normal")


shown("IES on a surface, Object", _table(_place))
shown("IES on a surface, Normal", _table(_normal))
shown("IES on a surface, no vector", _table())


def _color(tree):
    return tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": _table(_normal)(tree)})


lit("IES as a color", _color)
