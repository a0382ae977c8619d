"""An object with adaptive subdivision: its cage to a mesh of micropolygons, as Cycles dices it."""

from __future__ import annotations

import hashlib
from typing import NamedTuple

import numpy as np

from ..errors import ExportCancelled
from ..free_memory import free_memory_bytes
from .adaptive import Dicing, Fineness
from .cage import Cage, after_steps, control_of, face_of_patches, on_patches, read_cage
from .element_values import read_values
from .local_mesh import LocalMesh
from .mesh_size import MOST_TRIANGLES

# Steps before patches: around points that are not regular these are only near the surface.
_STEPS, _MOST_PATCHES = 3, 40_000
_FADED = 0.5  # creases that are left then count as sharp, or not at all
_FEW_PIXELS = 4.0  # of a size: patches that are smaller need no more steps
# Of a micropolygon: in its own space, in the table, its hierarchy and what materials ask for.
_BYTES = 500
_COARSER = 1.4


class Diced(NamedTuple):
    """Where a LocalMesh's triangles are on the cage.

    made: micropolygons.Micropolygons; steps: of subdivision, from its patches to their parts
    """

    cage: Cage
    fineness: Fineness
    steps: int
    made: object

    @property
    def steps_in_all(self) -> int:
        """From the cage's faces."""
        return 1 + self.steps


class DicedSource:
    """What surface_data.py reads of a diced part: the cage, while the graph lives."""

    def __init__(self, obj):
        # Its last modifier is left to whoever asks: what is asked is the mesh before it.
        self._geometry = obj.evaluated_geometry()
        self.mesh = self._geometry.mesh_base


def read_diced(
    obj, source: DicedSource, fineness: Fineness, dicing: Dicing, known, cancelled, warnings
) -> LocalMesh | None:
    """The part of an object; None if it has no face. known: as for read_mesh

    warnings: of what memory is too small for
    Raises ExportCancelled if cancelled() says so half way.
    """
    mesh = source.mesh
    if mesh is None or len(mesh.polygons) == 0:
        return None
    cage, view = read_cage(mesh, fineness), dicing.view_of(obj, fineness)
    digest = b"" if known is None else _digest(cage, fineness, view)
    if known and digest in known:
        return known[digest]
    if cancelled():
        raise ExportCancelled
    return _diced(obj.name, mesh, cage, fineness, view, digest, warnings)


def _digest(cage: Cage, fineness: Fineness, view) -> bytes:
    state = hashlib.sha256(repr(fineness).encode())
    for part in (*cage, *view):
        arrays = part if isinstance(part, tuple) else (part,)
        for array in arrays:
            state.update(b"-" if array is None else np.ascontiguousarray(array))
    return state.digest()


def _diced(name, mesh, cage: Cage, fineness: Fineness, view, digest, warnings) -> LocalMesh:
    from ....core.fine_meshes.dicing import Patches
    from ....core.fine_meshes.micropolygons import make_micropolygons
    from ....core.fine_meshes.patch_values import at_vertices, evaluate

    # Cycles splits quads once, too, as it does all other faces.
    whole = after_steps(control_of(cage, fineness, cage.positions), fineness.linear, 1)
    parts, steps = whole, 0
    while not _is_fine(parts, fineness, view, 1 + steps):
        parts, steps = after_steps(parts, fineness.linear, 1), steps + 1
    points = patches_of(parts, fineness)
    quads = whole.corners.reshape(-1, 4), whole.edge_of.reshape(-1, 4)
    patches = Patches(points, *quads, whole.ends, len(whole.points), 1, steps)
    split = _split(name, patches, view, fineness, warnings)
    made = make_micropolygons(*split)
    positions, normals = evaluate(points, steps, made)
    if fineness.linear:
        normals = at_vertices(_linear_normals(mesh, cage), made)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.float32(1e-20))
    faces = face_of_patches(cage)[made.patch]
    slots = cage.slots[faces] if cage.slots.any() else None
    triangles = made.triangles
    own = positions, triangles, normals, triangles, cage.flat[faces], slots, triangles, digest
    return LocalMesh(*own, diced=Diced(cage, fineness, steps, made))


def _is_fine(control, fineness: Fineness, view, level: int) -> bool:
    """Whether patches of a control mesh of quads are near enough to its surface."""
    quads = len(control.starts) - 1
    finite = control.sharp[np.isfinite(control.sharp)].max(initial=0.0)
    if fineness.linear or 4 * quads > _MOST_PATCHES or (level >= _STEPS and finite <= _FADED):
        return True
    from ....core.fine_meshes.dicing_view import longest_edge

    return longest_edge(control.points, control.ends, view) < _FEW_PIXELS * fineness.size


def patches_of(control, fineness: Fineness) -> np.ndarray:
    """float32 (f, 4, 4, 3), of core.bezier_patches."""
    from ....core.fine_meshes.bezier_patches import flat_patches, smooth_patches

    if fineness.linear:
        return flat_patches(control.points[control.corners.reshape(-1, 4)])
    return smooth_patches(control)


def _split(name, patches, view, fineness: Fineness, warnings):
    """Of core.dicing, as fine as memory allows."""
    from ....core.fine_meshes.dicing import split_patches

    free, size = free_memory_bytes(), fineness.size
    limit = MOST_TRIANGLES if free is None else min(MOST_TRIANGLES, int(free) // _BYTES)
    limit = max(limit, 4 * len(patches.corners))
    coarser = _COARSER
    while (split := split_patches(patches, view, fineness.max_level, limit)) is None:
        size *= coarser
        view = view._replace(rate=np.float32(size))
        coarser *= coarser  # a size that is far off is not come to by small steps
    if size != fineness.size:
        unit = "m" if fineness.in_space else "pixels"
        warnings.append(
            f"Object {name}: diced to edges of {size:.3g} {unit} in place of {fineness.size:.3g}: "
            f"finer it would be more than {limit:,} triangles, which memory has no room for. "
            "Raise the dicing rate, or the pixel size of its modifier"
        )
    return split


def _linear_normals(mesh, cage: Cage) -> np.ndarray:
    """float32 (f, 4, 3), of patches: those of the cage's vertices, of flat faces too."""
    normals = read_values(mesh.vertex_normals, "vector", 3, np.float32)[cage.corners]
    return on_patches(normals, cage.starts)


def shape_at(local: LocalMesh, obj) -> tuple[np.ndarray, np.ndarray] | None:
    """Positions and normals of a diced part at another time, (n, 3) each; None where its cage has
    other vertices or faces."""
    from ....core.fine_meshes.patch_values import at_vertices, evaluate

    diced, source = local.diced, DicedSource(obj)
    cage, mesh = diced.cage, source.mesh
    if mesh is None or len(mesh.vertices) != len(cage.positions):
        return None
    if len(mesh.loops) != len(cage.corners):
        return None
    positions = read_values(mesh.vertices, "co", 3, np.float32)
    linear = diced.fineness.linear
    control = after_steps(control_of(cage, diced.fineness, positions), linear, diced.steps_in_all)
    points = patches_of(control, diced.fineness)
    places, normals = evaluate(points, diced.steps, diced.made)
    if linear:
        normals = at_vertices(_linear_normals(mesh, cage), diced.made)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.float32(1e-20))
    return places, normals
