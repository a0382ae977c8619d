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
from typing import NamedTuple

import bpy
import numpy as np

from .color_spaces import working_space

log = logging.getLogger(__name__)

HEIGHT = 1024  # pixels; the sun's disc is three wide
_SECONDS = 300
_KEPT = 12  # skies on disk, 25 MB each
_SCRIPT = Path(__file__).resolve().parents[2] / "sky_process.py"
_LAST: dict[str, np.ndarray] = {}  # the sky of the frame before, and of this one


class SkyError(RuntimeError):
    """There is no picture of the sky. The text says why."""


class Skies:
    """How the world's skies are read: each is waited for. late_sky.py has another way."""

    def begin(self) -> None:
        """Before a world is read."""

    def read(self, node) -> np.ndarray | None:
        """As read_sky; None where it is not there yet, and no other stands for it."""
        return read_sky(node)


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
    wanted = SkyWanted.of(node, height)
    sky = kept_sky(wanted)
    if sky is None:
        sky = render_sky(wanted, Launch.here())
        remember(wanted, sky)
    return sky


class SkyWanted(NamedTuple):
    """The picture of a sky; key: its name in the cache; settings: sky_settings, as JSON; space: the
    working space of its colors"""

    key: str
    settings: str
    height: int
    space: str

    @classmethod
    def of(cls, node, height: int = HEIGHT) -> SkyWanted:
        """Of a Sky Texture as it is now."""
        from ....core.wavelets.table_cache import table_key  # numba may be missing

        settings, space = json.dumps(sky_settings(node), sort_keys=True), working_space()
        key = table_key("sky", settings, height, space, bpy.app.version[:2])
        return cls(key, settings, height, space)


def kept_sky(wanted: SkyWanted) -> np.ndarray | None:
    """A sky that was rendered before, from memory or disk."""
    from ....core.wavelets.table_cache import load_arrays, table_folder

    if wanted.key not in _LAST:
        found = load_arrays(table_folder(""), wanted.key, ["sky"])
        if not found:
            return None
        remember(wanted, np.ascontiguousarray(found[0], np.float32))
    return _LAST[wanted.key]


def remember(wanted: SkyWanted, sky: np.ndarray) -> None:
    """Have kept_sky find it."""
    while len(_LAST) > 1:
        _LAST.pop(next(iter(_LAST)))
    _LAST[wanted.key] = sky


class Launch(NamedTuple):
    """How sky_process.py is started: words before its own, and the environment."""

    command: list[str]
    environment: dict[str, str]

    @classmethod
    def here(cls) -> Launch:
        """By the Blender that runs."""
        environment = dict(os.environ)
        if bpy.app.binary_path:
            options = ["--background", "--factory-startup", "--python-exit-code", "1", "--python"]
            return cls([bpy.app.binary_path, *options, str(_SCRIPT), "--"], environment)
        own = bpy.utils.resource_path("LOCAL")  # there "bpy" is another one
        places = [place for place in sys.path if place and not place.startswith(own)]
        environment["PYTHONPATH"] = os.pathsep.join(places)
        return cls([sys.executable, str(_SCRIPT)], environment)


def render_sky(wanted: SkyWanted, launch: Launch, started=lambda child: None) -> np.ndarray:
    """As read_sky, and kept on disk; asks nothing of Blender's own, so any thread may call it.

    started(child) is told of the process that renders it.
    """
    from ....core.wavelets.table_cache import table_folder

    with tempfile.TemporaryDirectory(prefix="iwis-") as folder:
        path = os.path.join(folder, "sky.npy")
        command = [*launch.command, wanted.settings, str(wanted.height), wanted.space, path]
        _run(command, launch.environment, started, path)
        sky = np.ascontiguousarray(np.load(path), np.float32)
    _keep(table_folder(""), wanted.key, sky)
    return sky


def _run(command, environment, started, path) -> None:
    output = subprocess.PIPE
    try:
        with subprocess.Popen(
            command, env=environment, stdout=output, stderr=output, text=True, errors="replace"
        ) as child:
            started(child)
            try:
                out, err = child.communicate(timeout=_SECONDS)
            except subprocess.TimeoutExpired:
                child.kill()
                raise
    except (OSError, subprocess.TimeoutExpired) as error:
        raise SkyError(f"Blender could not be started to render it: {error}") from None
    if child.returncode or not os.path.exists(path):
        lines = (err.strip() or out.strip()).splitlines()
        errors = [line for line in lines if "Error" in line]
        said = (errors or lines or [f"Blender answered {child.returncode}"])[-1]
        raise SkyError(said)


def _keep(folder: Path, key: str, sky) -> None:
    """On disk, in place of the oldest one."""
    from ....core.wavelets.table_cache import save_arrays

    warning = save_arrays(folder, key, {"sky": sky})
    if warning:
        log.warning("%s", warning)
    try:
        kept = sorted(folder.glob("sky-*.npz"), key=lambda path: path.stat().st_mtime)
        for path in kept[:-_KEPT]:
            path.unlink(missing_ok=True)
    except OSError as error:
        log.warning("cache folder %s: %s", folder, error)
