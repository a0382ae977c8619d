"""OpenEXR files with layers or parts, as Blender and other programs write them; sequences."""

import tempfile
from pathlib import Path

import bpy
import numpy as np

from support.layered import write_layers, write_parts

from .cases import shown, world
from .scene import picture

_LAYERS = {"V.Combined": "RGBA", "V.AO": "RGB", "V.Depth": "Z"}
_STEREO = {"V.Combined.left": "RGBA", "V.Combined.right": "RGBA"}
_OTHERS = {"": "RGBA", "diffuse": "RGB"}
_DATA = {"V.Normal": "XYZ", "V.Depth": "Z"}


def _folder():
    return Path(tempfile.mkdtemp(dir=Path(bpy.context.scene.render.filepath).parent))


def _image(write=write_layers, layers=None, packed=False, output=0, frames=0, **properties):
    """An Image Texture of such a file. frames: of a sequence; properties: of the image"""
    space = properties.pop("space", "Linear Rec.709")
    options = {name: properties.pop(name) for name in list(properties) if name != "alpha_mode"}

    def make(tree):
        folder = _folder()
        for number in range(max(frames, 1)):
            write(folder / f"a{number + 1}.exr", layers or _LAYERS, seed=number, **options)
        image = bpy.data.images.load(str(folder / "a1.exr"))
        image.colorspace_settings.name = space
        for name, value in properties.items():
            setattr(image, name, value)
        if packed:
            image.pack()
        node = tree.node("ShaderNodeTexImage", image=image, interpolation="Closest")
        if frames:
            image.source = "SEQUENCE"
            node.image_user.frame_duration, node.image_user.use_auto_refresh = frames, True
            bpy.context.scene.frame_set(2)
        tree.link(tree.coordinates("UV"), node.inputs[0])
        return node.outputs[output]

    return make


for _how, _packed in (("file", False), ("packed", True)):
    shown(f"Layers of OpenEXR, {_how}", _image(packed=_packed))
    shown(f"Layers of OpenEXR, {_how}, alpha", _image(packed=_packed, output=1))
    shown(f"Layers of OpenEXR, {_how}, straight", _image(packed=_packed, alpha_mode="STRAIGHT"))
    shown(f"Layers of OpenEXR, {_how}, ACEScg", _image(packed=_packed, space="ACEScg"))
    shown(f"Layers of OpenEXR, {_how}, Non-Color", _image(packed=_packed, space="Non-Color"))
    shown(f"Layers of OpenEXR, {_how}, half", _image(packed=_packed, dtype=np.float16))
    shown(f"Layers of OpenEXR, {_how}, tiled", _image(packed=_packed, tiled=True))
    shown(f"Layers of OpenEXR, {_how}, stereo", _image(layers=_STEREO, packed=_packed, views=True))
    shown(f"Layers of OpenEXR, {_how}, RGBA and others", _image(layers=_OTHERS, packed=_packed))
    shown(f"Layers of OpenEXR, {_how}, no Combined", _image(layers=_DATA, packed=_packed))
    shown(f"Layers of OpenEXR, {_how}, a window", _image(packed=_packed, window=(3, 2)))
    shown(f"Parts of OpenEXR, {_how}", _image(write_parts, packed=_packed))
    shown(f"Parts of OpenEXR, {_how}, depth first", _image(write_parts, _DATA, packed=_packed))
shown("Layers of OpenEXR, sequence", _image(frames=3))
shown("Layers of OpenEXR, sequence, alpha", _image(frames=3, output=1))


def _sky(tree):
    path = _folder() / "sky.exr"
    write_layers(path, _LAYERS, width=64, height=32)
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Linear Rec.709"
    return tree.node("ShaderNodeTexEnvironment", image=image).outputs["Color"]


world("Layers of OpenEXR, Environment Texture", _sky)


def _pictures(alpha_mode, output, packed=False):
    """A sequence of PNG files that have alpha."""

    def make(tree):
        folder = _folder()
        for number, height in enumerate((6, 12, 9), 1):
            frame = picture(f"F{number}", alpha=True, height=height)
            frame.filepath_raw, frame.file_format = str(folder / f"f{number}.png"), "PNG"
            frame.save()
        image = bpy.data.images.load(str(folder / "f1.png"))
        image.alpha_mode = alpha_mode
        if packed:
            image.pack()
        image.source = "SEQUENCE"
        node = tree.node("ShaderNodeTexImage", image=image)
        node.image_user.frame_duration, node.image_user.use_auto_refresh = 3, True
        bpy.context.scene.frame_set(2)
        tree.link(tree.coordinates("UV"), node.inputs[0])
        return node.outputs[output]

    return make


for _mode in ("STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"):
    shown(f"Image Texture sequence, colour, alpha {_mode}", _pictures(_mode, 0))
shown("Image Texture sequence, alpha", _pictures("STRAIGHT", 1))
shown("Image Texture sequence, packed, alpha", _pictures("STRAIGHT", 1, packed=True))
