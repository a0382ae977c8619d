"""Images of Image Texture nodes as core.data.program.ImageTiles: bytes where the file has bytes.

Cycles multiplies colour by alpha when it loads an image, interpolates, and divides again where the
node's Alpha is used. Texels in sRGB are decoded after that.
"""

from __future__ import annotations

import functools
import os
import tempfile
from contextlib import nullcontext

import bpy
import numpy as np

from ....core.data.program import ImageTiles
from ...scratch import scratch
from ..images.color_spaces import srgb_encode
from ..images.image import ImageError, Room, bytes_of, pixels_of, read_by, texels_of
from ..images.movies import frame_of

_FIRST_TILE = 1001


class ImageStore:
    """Each image once, whatever number of nodes and materials show it.

    cache: TexelCache of the job, or None
    """

    def __init__(self, cache=None):
        self._cache = cache
        self._read: dict[tuple, ImageTiles] = {}
        self._left_out: dict[int, list[str]] = {}  # of an image's session_uid: why, for each tile
        self._room = Room()

    def tiles(self, image, image_user) -> ImageTiles:
        """Raises ImageError with what to do."""
        shown = None if self._cache is None else self._cache.frame
        frame = 0
        if image_user is not None and image.source in ("SEQUENCE", "MOVIE"):
            now = shown if image.source == "MOVIE" else None
            frame = frame_of(image_user, now)
        key = image.session_uid, frame
        if key not in self._read:
            kind = _read_tiles if image.source == "TILED" else _read_image
            left_out = self._left_out.setdefault(image.session_uid, [])
            make = functools.partial(kind, room=self._room, frame=shown, left_out=left_out)
            if self._cache is None:
                self._read[key] = make(image, image_user)
            else:
                self._read[key] = self._cache.tiles(image, image_user, make)
        return self._read[key]

    def left_out(self, image) -> list[str]:
        """Why tiles of an image that has been read are not there, one line each."""
        return self._left_out.get(image.session_uid, [])


def _tiles_of(builder, node) -> ImageTiles | None:
    """What a node shows; None, and a warning, where it cannot be read."""
    try:
        if node.image is None:
            raise ImageError("no image is chosen: choose one in the node, or remove the node")
        tiles = builder.images.tiles(node.image, node.image_user)
    except ImageError as error:
        builder.reader.warn(node, f"{error}. Pink instead, as in Cycles")
        return None
    for why in builder.images.left_out(node.image):
        builder.reader.warn(node, f"{why}. The tile is pink, as in Cycles")
    return tiles


def environment_settings(builder, node) -> dict:
    """The settings of core.nodes.images.environment_texture."""
    return {
        "image": _tiles_of(builder, node),
        "interpolation": node.interpolation,
        "extension": "REPEAT",
        "projection": node.projection,
        "tiled": False,
        "unassociate": False,
    }


def image_settings(builder, node) -> dict:
    """The settings of core.nodes.images.image_texture."""
    image = node.image
    straight = image is not None and image.alpha_mode in ("STRAIGHT", "PREMUL")
    data = image is not None and image.colorspace_settings.is_data
    return {
        "image": _tiles_of(builder, node),
        "interpolation": node.interpolation,
        "extension": node.extension,
        "projection": node.projection,
        "projection_blend": node.projection_blend,
        "tiled": image is not None and image.source == "TILED",
        "unassociate": straight and not data and node.outputs["Alpha"].is_linked,
    }


def _read_image(image, image_user, room, frame, **_of_tiles) -> ImageTiles:
    rgba, encoded = _read_rgba(image, image_user, room, frame)
    return ImageTiles({(0, 0): rgba}, encoded)


def _read_tiles(image, _image_user, room, left_out, **_of_movies) -> ImageTiles:
    """The tiles of a UDIM image, each from its own file, or from what is packed; what of them
    cannot be read is not there, and left_out has a line on it. Raises ImageError without any."""
    packed = {entry.tile_number: entry for entry in image.packed_files}
    tiles, encoded = {}, False
    # Only packed tiles pass through a folder: others need none that can be written.
    try:
        place = tempfile.TemporaryDirectory(prefix="iwis-tiles-") if packed else nullcontext()
        with place as folder:
            for tile in image.tiles:
                number = tile.number - _FIRST_TILE
                try:
                    read = _read_tile(image, number, packed.get(tile.number), folder, room)
                except ImageError as error:
                    left_out.append(str(error))
                    continue
                tiles[number % 10, number // 10], encoded = read
    except OSError as error:
        told = f"cannot be put into the temporary folder ({error.strerror or error})"
        raise ImageError(f"image {image.name!r}: its packed tiles {told}: make room") from None
    if not tiles:
        raise ImageError(left_out.pop(0))
    return ImageTiles(tiles, encoded)


def _tile_path(image, number: int) -> str:
    """The file of a tile, counted from 0."""
    path = bpy.path.abspath(image.filepath_raw, library=image.library)
    path = path.replace("<UDIM>", str(number + _FIRST_TILE))
    return path.replace("<UVTILE>", f"u{number % 10 + 1}_v{number // 10 + 1}")


def _read_tile(image, number: int, packed, folder, room):
    """As _read_rgba, of the tile counted from 0. packed: what of it is in the .blend, or None
    folder: to put that into; None where no tile is packed. Raises ImageError with what to do"""
    path = _tile_path(image, number)
    tile = f"image {image.name!r}: tile {number + _FIRST_TILE}"
    if packed is not None:
        path = os.path.join(folder, os.path.basename(path))
        with open(path, "wb") as file:
            file.write(packed.packed_file.data)
    elif not os.path.exists(path):
        raise ImageError(f"{tile}: there is no file {path}")
    with scratch(bpy.data.images, bpy.data.images.load(path)) as loaded:
        loaded.colorspace_settings.name = image.colorspace_settings.name
        loaded.alpha_mode = image.alpha_mode
        if folder is not None:  # one tile that is packed makes Cycles take all as packed
            loaded.pack()
        try:
            return _read_rgba(loaded, None, room)
        except ImageError as error:
            raise ImageError(f"{tile}: {error}") from None


def _read_rgba(image, image_user, room, frame=None) -> tuple[np.ndarray, bool]:
    """(uint8 or float32 (h, w, 4), whether it is sRGB still)."""
    no_alpha = image.alpha_mode == "NONE"

    def read(own):
        rgba = bytes_of(own, room)
        if rgba is None:
            return _floats_of(own, no_alpha)
        if no_alpha:
            rgba[..., 3] = 255
        return rgba, not own.colorspace_settings.is_data

    return read_by(read, image, image_user, frame)


def _floats_of(image, no_alpha) -> tuple[np.ndarray, bool]:
    rgb, encoded = texels_of(image)
    rgba = np.ones((*rgb.shape[:2], 4), np.float32)
    rgba[..., :3] = srgb_encode(rgb) if encoded else rgb
    if not no_alpha:
        rgba[..., 3] = pixels_of(image)[..., 3]
    return rgba, encoded
