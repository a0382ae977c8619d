"""The picture of a Sky Texture: rendered once by Cycles for its settings, and kept on disk.

Blender cannot render within a render job, so another process of Blender does (sky_process.py).
"""

from __future__ import annotations

import json
import logging
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

log = logging.getLogger(__name__)

HEIGHT = 1024  # pixels; the sun's disc is three wide
_SECONDS = 300
_KEPT = 12  # skies on disk, 25 MB each
_SCRIPT = Path(__file__).resolve().parent.parent / "sky_process.py"
_LAST: dict[str, np.ndarray] = {}  # the sky of the frame before, and of this one


class SkyError(RuntimeError):
    """There is no picture of the sky. The text says why."""


def sky_settings(node) -> dict:
    """All that a Sky Texture's light depends on, by the names of its properties."""
    common = {prop.identifier for prop in bpy.types.Node.bl_rna.properties}
    settings = {}
    for prop in node.bl_rna.properties:
        if prop.identifier in common or prop.type == "POINTER":
            continue
        value = getattr(node, prop.identifier)
        settings[prop.identifier] = list(value) if getattr(prop, "is_array", False) else value
    return settings


def read_sky(node, height: int = HEIGHT) -> np.ndarray:
    """float32 (height, 2 height, 3), row 0 at the bottom: an Environment Texture's picture of it.

    The very same array while the settings stay. Raises SkyError where it cannot be rendered.
    """
    from ...core.table_cache import load_arrays, table_folder, table_key  # numba may be missing

    settings = json.dumps(sky_settings(node), sort_keys=True)
    key = table_key("sky", settings, height, bpy.app.version[:2])
    if key not in _LAST:
        folder = table_folder("")
        found = load_arrays(folder, key, ["sky"])
        sky = found[0] if found else _rendered(settings, height)
        if not found:
            _keep(folder, key, sky)
        while len(_LAST) > 1:
            _LAST.pop(next(iter(_LAST)))
        _LAST[key] = np.ascontiguousarray(sky, np.float32)
    return _LAST[key]


def _keep(folder: Path, key: str, sky) -> None:
    """On disk, in place of the oldest one."""
    from ...core.table_cache import save_arrays

    warning = save_arrays(folder, key, {"sky": sky})
    if warning:
        log.warning("%s", warning)
    try:
        kept = sorted(folder.glob("sky-*.npz"), key=lambda path: path.stat().st_mtime)
        for path in kept[:-_KEPT]:
            path.unlink(missing_ok=True)
    except OSError as error:
        log.warning("cache folder %s: %s", folder, error)


def _rendered(settings: str, height: int) -> np.ndarray:
    with tempfile.TemporaryDirectory(prefix="iwis-") as folder:
        path = os.path.join(folder, "sky.npy")
        environment = dict(os.environ)
        if bpy.app.binary_path:
            command = [
                bpy.app.binary_path,
                "--background",
                "--factory-startup",
                "--python-exit-code",
            ]
            command += ["1", "--python", str(_SCRIPT), "--"]
        else:  # the bpy module
            command = [sys.executable, str(_SCRIPT)]
            own = bpy.utils.resource_path("LOCAL")  # there "bpy" is another one
            places = [place for place in sys.path if place and not place.startswith(own)]
            environment["PYTHONPATH"] = os.pathsep.join(places)
        command += [settings, str(height), path]
        try:
            child = subprocess.run(
                command,
                env=environment,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=_SECONDS,
                check=False,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise SkyError(f"Blender could not be started to render it: {error}") from None
        if child.returncode or not os.path.exists(path):
            lines = (child.stderr.strip() or child.stdout.strip()).splitlines()
            errors = [line for line in lines if "Error" in line]
            said = (errors or lines or [f"Blender answered {child.returncode}"])[-1]
            raise SkyError(said)
        return np.load(path)
