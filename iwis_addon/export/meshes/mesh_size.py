"""Whether a scene's triangles fit: into 32-bit numbers, and into memory. Needs no Blender.

Instances that are no copies (copied.py) are written out in world space (docs/measured.md has the
bytes). So a scatter of a million trees that shine must be refused with a message while there is
still memory to say it.
"""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ExportError
from ..free_memory import free_memory_bytes

if TYPE_CHECKING:
    from ..placed.instances import Inventory

# The corners of all triangles, three each, are counted in int32.
MOST_TRIANGLES = (1 << 31) // 3
# Of TriangleMesh: corners, normals and two rows of a triangle, a vertex. Of the hierarchy: Embree
# takes 94 (scattered boxes) to 100 bytes a triangle (one mesh) while it builds; 62 to 68 stay.
_TRIANGLE_BYTES, _VERTEX_BYTES, _BVH_BYTES = 56, 12, 110
# Of the spheres and tubes that stand for points and strands, in their object's own space, while
# they are made; they have half as many vertices as triangles.
_MADE_BYTES = 80
_GIGABYTE = 1e9


def needed_bytes(n_triangles: int, n_vertices: int) -> int:
    """The most memory that a mesh table and the building of its hierarchy take."""
    return (_TRIANGLE_BYTES + _BVH_BYTES) * n_triangles + _VERTEX_BYTES * n_vertices


def check_made(name: str, what: str, n_triangles: int) -> None:
    """Raises ExportError where points or strands would be too many triangles.

    name: of the object; what: its elements, such as "1000 strands"
    """
    needed = needed_bytes(n_triangles, n_triangles // 2) + _MADE_BYTES * n_triangles
    free = free_memory_bytes()
    if n_triangles <= MOST_TRIANGLES and (free is None or needed <= free):
        return
    limit = f"the most is {MOST_TRIANGLES:,}"
    if n_triangles <= MOST_TRIANGLES:
        limit = f"they need {needed / _GIGABYTE:.1f} GB, of which {free / _GIGABYTE:.1f} are free"
    raise ExportError(
        f"Object {name}: its {what} are {n_triangles:,} triangles; {limit}. Reduce their number or "
        "the points of each, or hide it from renders"
    )


def check_size(inventory: Inventory, written: np.ndarray | None = None) -> None:
    """Raises ExportError where there are too many triangles, naming the object that has most.

    written: bool, one an instance: which are in the mesh table; None: all
    """
    parts, instances = inventory.parts, inventory.instances
    if written is not None:
        instances = [instances[row] for row in np.flatnonzero(written)]
    triangles = np.array([len(part.triangles) for part in parts], np.int64)
    vertices = np.array([len(part.positions) for part in parts], np.int64)
    users = np.bincount([i.part for i in instances], minlength=len(parts))
    total = int(users @ np.maximum(triangles, vertices))
    needed = needed_bytes(int(users @ triangles), int(users @ vertices))
    free = free_memory_bytes()
    if total <= MOST_TRIANGLES and (free is None or needed <= free):
        return
    shares: dict[str, int] = defaultdict(int)
    for instance in instances:
        shares[instance.name] += int(max(triangles[instance.part], vertices[instance.part]))
    name = max(shares, key=shares.get)
    limit = f"the most is {MOST_TRIANGLES:,}"
    if total <= MOST_TRIANGLES:
        limit = f"they need {needed / _GIGABYTE:.1f} GB, of which {free / _GIGABYTE:.1f} are free"
    raise ExportError(
        f"The scene has {total:,} triangles with all its instances; {limit}. Object {name} has "
        f"{shares[name]:,} of them: reduce its copies or its subdivision, or hide it from renders"
    )
