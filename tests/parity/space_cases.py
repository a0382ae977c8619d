"""Files with another working space than Linear Rec.709, which Blender 5 has."""

import bpy

from .cases import shown
from .world_cases import sky, world


def in_space(space, make):
    """The numbers of the file's colours stay as they are."""

    def made(tree):
        bpy.ops.wm.set_working_color_space(working_space=space, convert_colors=False)
        return make(tree)

    return made


def _gray(tree):
    return tree.made("ShaderNodeRGBToBW", 0, {0: tree.color()})


def _as_number(tree):
    return tree.made("ShaderNodeMath", 0, {0: tree.made("ShaderNodeTexMagic", "Color"), 1: 0.1})


def _blackbody(tree):
    return tree.made("ShaderNodeBlackbody", 0, {"Temperature": tree.axis("X", 1500.0, 9000.0)})


def _wavelength(tree):
    return tree.made("ShaderNodeWavelength", 0, {0: tree.axis("X", 380.0, 780.0)})


def _of_bytes(tree):
    """An image in sRGB."""
    image = bpy.data.images.new("B", 4, 4)
    image.pixels.foreach_set([k / 63 for k in range(64)])
    image.pack()
    vector = {"Vector": tree.coordinates()}
    return tree.made("ShaderNodeTexImage", 0, vector, image=image)


if bpy.app.version >= (5, 0):
    for _space in ("ACEScg", "Linear Rec.2020"):
        shown(f"RGB to BW in {_space}", in_space(_space, _gray))
        shown(f"Color as a number in {_space}", in_space(_space, _as_number))
        shown(f"Blackbody in {_space}", in_space(_space, _blackbody))
        shown(f"Wavelength in {_space}", in_space(_space, _wavelength))
        shown(f"Image Texture in {_space}", in_space(_space, _of_bytes))
    _PREETHAM = {"sky_type": "PREETHAM", "sun_direction": (0.3, -0.4, 0.6), "turbidity": 4.0}
    world("Sky, Preetham, in ACEScg", in_space("ACEScg", sky(**_PREETHAM)))
