"""The texels of an image data-block, scene-linear, as Cycles hands them to a shader.

Blender keeps float images in scene-linear colour already, and byte images as the file has them.
sRGB and data are decoded here; any other colour space of a byte image is converted by Blender,
which reads the texels again from a temporary float file. Measured against Cycles 4.5, 5.0, 5.1 and
5.2: what is multiplied by its alpha is so *before* it is decoded (data never is), and texels in
sRGB (not those of packed or generated float images) are interpolated before they are decoded.
"""

from __future__ import annotations

import functools
import os
import tempfile
from typing import NamedTuple

import bpy
import numpy as np

from ...scratch import scratch
from .color_spaces import WORKING_SPACE_OF_4, srgb_decode, srgb_decode_bytes, working_space
from .image_files import is_outdated
from .layers import LayersError, has_layers, plain_file
from .movies import frame_of, show_frame


class Texels(NamedTuple):
    """rgb: float32 (h, w, 3), scene-linear, row 0 at the bottom, not checked for NaN or sign.
    srgb_interpolation: whether Cycles interpolates these between their sRGB encodings."""

    rgb: np.ndarray
    srgb_interpolation: bool


class ImageError(ValueError):
    """The image has no texels. The text says why and what to do."""


def read_texels(image, image_user=None, frame: int | None = None, read=None) -> Texels:
    """The texels of the image at the frame of its user. read: texels_of, or what makes something
    of it. Raises ImageError with what to do."""
    return read_by(read or texels_of, image, image_user, frame)


def read_by(read, image, image_user, frame: int | None = None):
    """read(data-block) of the image at the frame of its user, as Texels or otherwise. frame: of the
    scene, which a movie's user need not have been told; None: it has."""
    if image is None:
        raise ImageError("no image is chosen: choose one in the node, or remove the node")
    read = functools.partial(_read_plain, read)
    if image.source == "SEQUENCE" and image_user is not None:
        return _read_frame(image, image_user, read)
    if is_outdated(image):
        return _load(_path_of(image), image.colorspace_settings.name, image.alpha_mode, read)
    loaded = image.has_data
    try:
        if image.source == "MOVIE" and image_user is not None:
            show_frame(image, frame_of(image_user, frame))
        return read(image)
    finally:
        if bpy.app.background and not loaded:  # nobody else needs it: 2 GB of 16384 x 8192 texels
            image.buffers_free()


def _read_plain(read, image):
    """read(data-block), of an image with layers in the way of what is shown of it."""
    width, _height = image.size  # loads the file
    if width or not has_layers(image):
        return read(image)
    associated = "PREMUL" if image.alpha_mode == "STRAIGHT" else image.alpha_mode
    try:
        with plain_file(image, _path_of(image)) as plain:
            return _load(plain.path, plain.space, associated, read, plain.packed)
    except LayersError as error:
        raise ImageError(str(error)) from None


def texels_of(image) -> Texels:
    """As read_texels, of a data-block that has but one frame."""
    rgba = pixels_of(image)
    color, alpha = rgba[..., :3], rgba[..., 3:]
    encoded = not image.is_float
    space = image.colorspace_settings
    srgb = space.name == "sRGB" and working_space() == WORKING_SPACE_OF_4
    plain = srgb or space.is_data or space.name in (working_space(), "scene_linear")
    share = None if plain else _share_of_color(image, alpha)
    clear = _has_clear_parts(image, alpha, 1.0)
    if clear or share is not None:
        if not _is_builtin(image) and os.path.exists(_path_of(image)):
            # Blender has multiplied by alpha, or divided: begin with the file's own numbers.
            color, encoded = _load(_path_of(image), "Non-Color", "CHANNEL_PACKED", _color), True
        if clear and _multiplied_by_alpha(image, _is_builtin(image)):
            color = _multiplied(color, alpha, image.is_float or not plain)
    whole = color.base is not None and color.base is rgba.base
    color = _without_alpha(rgba) if whole else np.ascontiguousarray(color, np.float32)
    if not encoded:
        return Texels(color, srgb and not _is_builtin(image))
    if srgb:
        return Texels(srgb_decode(color) if image.is_float else srgb_decode_bytes(color), True)
    if plain:
        return Texels(color, False)
    if share is None:
        return Texels(_convert(color, space.name), False)
    return Texels(_convert(color / share, space.name) * share, False)


def _share_of_color(image, alpha) -> np.ndarray | None:
    """By what Cycles divides texels before it converts them from a space like Display P3, and by
    what it multiplies them then, float32 (h, w, 1): alpha where it is between 0 and 1, however
    it is associated; packed channels too before Blender 5.1. None: by nothing."""
    packed = image.alpha_mode == "CHANNEL_PACKED" and bpy.app.version >= (5, 1)
    if image.alpha_mode == "NONE" or packed or alpha.min() >= 1.0:
        return None
    return np.where((alpha > 0.0) & (alpha < 1.0), alpha, np.float32(1.0))


def _without_alpha(rgba: np.ndarray) -> np.ndarray:
    """float32 (h, w, 3) in the memory of float32 (h, w, 4), which is lost: of 16384 x 8192 texels
    2 GB, beside Blender's own."""
    (height, width, _), flat = rgba.shape, rgba.base
    for y in range(height):  # a row lands where those before it have been
        flat[3 * width * y : 3 * width * (y + 1)].reshape(width, 3)[:] = rgba[y, :, :3]
    flat.resize(3 * width * height, refcheck=False)  # nobody looks at rgba any more
    return flat.reshape(height, width, 3)


class Room:
    """Memory for the pixels of one image after another: the system clears what is new, 67 MB of
    2048 x 2048 texels, which takes longer than to fill it."""

    def __init__(self):
        self._flat = np.empty(0, np.float32)

    def take(self, n: int) -> np.ndarray:
        """float32 (n,), which the next call overwrites."""
        if len(self._flat) < n:
            self._flat = np.empty(n, np.float32)
        return self._flat[:n]


def bytes_of(image, room: Room) -> np.ndarray | None:
    """uint8 (h, w, 4): texels that Cycles interpolates as bytes, of data or in sRGB, with alpha;
    None: of this data-block it interpolates floats."""
    space = image.colorspace_settings
    srgb = space.name == "sRGB" and working_space() == WORKING_SPACE_OF_4
    pixels = pixels_of(image, room)
    if image.is_float or not (srgb or space.is_data):
        return None
    rgba = _to_bytes(pixels)
    if _has_clear_parts(image, rgba[..., 3], 255):
        if not _is_builtin(image) and os.path.exists(_path_of(image)):
            read = functools.partial(pixels_of, room=room)
            own = _load(_path_of(image), "Non-Color", "CHANNEL_PACKED", read)
            rgba[..., :3] = _to_bytes(own)[..., :3]
        if _multiplied_by_alpha(image, _is_builtin(image)):
            # As Cycles: the product of bytes, which fits into 16 bits, without its fraction.
            product = rgba[..., :3] * rgba[..., 3:].astype(np.uint16)
            rgba[..., :3] = product // np.uint16(255)
    return rgba


def _to_bytes(rgba: np.ndarray) -> np.ndarray:
    """uint8 of float32 (h, w, 4) that were bytes; by rows, which fit into caches."""
    out, whole = np.empty(rgba.shape, np.uint8), np.empty(rgba.shape[1:], np.float32)
    for row, pixels in zip(out, rgba, strict=True):
        np.multiply(pixels, np.float32(255.0), out=whole)
        row[:] = np.rint(whole, out=whole)
    return out


def _has_clear_parts(image, alpha, whole) -> bool:
    """Whether colors count as multiplied by their alpha, and any alpha is less than ``whole``."""
    associates = image.alpha_mode in ("STRAIGHT", "PREMUL")
    return associates and not image.colorspace_settings.is_data and alpha.min() < whole


def _is_builtin(image) -> bool:
    return bool(image.packed_file) or image.source != "FILE"


def _path_of(image) -> str:
    return bpy.path.abspath(image.filepath, library=image.library)


def _multiplied_by_alpha(image, builtin) -> bool:
    """Whether Cycles of the running Blender multiplies the texels by their alpha once more.

    From 5.1 on what is Straight. Before, all bytes, and floats of files that keep alpha straight.
    """
    if bpy.app.version >= (5, 1):
        return image.alpha_mode == "STRAIGHT"
    straight = image.file_format not in ("OPEN_EXR", "OPEN_EXR_MULTILAYER", "TIFF")
    return not image.is_float or (straight and not builtin)


def _multiplied(color, alpha, exact):
    if exact:
        return color * alpha
    # Cycles multiplies bytes and drops the fraction; what it converts is of 16 bits before.
    return np.floor(np.rint(color * 255.0) * np.rint(alpha * 255.0) / 255.0) / 255.0


def _color(image) -> np.ndarray:
    return np.ascontiguousarray(pixels_of(image)[..., :3])


def pixels_of(image, room: Room | None = None) -> np.ndarray:
    """image.pixels as float32 (h, w, 4); in the room, if there is one."""
    width, height = image.size  # loads the file
    if width * height == 0 or image.channels == 0:
        raise ImageError(f"image {image.name!r} {_what_is_wrong(image)}")
    flat = (room or Room()).take(width * height * image.channels)
    try:
        image.pixels.foreach_get(flat)
    except (TypeError, RuntimeError) as error:
        raise ImageError(f"image {image.name!r} gives no pixels ({error}): reload it") from None
    pixels = flat.reshape(height, width, image.channels)
    if image.channels == 4:
        return pixels
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = pixels[..., :3] if image.channels == 3 else pixels[..., :1]
    return rgba


def _what_is_wrong(image) -> str:
    if image.packed_file:
        return "is packed, but its data cannot be read: unpack it and load the file again"
    path = bpy.path.abspath(image.filepath, library=image.library)
    if not path:
        return "is empty and has no file: choose a file, or give it a size"
    if not os.path.exists(path):
        return f"has no file at {path}: find it by File > External Data > Find Missing Files"
    if os.path.isdir(path):
        return f"is a folder, {path}: choose a file in it"
    if os.path.getsize(path) == 0:
        return f"is an empty file, {path}: copy it again"
    return f"cannot be read from {path}: the file is damaged or of an unknown kind, replace it"


def _read_frame(image, image_user, read):
    """read(data-block) of a sequence's file at the frame of its user.

    What is packed of a sequence is one frame: Blender and Cycles look at the files nevertheless.
    """
    path = bpy.path.abspath(image.filepath_from_user(image_user=image_user))
    if not os.path.exists(path):
        raise ImageError(f"there is no file {path}: check the sequence's first frame and its path")
    own = image.colorspace_settings.name, image.alpha_mode, read
    return _load(path, *own, packed=bool(image.packed_files))


def _load(path, space, alpha_mode, read, packed=False):
    """read(image) of a data-block that is there only for this. packed: as one that is packed"""
    with scratch(bpy.data.images, bpy.data.images.load(path)) as image:
        image.colorspace_settings.name = space
        image.alpha_mode = alpha_mode
        if packed:
            image.pack()
        return read(image)


def _convert(color: np.ndarray, space: str) -> np.ndarray:
    """Scene-linear of texels in any space: Blender converts a float file when it loads it."""
    height, width, _ = color.shape
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = color
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "texels.exr")
        made = bpy.data.images.new("texels", width, height, alpha=True, float_buffer=True)
        with scratch(bpy.data.images, made) as image:
            image.colorspace_settings.name = "Non-Color"
            image.pixels.foreach_set(rgba.ravel())
            image.filepath_raw, image.file_format = path, "OPEN_EXR"
            image.save()
        return _load(path, space, "CHANNEL_PACKED", _color)
