"""Strands as a part of a scene: tubes, and what materials ask of them. Needs no Blender.

What the strands come from gives their own values (hair_curves.py, particle_hair.py).
"""

from __future__ import annotations

import functools
import hashlib
from typing import NamedTuple

import numpy as np

from .element_values import random_of_rows
from .local_mesh import LocalMesh
from .mesh_size import check_made
from .strand_tubes import (
    Rings,
    Shape,
    Strands,
    along,
    choose_shape,
    count_triangles,
    find_rings,
    make_tubes,
)

_ROUND_PIECES = 16  # where Cycles' curves are round ones, without pieces


class StrandSettings(NamedTuple):
    """Of the scene, as Cycles has it. most_pieces: between two keys; straight: no spline"""

    most_pieces: int
    straight: bool


def strand_settings(scene) -> StrandSettings:
    """Cycles' curve settings; its own defaults where its add-on is not enabled."""
    settings = getattr(scene, "cycles_curves", None)
    if settings is None:
        return StrandSettings(4, False)
    if settings.shape == "RIBBONS":
        return StrandSettings(2 ** min(settings.subdivisions, 8), False)
    return StrandSettings(_ROUND_PIECES, settings.shape == "THICK_LINEAR")


class StrandSource:
    """What materials ask of strands, one row a ring of a tube.

    strands, shape: what the tubes were made of
    own(name): (values, whether one a key, else one a strand) of what only their maker knows, or
        None
    """

    def __init__(self, strands: Strands, shape: Shape, own):
        self.strands, self.shape, self._own = strands, shape, own

    @functools.cached_property
    def _rings(self) -> Rings:
        return find_rings(self.strands, self.shape)

    def rows(self, name: str) -> np.ndarray | None:
        """float32 (r, width) of a name of element_values.py; None where there is none."""
        kind, _, rest = name.partition(":")
        if name == "element:Tangent":
            return along(self.strands, self._rings, self.shape.straight)[1]
        found = self._element(rest) if kind == "element" else self._own(name)
        if found is None:
            return None
        values, of_keys = found
        if not of_keys:
            return values[self._rings.strand]
        last = self.strands.first[self._rings.strand + 1] - 1
        key = self._rings.key
        start, end = values[key], values[np.minimum(key + 1, last)]
        return start + (end - start) * self._rings.part[:, None]

    def _element(self, name):
        keys, first = self.strands
        if name == "Is Strand":
            return np.ones((len(first) - 1, 1), np.float32), False
        if name == "Thickness":
            return 2.0 * keys[:, 3:], True
        if name == "Random":
            return random_of_rows(len(first) - 1), False
        if name in ("Intercept", "Length"):
            places, lengths = self._lengths()
            return (places, True) if name == "Intercept" else (lengths, False)
        return None

    def _strand_of_key(self):
        return np.repeat(np.arange(len(self.strands.first) - 1), np.diff(self.strands.first))

    def _lengths(self):
        """How far each key is along its strand, 0 ... 1, and each strand's length."""
        keys, first = self.strands
        strand, begins = self._strand_of_key(), first[:-1]
        steps = np.zeros(len(keys))
        steps[1:] = np.linalg.norm(np.diff(keys[:, :3], axis=0), axis=1)
        steps[begins[begins < len(keys)]] = 0.0
        total = np.bincount(strand, steps, len(begins))
        places = np.cumsum(steps)
        places -= places[np.minimum(begins, len(keys) - 1)][strand]
        size = total[strand]
        places = np.divide(places, size, out=np.zeros_like(places), where=size > 0.0)
        return places.astype(np.float32)[:, None], total.astype(np.float32)[:, None]


class StrandPart(NamedTuple):
    """Tubes (None: there is nothing to see), and what they were made of."""

    local: LocalMesh | None
    strands: Strands
    shape: Shape


def make_part(
    name: str,
    strands: Strands,
    settings: StrandSettings,
    slots: np.ndarray | None,
    known: dict[bytes, LocalMesh] | None,
) -> StrandPart:
    """Strands as a part of the scene.

    name: of the object; slots: int32, of each strand; None: all 0; known: as for read_mesh
    Raises ExportError where they do not fit into memory.
    """
    if not strands.segments or not (strands.keys[:, 3] > 0.0).any():
        return StrandPart(None, strands, Shape(0, 1, True))
    shape = choose_shape(strands, settings.most_pieces, settings.straight)
    what = f"{len(strands.first) - 1:,} strands"
    check_made(name, what, count_triangles(strands, shape))
    digest = b"" if known is None else _digest(strands, shape, slots)
    local = known.get(digest) if known else None
    return StrandPart(local or _tubes(strands, shape, slots, digest), strands, shape)


def _digest(strands: Strands, shape: Shape, slots) -> bytes:
    state = hashlib.sha256(repr(shape).encode())
    for array in (*strands, slots):
        state.update(b"-" if array is None else np.ascontiguousarray(array))
    return state.digest()


def _tubes(strands, shape, slots, digest) -> LocalMesh | None:
    rings = find_rings(strands, shape)
    made = make_tubes(strands, shape, rings)
    if not len(made.triangles):
        return None
    if slots is not None:
        slots = slots[rings.strand[made.ring[made.triangles[:, 0]]]].astype(np.int32)
    return LocalMesh(
        made.positions,
        made.triangles,
        made.normals,
        made.triangles,
        None,
        slots,
        made.ring[made.triangles],
        digest,
        round=True,
    )
