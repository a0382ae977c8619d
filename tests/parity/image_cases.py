"""Image Texture: projections, interpolation, extension, alpha, colour spaces."""

import shutil
import tempfile
from pathlib import Path

import bpy
import numpy as np

from support.movies import write_movie

from .cases import CASES, Case, shown, world
from .scene import picture


def _image(
    interpolation="Linear",
    extension="REPEAT",
    projection="FLAT",
    alpha=False,
    output=0,
    space="sRGB",
    scale=2.3,
    float_buffer=False,
    **properties,
):
    def make(tree):
        image = picture(alpha=alpha, float_buffer=float_buffer)
        if not properties.get("holes", True):  # Blender 4.5 divides packed channels by 0
            rgba = np.array(image.pixels).reshape(-1, 4)
            rgba[:, 3] = np.maximum(rgba[:, 3], 0.2)
            image.pixels.foreach_set(np.float32(rgba).ravel())
            image.pack()
        image.colorspace_settings.name = space
        for name in [n for n in properties if n == "alpha_mode"]:
            image.alpha_mode = properties[name]
        node = tree.node(
            "ShaderNodeTexImage",
            image=image,
            interpolation=interpolation,
            extension=extension,
            projection=projection,
        )
        node.projection_blend = properties.get("blend", 0.0)
        place = tree.coordinates("UV" if projection == "FLAT" else "Generated")
        scaled = tree.made("ShaderNodeVectorMath", 0, {0: place, "Scale": scale}, operation="SCALE")
        moved = tree.made("ShaderNodeVectorMath", 0, {0: scaled, 1: (-0.4, -0.3, -0.2)})
        tree.link(moved, node.inputs[0])
        return node.outputs[output]

    return make


for _kind in ("Linear", "Closest", "Cubic"):
    for _outside in ("REPEAT", "EXTEND", "CLIP", "MIRROR"):
        shown(f"Image Texture {_kind} {_outside}", _image(_kind, _outside))
for _projection in ("BOX", "SPHERE", "TUBE"):
    shown(f"Image Texture {_projection}", _image(projection=_projection))
shown("Image Texture BOX blended", _image(projection="BOX", blend=0.4))
for _space in ("Non-Color", "Linear Rec.709"):
    shown(f"Image Texture {_space}", _image(space=_space))
for _mode in ("STRAIGHT", "CHANNEL_PACKED", "NONE", "PREMUL"):
    shown(f"Image Texture colour, alpha {_mode}", _image(alpha=True, alpha_mode=_mode))
    shown(f"Image Texture alpha {_mode}", _image(alpha=True, alpha_mode=_mode, output=1))
for _mode in ("STRAIGHT", "PREMUL", "CHANNEL_PACKED"):
    shown(
        f"Image Texture colour in Display P3, alpha {_mode}",
        _image(alpha=True, alpha_mode=_mode, space="Display P3", holes=False),
    )
shown("Image Texture float", _image(float_buffer=True, space="Linear Rec.709"))
shown("Image Texture, no coordinates", lambda t: t.made("ShaderNodeTexImage", 0, image=picture()))
shown("Image Texture, no image", lambda t: t.made("ShaderNodeTexImage", 0), warns="no image")


def _tiles(name, packed=False, gone=(), warns="", **settings):
    """A UDIM image of three tiles of two sizes, one of them with a hole, and a tile too few.

    gone: tiles whose files are not there
    """

    def build(scene, tree):
        folder = Path(tempfile.mkdtemp(dir=Path(scene.render.filepath).parent))
        for number, (width, height) in {1001: (16, 12), 1002: (8, 12), 1011: (16, 12)}.items():
            tile = picture(f"T{number}", number == 1011, width=width, height=height)
            tile.filepath_raw, tile.file_format = str(folder / f"t.{number}.png"), "PNG"
            tile.save()
        image = bpy.data.images.load(str(folder / "t.1001.png"))
        image.source, image.filepath_raw = "TILED", str(folder / "t.<UDIM>.png")
        for number in (1002, 1011):
            image.tiles.new(number)
        if packed:
            image.pack()
            shutil.rmtree(folder)
        for number in gone:
            (folder / f"t.{number}.png").unlink()
        uv = tree.made(
            "ShaderNodeVectorMath", 0, {0: tree.coordinates("UV"), "Scale": 2.2}, operation="SCALE"
        )
        tree.glow(tree.made("ShaderNodeTexImage", 0, {0: uv}, image=image, **settings))

    CASES.append(Case(name, build, warns=warns))


_tiles("Image Texture UDIM")
_tiles("Image Texture UDIM Closest", interpolation="Closest")
_tiles("Image Texture UDIM packed", packed=True)
_tiles("Image Texture UDIM, tile 1001 missing", gone=[1001], warns="tile 1001: there is no file")
_tiles("Image Texture UDIM, tile 1011 missing", gone=[1011], warns="tile 1011: there is no file")


def _sequence(scene, tree):
    """The second of three frames."""
    folder = Path(tempfile.mkdtemp(dir=Path(scene.render.filepath).parent))
    for number, height in enumerate((6, 12, 9), 1):
        frame = picture(f"F{number}", height=height)
        frame.filepath_raw, frame.file_format = str(folder / f"f{number:04d}.png"), "PNG"
        frame.save()
    image = bpy.data.images.load(str(folder / "f0001.png"))
    image.source = "SEQUENCE"
    node = tree.node("ShaderNodeTexImage", image=image)
    node.image_user.frame_duration, node.image_user.use_auto_refresh = 3, True
    scene.frame_set(2)
    tree.link(tree.coordinates("UV"), node.inputs[0])
    tree.glow(node.outputs[0])


CASES.append(Case("Image Texture sequence", _sequence))


def _sky(interpolation, width, color_space="Non-Color", projection="EQUIRECTANGULAR", **options):
    def make(tree):
        image = picture(width=width, height=width // 2, **options)
        image.colorspace_settings.name = color_space
        node = tree.node("ShaderNodeTexEnvironment", image=image, interpolation=interpolation)
        node.projection = projection
        return node.outputs["Color"]

    return make


world("Environment Texture, Cubic", _sky("Cubic", 16, float_buffer=True))
world("Environment Texture, Smart, sRGB", _sky("Smart", 64, "sRGB"))
world("Environment Texture, Cubic, mirror ball", _sky("Cubic", 32, projection="MIRROR_BALL"))
world("Environment Texture, Cubic, wide", _sky("Cubic", 2048, float_buffer=True))


def _environment(vector=None, **how):
    """An Environment Texture of a surface."""

    def make(tree):
        output = _sky(how.get("interpolation", "Linear"), 64, **how.get("map", {}))(tree)
        if vector is not None:
            tree.link(vector(tree), output.node.inputs["Vector"])
        return output

    return make


def _tilted_normal(tree):
    """Not as it is: a floor's is the map's pole, where rounding says what column is seen."""
    inputs = {"Vector": tree.coordinates("Normal"), "Rotation": (0.4, 0.2, 0.0)}
    return tree.made("ShaderNodeMapping", 0, inputs, vector_type="VECTOR")


def _reflection(tree):
    return tree.coordinates("Reflection")


shown("Environment Texture on a surface", _environment())
shown(
    "Environment Texture on a surface, by its normal",
    _environment(_tilted_normal),
)
shown("Environment Texture on a surface, by reflection", _environment(_reflection))
shown(
    "Environment Texture on a surface, mirror ball",
    _environment(_reflection, map={"projection": "MIRROR_BALL"}),
)
shown(
    "Environment Texture on a surface, Closest, sRGB",
    _environment(_reflection, interpolation="Closest", map={"color_space": "sRGB"}),
)
shown("Environment Texture on a surface, Cubic", _environment(_reflection, interpolation="Cubic"))


def _movie_at(frame, **user):
    """A movie of stripes that wander, at a frame of the scene."""

    def load():
        columns = np.arange(64) + 6 * np.arange(10)[:, None, None, None]
        frames = np.zeros((10, 32, 64, 3), np.uint8)
        frames[...] = 40 + 20 * (columns[..., None][:, :, 0] // 8 % 10)
        frames[:, :16, :, 1] //= 2
        folder = Path(bpy.context.scene.render.filepath).parent
        path = folder / "movie.avi"
        write_movie(path, frames)
        bpy.context.scene.frame_set(frame)
        return bpy.data.images.load(str(path))

    def make(tree, kind="ShaderNodeTexImage"):
        node = tree.node(kind, image=load())
        for name, value in ({"frame_duration": 10} | user).items():
            setattr(node.image_user, name, value)
        return node.outputs["Color"]

    return make


shown("Image Texture, movie", _movie_at(4))
shown("Image Texture, movie, begins later, cyclic", _movie_at(7, frame_start=12, use_cyclic=True))
world("Environment Texture, movie", lambda tree: _movie_at(6)(tree, "ShaderNodeTexEnvironment"))
