"""OpenEXR files with layers, or parts: Blender hands out no pixels of theirs.

What Cycles shows of one is written to a plain file, and that is read in its place. Measured in
Blender 4.5 and 5.2: only alpha that is said to be straight is another thing there than in plain
files: 4.5 takes it for premultiplied, from 5.1 on the colors are multiplied by it, if they are all
that the first part holds; packed, they are even where they are data.
"""

from __future__ import annotations

import os
import tempfile
from contextlib import contextmanager
from typing import NamedTuple

import bpy

from ...exr_process import write_picture

# Passes that come first in a layer of what is packed, in this order; others by their names.
_PASSES_OF_4 = (
    *("Combined", "Depth", "Shadow", "AO", "Normal", "Vector", "IndexOB", "UV", "Mist", "Emit"),
    *("Env", "IndexMA", "DiffDir", "DiffInd", "DiffCol", "GlossDir", "GlossInd", "GlossCol"),
    *("TransDir", "TransInd", "TransCol", "SubsurfaceDir", "SubsurfaceInd", "SubsurfaceCol"),
)
_KINDS = ("Direct", "Indirect", "Color")
_PASSES_OF_5 = (
    *("Combined", "Depth", "Shadow", "Ambient Occlusion", "Normal", "Vector", "Object Index"),
    *("UV", "Mist", "Emission", "Env", "Environment", "Material Index"),
    *(f"{lobe} {kind}" for lobe in ("Diffuse", "Glossy", "Transmission") for kind in _KINDS),
    *(f"Subsurface {kind}" for kind in _KINDS),
)


class LayersError(ValueError):
    """There is no picture in the file. The text says why and what to do."""


class PlainFile(NamedTuple):
    """What is shown of an image with layers, as plain OpenEXR; space: of its texels; packed:
    whether it is to be read as the texels of packed files are"""

    path: str
    space: str
    packed: bool


def has_layers(image) -> bool:
    """Of a data-block that Blender has read."""
    return image.type == "MULTILAYER"


def _packed_file(image):
    """Stereo images have one for each view, all of the same file."""
    return image.packed_file or (image.packed_files[0].packed_file if image.packed_files else None)


@contextmanager
def plain_file(image, path: str):
    """A PlainFile of an image with layers, for a moment. path: of its own. Raises LayersError."""
    packed, space = _packed_file(image), image.colorspace_settings
    straight = image.alpha_mode == "STRAIGHT" and bpy.app.version >= (5, 1)
    straight = straight and (packed is not None or not space.is_data)
    passes = _PASSES_OF_5 if bpy.app.version >= (5, 0) else _PASSES_OF_4
    try:
        with tempfile.TemporaryDirectory(prefix="iwis-layers-") as folder:
            if packed is not None:
                path = os.path.join(folder, "packed.exr")
                with open(path, "wb") as file:
                    file.write(packed.data)
            plain = os.path.join(folder, "picture.exr")
            order = [] if packed is None else list(passes)
            colors = write_picture(path, plain, order, straight, not bpy.app.module)
            yield PlainFile(plain, space.name if colors else "Non-Color", packed is not None)
    except ImportError as error:
        told = "has layers, which the Python package OpenEXR reads, and that cannot be loaded"
        raise LayersError(f"image {image.name!r} {told} ({error}): install it") from None
    except OSError as error:
        why = str(error) if packed is None else str(error).replace(path, "its packed file")
        told = f"has layers, and no picture can be made of it ({why})"
        raise LayersError(f"image {image.name!r} {told}: save it as plain OpenEXR") from None
