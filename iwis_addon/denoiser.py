"""Where Blender keeps Open Image Denoise. An engine written in Python has no other way to it.

blender.org's builds and the bpy module bring the library; a distribution's Blender may do without.
"""

from __future__ import annotations

import functools
import sys
from pathlib import Path

import bpy

from ..core.denoising.denoise import Denoising
from ..core.denoising.oidn import load_library
from ..core.settings import DenoiseSettings

# Beside Blender's folder of scripts: Linux and macOS, Windows, Windows' bpy module.
_FOLDERS = ("lib", "blender.shared", "")
_NAMES = ("libOpenImageDenoise.*", "OpenImageDenoise.dll")
_SYSTEMS = "libOpenImageDenoise.so.2"  # where Linux looks for libraries


def denoising(settings: DenoiseSettings) -> Denoising:
    """What the core takes, with the library where one is needed."""
    return Denoising(settings, *find_library()) if settings.denoise else Denoising(settings)


@functools.cache
def find_library() -> tuple[str, str]:
    """Path of the library, and why there is none where it is empty: one line for the user."""
    problem = "this Blender has no Open Image Denoise; those of blender.org have it"
    for path in _library_paths():
        try:
            load_library(path)
            return path, ""
        except OSError as error:
            if path != _SYSTEMS:
                problem = f"Open Image Denoise does not load: {error}"
    return "", problem


def _library_paths() -> list[str]:
    """Blender's own first, then the system's."""
    known = [bpy.utils.resource_path(kind) for kind in ("LOCAL", "SYSTEM")]
    known.append(bpy.app.binary_path)
    found = [
        str(path)
        for root in dict.fromkeys(Path(place).resolve().parent for place in known if place)
        for folder in _FOLDERS
        for name in _NAMES
        for path in sorted((root / folder).glob(name))
    ]
    return [*found, _SYSTEMS] if sys.platform == "linux" else found
