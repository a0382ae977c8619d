"""Mitsuba 3 on an exported scene, by a process of its own (mitsuba_worker.py).

    python benchmarks/run_mitsuba.py FOLDER     make a virtual environment that has mitsuba

Mitsuba gets the triangles, camera and HDRI as the core has them. Its "principled" BSDF is not
Blender's: on glossy scenes its converged picture is another one, and its error is taken against it.
"""

from __future__ import annotations

import contextlib
import json
import math
import subprocess
import sys
import tempfile
import venv
from pathlib import Path
from typing import NamedTuple

import numpy as np

from iwis.core.scene import DIFFUSE, PERSPECTIVE, PRINCIPLED, Scene

WORKER = Path(__file__).resolve().parent / "mitsuba_worker.py"
VERSION = "mitsuba==3.9.*"


class MitsubaPicture(NamedTuple):
    """rgb: float32 (h, w, 3), row 0 at the bottom; cpu, wall: seconds; samples: a pixel."""

    rgb: np.ndarray
    cpu: float
    wall: float
    samples: int


class MitsubaRun:
    """A worker with the scene loaded; use it in a ``with`` statement.

    version: of Mitsuba; load_cpu: seconds of CPU to load the scene and build its BVH and tables
    """

    def __init__(self, python: Path, scene: Scene, threads: int):
        self._folder = tempfile.TemporaryDirectory(prefix="iwis-mitsuba-")
        path = Path(self._folder.name) / "scene.npz"
        self._log = open(path.with_name("log"), "w+")
        np.savez(path, **describe(scene))
        self._process = subprocess.Popen(
            [python, WORKER, path, str(threads)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            text=True,
        )
        try:
            hello = self._answer()
        except OSError:
            self.__exit__()
            raise
        self.version, self.load_cpu = hello["version"], hello["cpu"]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()
        self._log.close()
        self._folder.cleanup()

    def render(self, samples: int, seed: int, emitter: int, bsdf: int) -> MitsubaPicture:
        """A picture of so many camera paths a pixel, or a bit more: see square_count()."""
        path = Path(self._folder.name) / "picture.npy"
        order = {
            "samples": square_count(samples),
            "seed": seed,
            "emitter": emitter,
            "bsdf": bsdf,
            "path": str(path),
        }
        self._process.stdin.write(json.dumps(order) + "\n")
        self._process.stdin.flush()
        answer = self._answer()
        return MitsubaPicture(np.load(path), answer["cpu"], answer["wall"], answer["samples"])

    def _answer(self) -> dict:
        line = self._process.stdout.readline()
        if not line:
            code = self._process.wait()
            self._log.seek(0)
            raise OSError(f"Mitsuba ended with exit code {code}:\n{self._log.read()[:1500]}")
        return json.loads(line)


def square_count(samples: int) -> int:
    """The square of 2 ** k or 3 * 2 ** k next to a count: full grids of strata, in even parts."""
    side = [base << k for base in (2, 3) for k in range(12)]
    return min((s * s for s in side), key=lambda n: abs(math.log(n / samples)))


def describe(scene: Scene) -> dict:
    """The arrays that mitsuba_worker.py reads. Raises ValueError for what it cannot render."""
    camera, environment = scene.camera, scene.environment
    if camera.kind != PERSPECTIVE:
        raise ValueError("Mitsuba is only given perspective cameras")
    arrays = {
        "radiance": environment.radiance * environment.strength,
        "world_to_map": environment.world_to_map[:, :3],
        "camera_to_world": np.asarray(camera.camera_to_world, np.float64),
        "window": np.array(camera.window),
        "size": np.array([camera.width, camera.height]),
        "clip_start": camera.clip_start,
    }
    mesh, n = scene.mesh, 0
    for material in np.unique(mesh.material_index):
        for row in np.unique(mesh.object_index[mesh.material_index == material]):
            chosen = (mesh.material_index == material) & (mesh.object_index == row)
            vertices, faces, normals = _part(mesh, np.flatnonzero(chosen))
            arrays |= {f"vertices{n}": vertices, f"faces{n}": faces}
            if normals is not None:
                arrays[f"normals{n}"] = normals
            arrays[f"bsdf{n}"] = json.dumps(_bsdf(scene.materials, int(material)))
            n += 1
    return arrays | {"meshes": n}


def _part(mesh, rows):
    """Some triangles: vertices (n, 3), faces uint32 (m, 3), and vertex normals or None if flat."""
    corners, normals = mesh.triangles[rows], mesh.corner_normals[rows]
    used, faces = np.unique(corners, return_inverse=True)
    faces, vertices = faces.reshape(-1, 3).astype(np.uint32), mesh.vertices[used]
    if np.abs(normals - normals[:, :1]).max() < 1e-6:
        return vertices, faces, None
    shared = np.empty_like(vertices)
    shared[faces] = normals
    if np.abs(shared[faces] - normals).max() < 1e-5:
        return vertices, faces, shared
    alone = np.arange(3 * len(rows), dtype=np.uint32).reshape(-1, 3)
    return mesh.vertices[corners].reshape(-1, 3), alone, normals.reshape(-1, 3)


def _bsdf(materials, row) -> dict:
    color = {"type": "rgb", "value": [float(c) for c in materials.base_color[row]]}
    model = materials.model[row]
    if model == DIFFUSE:
        inner = {"type": "diffuse", "reflectance": color}
    elif model == PRINCIPLED:
        inner = {
            "type": "principled",
            "base_color": color,
            "roughness": float(materials.roughness[row]),
            "metallic": float(materials.metallic[row]),
            "eta": float(materials.ior[row]),
        }
    else:
        raise ValueError(f"Mitsuba is not given materials of model {model}")
    return {"type": "twosided", "bsdf": inner}


def make_environment(folder: Path) -> Path:
    """The Python of a virtual environment that has mitsuba, made if it is not there."""
    python = folder / "bin" / "python"
    if not python.exists():
        venv.create(folder, with_pip=True)
    command = [
        python,
        "-m",
        "pip",
        "install",
        "-qq",
        "--disable-pip-version-check",
        VERSION,
        "numpy",
    ]
    subprocess.run(command, check=True, stdout=sys.stderr)
    return python


if __name__ == "__main__":
    print(make_environment(Path(sys.argv[1])))
