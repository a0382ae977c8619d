"""OpenEXR files as arrays: float32, row 0 at the bottom. The one file that flips rows.

The package OpenEXR is imported inside the functions, and never in a Blender program: there its
``exr_*`` calls bind to the library that Blender itself has loaded, which crashes some versions.
Plain Python, and Python with the bpy module, are sound.

Channel names are Blender's: ``ViewLayer.Combined.R`` is channel R of the pass Combined of the view
layer ViewLayer. Blender 4 writes all passes as one part of the file, Blender 5 one part a pass.
"""

from __future__ import annotations

import os
import secrets
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

# Letters of a layer's channels by their number, and of the layers that Blender letters otherwise.
_LETTERS = {1: "V", 3: "RGB", 4: "RGBA"}
_LETTERS_BY_NAME = {
    "depth": "Z",
    "position": "XYZ",
    "normal": "XYZ",
    "object index": "X",
    "indexob": "X",
    "material index": "X",
    "indexma": "X",
    "debug sample count": "X",
}
_ORDER = "RGBAXYZWUV"  # how the channels of a layer that is read are put in order


class Part(NamedTuple):
    """One part of a file. view: whose all of it is, or its channels whose names tell of no view;
    views: those that names may tell of; channels: name -> OpenEXR.Channel"""

    name: str
    view: str
    views: tuple[str, ...]
    channels: dict


def read_exr(path: str | os.PathLike) -> dict[str, np.ndarray]:
    """Read every channel of every part: full name -> float32 (h, w), row 0 at the bottom.

    The pixels are those of the data window. Half and uint channels are converted. A multi-part
    file whose parts share channel names has the part's name put before them.
    Raises FileNotFoundError, or OSError for a file that is empty, damaged or not OpenEXR.
    """
    parts = open_parts(os.fspath(path))
    names = [name for part in parts for name in part.channels]
    prefix = len(set(names)) < len(names)
    return {
        f"{part.name}.{name}" if prefix and part.name else name: plane_of(path, name, channel)
        for part in parts
        for name, channel in part.channels.items()
    }


def read_exr_layers(path: str | os.PathLike) -> dict[str, np.ndarray]:
    """Read a file by layers: name -> float32 (h, w, channels), channels as RGBA, XYZW or UV.

    A layer's name is its channels' without the last letter: ``ViewLayer.Combined``; the name of
    channels that are nothing but a letter is empty. Raises as read_exr().
    """
    layers: dict[str, dict[str, np.ndarray]] = {}
    for name, pixels in read_exr(path).items():
        layer, _, letter = name.rpartition(".")
        layers.setdefault(layer, {})[letter] = pixels
    return {
        layer: np.stack([channels[letter] for letter in sorted(channels, key=_rank)], axis=-1)
        for layer, channels in layers.items()
    }


def write_exr_layers(
    path: str | os.PathLike,
    layers: dict[str, np.ndarray],
    view_layer: str = "ViewLayer",
    letters: dict[str, str] | None = None,
    attributes: dict[str, str] | None = None,
    compression: str = "ZIP",
) -> None:
    """Write all layers to one file, whole or not at all: a file that was there stays until then.

    layers: name of a pass -> (h, w, channels) or (h, w), stored as float32; row 0 at the bottom
    view_layer: first word of the channel names; empty = none
    letters: name of a pass -> a letter a channel, where Blender's custom is not wanted
    attributes: name -> text, written into the header
    compression: its name in OpenEXR
    Raises ValueError for layers that make no picture, OSError (with the path) when writing fails.
    """
    openexr = _openexr()
    path = Path(path)
    packing = getattr(openexr, f"{compression}_COMPRESSION")
    header = {"compression": packing, "type": openexr.scanlineimage}
    channels = _channels_of(layers, view_layer, letters or {})
    picture = openexr.File({**header, **(attributes or {})}, channels)
    temporary = str(path.with_name(f".iwis-{os.getpid()}-{secrets.token_hex(4)}.exr"))
    try:
        picture.write(temporary)
        os.replace(temporary, path)
    except (OSError, RuntimeError) as error:
        raise OSError(f"{path}: cannot be written: {_reason(error)}") from error
    finally:
        Path(temporary).unlink(missing_ok=True)


def _openexr():
    """The package OpenEXR, unless this process is a Blender program."""
    bpy = sys.modules.get("bpy")  # looked up, not imported: the core runs without Blender
    if bpy is not None and not bpy.app.module:
        raise RuntimeError(
            "the package OpenEXR must not be loaded into Blender's own process: its calls bind to "
            "Blender's OpenEXR library and crash; run it in a process of its own (sys.executable)"
        )
    import OpenEXR

    return OpenEXR


def open_parts(path: str) -> list[Part]:
    """The parts of a file that is sound. Raises as read_exr()."""
    if not os.path.exists(path):
        raise FileNotFoundError(f"{path}: there is no such file")
    if not os.path.isfile(path):
        raise OSError(f"{path}: is not a file")
    if os.path.getsize(path) == 0:
        raise OSError(f"{path}: the file is empty")
    with open(path, "rb") as file:
        if file.read(4) != b"\x76\x2f\x31\x01":
            raise OSError(f"{path}: is not an OpenEXR file")
    openexr = _openexr()
    try:
        # A part that cannot be read is left out by the package with no more than a warning.
        wanted = len(openexr.File(path, header_only=True).parts)
        parts = openexr.File(path, separate_channels=True).parts
    except Exception as error:  # the package raises RuntimeError, ValueError, IndexError, TypeError
        raise OSError(f"{path}: the file is damaged: {_reason(error)}") from error
    if len(parts) < wanted or not parts:
        raise OSError(f"{path}: the file is damaged: its pixels cannot be read")
    return [_part_of(part) for part in parts]


def _part_of(part) -> Part:
    views = tuple(part.header.get("multiView") or ())
    own = part.header.get("view") or (*views, "")[0]
    return Part(part.name() or "", own, views, part.channels)


def plane_of(path, name: str, channel) -> np.ndarray:
    """float32 (h, w) of an OpenEXR.Channel, row 0 at the bottom. Raises OSError."""
    pixels = channel.pixels
    if getattr(pixels, "ndim", 0) != 2 or pixels.dtype == object:
        raise OSError(f"{path}: channel {name} holds deep pixels, which are not supported")
    if (channel.xSampling, channel.ySampling) != (1, 1):
        raise OSError(f"{path}: channel {name} is subsampled, which is not supported")
    return np.ascontiguousarray(pixels[::-1], np.float32)


def _channels_of(layers, view_layer, letters):
    """{channel's full name: float32 (h, w), row 0 at the top} of all layers, checked."""
    shape = None
    channels = {}
    for name, pixels in layers.items():
        pixels = np.asarray(pixels)
        if pixels.ndim == 2:
            pixels = pixels[..., None]
        if pixels.ndim != 3 or 0 in pixels.shape:
            raise ValueError(f"layer {name}: expected (h, w, channels), got {pixels.shape}")
        shape = shape or pixels.shape[:2]
        if pixels.shape[:2] != shape:
            raise ValueError(f"layer {name}: is {pixels.shape[:2]}, other layers are {shape}")
        for letter, plane in zip(
            _letters_of(name, pixels.shape[2], letters), np.moveaxis(pixels, 2, 0), strict=True
        ):
            full_name = ".".join(filter(None, (view_layer, name, letter)))
            channels[full_name] = np.ascontiguousarray(plane[::-1], np.float32)
    if not channels:
        raise ValueError("there is no layer to write")
    return channels


def _letters_of(name, count, chosen):
    letters = chosen.get(name) or _LETTERS_BY_NAME.get(name.lower()) or _LETTERS.get(count, "")
    if len(letters) != count:
        raise ValueError(f"layer {name}: {count} channels, but letters {letters!r}")
    return letters


def _reason(error) -> str:
    text = getattr(error, "strerror", None) or str(error)
    # 'Cannot open image file "...". No such file or directory.': the path stands before already
    return text.rpartition('". ')[2].rstrip(".") or type(error).__name__


def _rank(letter):
    found = _ORDER.find(letter.upper()) if len(letter) == 1 else -1
    return (found if found >= 0 else len(_ORDER), letter)
