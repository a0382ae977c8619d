"""Read and write OpenEXR files without loading the OpenEXR package into Blender's own process.

Inside a Blender program the package's calls bind to the OpenEXR that Blender has loaded, which
crashes some versions. There it runs in a process of Blender's Python, which executes this file;
beside the bpy module it is sound and is called directly.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

_ROOT = Path(__file__).resolve().parent.parent
_SECONDS = 600
_FILM, _PICTURE = "film", "picture"  # what a child is to do


def write_exr(
    path: str,
    layers: dict[str, np.ndarray],
    letters: dict[str, str],
    inside_blender: bool,
    space: str = "",
) -> None:
    """Write float32 (height, width, channels) layers, row 0 at the bottom, to one file.

    letters: name of a layer -> one letter a channel; space: of the colors, as Blender writes it
    Raises OSError when the file cannot be written, ImportError without the OpenEXR package.
    """
    if not inside_blender:
        from ..core.exr import write_exr_layers

        told = {"colorInteropID": space} if space else None
        write_exr_layers(path, layers, view_layer="", letters=letters, attributes=told)
        return
    with tempfile.TemporaryDirectory(prefix="iwis-") as folder:
        arrays = os.path.join(folder, "layers.npz")
        np.savez(arrays, **layers)
        _run_child(_FILM, path, arrays, json.dumps(letters), space)


def write_picture(
    source: str, target: str, passes: list[str], straight: bool, inside_blender: bool
) -> bool:
    """As core.exr_picture's. Raises OSError as that does, ImportError without the package."""
    if inside_blender:
        words = json.dumps(passes), json.dumps(straight)
        return json.loads(_run_child(_PICTURE, source, target, *words))
    from ..core import exr_picture

    return exr_picture.write_picture(source, target, passes, straight)


def _run_child(job, path, *words) -> str:
    """The last line that it says.

    Blender's Python finds this add-on, its wheels and numpy where this process finds them.
    """
    name = f"{_ROOT.name}.{Path(__file__).parent.name}.{Path(__file__).stem}"
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join([str(_ROOT.parent), *sys.path]))
    child = subprocess.run(
        [sys.executable, "-m", name, job, path, *words],
        env=environment,
        capture_output=True,
        text=True,
        timeout=_SECONDS,
        check=False,
    )
    if child.returncode:
        lines = child.stderr.strip().splitlines()
        wrong = "cannot be written" if job == _FILM else "cannot be read"
        raise OSError(lines[-1] if lines else f"{path}: {wrong}")
    return child.stdout.strip().rpartition("\n")[2]


def _write_film(path: str, arrays: str, letters: str, space: str) -> None:
    with np.load(arrays) as layers:
        write_exr(path, dict(layers), json.loads(letters), False, space)


def _write_picture(source: str, target: str, passes: str, straight: str) -> None:
    colors = write_picture(source, target, json.loads(passes), json.loads(straight), False)
    sys.stdout.write(json.dumps(colors) + "\n")


def _child(job: str, *words: str) -> None:
    try:
        {_FILM: _write_film, _PICTURE: _write_picture}[job](*words)
    except (ImportError, OSError) as error:
        sys.exit(str(error))


if __name__ == "__main__":
    _child(*sys.argv[1:])
