"""What the figures show: a mesh, and three pairs of material and probe.

With --data DIR, the paper's own data as far as the user has it:

    DIR/mesh/*.obj           the figure, y up (happy_buddha.obj if there are several)
    DIR/env/grace.hdr        lat-long probes, .hdr or .exr: grace, rnl, uffizi
    DIR/brdf/NAME.binary     MERL's tables: blue-rubber, purple-paint, alum-bronze

Without, what comes with a checkout of IWIS: sample_blends/ and materials.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..core._jit import user_cache_dir
from ..core.bsdf.measured import read_measured
from ..core.scene import (
    GGX,
    MEASURED,
    PERSPECTIVE,
    Camera,
    EnvironmentMap,
    MaterialParams,
    MeasuredBrdfs,
    Scene,
    TriangleMesh,
)
from .files import read_obj, read_probe, smooth_mesh
from .materials import fitted_material

MATERIALS = ("blue-rubber", "purple-paint", "alum-bronze")
PROBES = ("grace", "rnl", "uffizi")
STAND_INS = ("hall", "sunrise", "workshop")
VIEW_DEG, MARGIN = 20.0, 1.02
_SAMPLES = Path(__file__).resolve().parents[1] / "sample_blends"


class InputError(Exception):
    """Data that is missing or unreadable, in one line."""


class Pair(NamedTuple):
    """A picture of figure 4."""

    material: str
    probe: str
    environment: EnvironmentMap
    measured: MeasuredBrdfs


@dataclass(frozen=True, slots=True, eq=False)
class Inputs:
    """mesh: z up, the front towards -y; is_paper: whether it is the user's data; source: a line"""

    mesh: TriangleMesh
    pairs: tuple[Pair, ...]
    is_paper: bool
    source: str


def load_inputs(data: Path | None) -> Inputs:
    """The user's data, or what comes with IWIS. Raises InputError."""
    try:
        return _own_inputs() if data is None else _paper_inputs(data)
    except (OSError, ValueError) as error:
        raise InputError(str(error)) from None


def _paper_inputs(data: Path) -> Inputs:
    if not data.is_dir():
        raise InputError(f"{data}: there is no such folder")
    meshes = sorted((data / "mesh").glob("*.obj"), key=lambda path: path.stem != "happy_buddha")
    if not meshes:
        raise InputError(f"{data}: has no mesh/*.obj (the figure, y up)")
    probes = [_find(data / "env", name, (".hdr", ".exr")) for name in PROBES]
    tables = [_find(data / "brdf", name, (".binary",)) for name in MATERIALS]
    pairs = tuple(
        Pair(material, probe, read_probe(light), read_measured(table, user_cache_dir() / "tables"))
        for material, probe, light, table in zip(MATERIALS, PROBES, probes, tables, strict=True)
    )
    mesh = read_obj(meshes[0])
    return Inputs(mesh, pairs, True, f"{data}: {meshes[0].stem}, {len(mesh.triangles)} triangles")


def _find(folder: Path, name: str, endings) -> Path:
    for ending in endings:
        if (folder / (name + ending)).is_file():
            return folder / (name + ending)
    raise InputError(f"{folder}: has no {' or '.join(name + ending for ending in endings)}")


def _own_inputs() -> Inputs:
    if not (_SAMPLES / "hdri").is_dir():
        raise InputError("without --data this needs a checkout of IWIS, for its sample_blends/")
    pairs = tuple(
        Pair(
            material,
            probe,
            read_probe(_SAMPLES / "hdri" / f"{probe}.exr"),
            fitted_material(material),
        )
        for material, probe in zip(MATERIALS, STAND_INS, strict=True)
    )
    mesh = _statue()
    text = f"what comes with IWIS: the statue of sample_blends, {len(mesh.triangles)} triangles"
    return Inputs(mesh, pairs, False, text)


def _statue() -> TriangleMesh:
    """The figure of statue.blend, without its plinth and without subdivision."""
    try:
        import bpy
    except ImportError:
        raise InputError(
            "without --data this needs the sample figure, and bpy to open it"
        ) from None
    bpy.ops.wm.open_mainfile(filepath=str(_SAMPLES / "statue.blend"))
    figure = max(
        (o for o in bpy.data.objects if o.type == "MESH"), key=lambda o: len(o.data.polygons)
    )
    figure.data.calc_loop_triangles()
    vertices = np.empty((len(figure.data.vertices), 3), np.float32)
    triangles = np.empty((len(figure.data.loop_triangles), 3), np.int32)
    figure.data.vertices.foreach_get("co", vertices.ravel())
    figure.data.loop_triangles.foreach_get("vertices", triangles.ravel())
    matrix = np.array(figure.matrix_world)
    return smooth_mesh(vertices @ matrix[:3, :3].T + matrix[:3, 3], triangles)


def make_scene(inputs: Inputs, pair: Pair, size: tuple[int, int]) -> Scene:
    """A picture of figure 4: the mesh of one measured material, filling the frame."""
    row = np.ones((1, 3), np.float32)
    one, zero = np.ones(1, np.float32), np.zeros((1, 3), np.float32)
    models = np.full(1, MEASURED, np.int8), np.full(1, GGX, np.int8)
    smooth = np.zeros(1, np.float32)
    materials = MaterialParams(*models, row, one, one, one, one, row, zero, smooth)
    return Scene(
        mesh=inputs.mesh,
        materials=materials,
        environment=pair.environment,
        camera=_framing(inputs.mesh.vertices.astype(np.float64), size),
        material_pass_index=one,
        object_pass_index=one,
        measured=pair.measured,
    )


def _framing(vertices, size) -> Camera:
    """A camera that looks along +y and whose picture the vertices fill."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle = (low + high) / 2.0
    # VIEW_DEG is across the picture's long side.
    half = math.tan(math.radians(VIEW_DEG) / 2.0)
    slopes = half * np.array(size) / max(size)
    aside = np.abs(vertices - middle)[:, [0, 2]] * MARGIN / slopes
    distance = (aside.max(axis=1) + middle[1] - vertices[:, 1]).max()
    place = middle - np.array([0.0, distance, 0.0])
    matrix = np.eye(4)
    matrix[:3, :3] = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    matrix[:3, 3] = place
    return Camera(
        kind=PERSPECTIVE,
        camera_to_world=matrix,
        window=(-slopes[0], slopes[0], -slopes[1], slopes[1]),
        width=size[0],
        height=size[1],
        region=(0, 0, *size),
        clip_start=1e-3,
        clip_end=1e4,
    )
