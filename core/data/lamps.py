"""Lamps: what lights a scene beside its world. Data alone; lamp_shapes.py and lamp_light.py use it.

A lamp is a shape with one radiance all over, which a spot's cone or a spread dims by direction. A
shape without size has an intensity in its place, or an irradiance where it is a parallel beam; of a
MESH each face has a radiance of its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Lamps.kind
SUN, SPHERE, DISC, RECTANGLE, ELLIPSE, MESH, BEAM, ROUND_BEAM = range(8)
# Lamps.seen_by
BY_DIFFUSE, BY_GLOSSY, BY_CAMERA, NOT_BY_BSDF = 1, 2, 4, 8
EVERYWHERE = np.float32(-2.0)  # Lamps.cone of what is no spot
# Cosine of half the angle of the widest spot that has its picture on a plane (lamp_pictures.py).
PLANE_EDGE = 0.2
# Rows of a table by distance for each doubling of it; the powers of two, metres, of the first one
# and of the last one, which are taken beyond.
FALLOFF_STEPS = 64
NEAREST, FARTHEST = -14, 30
FALLOFF_ROWS = (FARTHEST - NEAREST) * FALLOFF_STEPS + 1
BLOCK = 4  # faces of a MESH that have a box around them


class LampFaces(NamedTuple):
    """Triangles of lamps of kind MESH: whole blocks of BLOCK rows each, filled up by empty ones.

    corners: float32 (m, 3, 3), world space; power: float64 (m, 2), area x strength of a face's
        front, from where its corners turn left, and its back, 0 = never drawn
    radiance: float32 (2 m, 3), of each face's front and back
    nodes: float32 (k, 16), of the lamps' trees (emitter_tree.py): lowest and highest corner, power
        (mean of both sides), and how it is turned: the mean of n n^T (xx, yy, zz, xy, xz, yz) and
        of half of n (front - back) over power; leaves: int32 (k,), blocks in each
    face: int32 (m,), the triangle of TriangleMesh that each is, or is a part of
    """

    corners: np.ndarray
    power: np.ndarray
    radiance: np.ndarray
    nodes: np.ndarray
    leaves: np.ndarray
    face: np.ndarray


NO_FACES = LampFaces(
    np.zeros((0, 3, 3), np.float32),
    np.zeros((0, 2)),
    np.zeros((0, 3), np.float32),
    np.zeros((0, 16), np.float32),
    np.zeros(0, np.int32),
    np.zeros(0, np.int32),
)


class LampLink(NamedTuple):
    """Which objects some lamps are about, bool (n_objects,) each; None: all.

    receivers: those that they light; blockers: those that throw shadows of them
    """

    receivers: np.ndarray | None
    blockers: np.ndarray | None

    def same(self, other: LampLink) -> bool:
        """Whether two are equal."""
        return all(
            a is b or (a is not None and b is not None and np.array_equal(a, b))
            for a, b in zip(self, other, strict=True)
        )


class Lamps(NamedTuple):
    """n lamps, in world space, metres.

    kind: int8 (n,); SUN: a disc at infinity; SPHERE: of point and spot lamps; DISC: the same with
        soft falloff, a disc that faces whoever looks at it; RECTANGLE, ELLIPSE: one-sided areas;
        MESH: faces that shine on both sides; BEAM, ROUND_BEAM: areas that shine along their axis
    seen_by: int8 (n,), BY_DIFFUSE | BY_GLOSSY: which lobes it lights; BY_CAMERA: it is seen itself;
        NOT_BY_BSDF: samples of the BSDF do not find it, its own are all there is
    shadow: bool (n,), whether it casts shadows
    position: float32 (n, 3), of the centre
    forward, right, up: float32 (n, 3), unit: where it shines, and the sides of an area
    axis: float32 (n, 3), unit: of an area that of its spread, from whose side it is seen; forward
        but where an uneven scale makes its plane slant
    size: float32 (n, 2): half the angle of a SUN, 0; radius of SPHERE and DISC, 0; width and
        height; width of the ball around a MESH, 0
    radiance: float32 (n, 3); where there is no size W/sr, of a SUN without one and of beams W/m2,
        of a MESH not looked at
    to_cone: float32 (n, 3, 3), world directions into the frame in which a spot's cone is round,
        its axis -z; cone: float32 (n, 2), cosine of half its angle (EVERYWHERE: no spot) and the
        inverse of the range of cosines over which its edge is soft
    spread: float32 (n, 2): an area's radiance at an angle a from its axis is multiplied by
        max(0, spread[0] - tan a) spread[1]; spread[0] = infinity: by 1
    link: int32 (n,), row of Scene.lamp_links, -1 = it is about all objects
    group: int32 (n,), of AskedPasses.groups, -1 = none
    span: int32 (n, 3), first row of a MESH in faces, the row after its last, the root of its tree
    picture: int32 (n, 4), first row in texels, width, height (0, 0: none), whether it tells by
        direction; see lamp_pictures.py
    falloff: int32 (n,), row of falloffs, -1 = the radiance is the same however far light goes
    layers: int32 (n,), how many faces of a MESH a ray may meet, one behind the other; 1 of others
    faces: of all, with the radiance of each
    texels: float32 (m, 3), of all pictures, row by row from the bottom; their mean luminance is 1
    falloffs: float32 (k, FALLOFF_ROWS, 3), factors of radiance by distance, of falloff_knots
    """

    kind: np.ndarray
    seen_by: np.ndarray
    shadow: np.ndarray
    position: np.ndarray
    forward: np.ndarray
    right: np.ndarray
    up: np.ndarray
    axis: np.ndarray
    size: np.ndarray
    radiance: np.ndarray
    to_cone: np.ndarray
    cone: np.ndarray
    spread: np.ndarray
    link: np.ndarray
    group: np.ndarray
    span: np.ndarray
    picture: np.ndarray
    falloff: np.ndarray
    layers: np.ndarray
    faces: LampFaces
    texels: np.ndarray
    falloffs: np.ndarray

    def at(self, which) -> Lamps:
        """Those of a slice, of indices or of a mask."""
        columns = (np.ascontiguousarray(column[which]) for column in self[:-3])
        return Lamps(*columns, self.faces, self.texels, self.falloffs)


_SHAPES = {
    "position": (3,),
    "forward": (3,),
    "right": (3,),
    "up": (3,),
    "axis": (3,),
    "size": (2,),
    "radiance": (3,),
    "to_cone": (3, 3),
    "cone": (2,),
    "spread": (2,),
}


class _Falloffs:
    """Tables, each once."""

    def __init__(self):
        self._rows: dict[bytes, int] = {}
        self._tables: list[np.ndarray] = []

    def row_of(self, table) -> int:
        row = self._rows.setdefault(table.tobytes(), len(self._tables))
        if row == len(self._tables):
            self._tables.append(np.ascontiguousarray(table, np.float32))
        return row

    def tables(self) -> np.ndarray:
        return np.stack(self._tables) if self._tables else np.zeros((0, 1, 3), np.float32)


def make_lamps(rows: list[dict], faces: LampFaces = NO_FACES) -> Lamps:
    """The table of some lamps: a dict of Lamps' fields each; what is left out is no spot, spread
    over its whole side, seen by all, with a shadow. "falloff" is a table, of which equal ones
    become one. Raises ValueError at a value that is not finite or at a negative radiance."""
    n = len(rows)
    columns = {name: np.zeros((n, *shape), np.float32) for name, shape in _SHAPES.items()}
    columns |= {"kind": np.zeros(n, np.int8), "shadow": np.ones(n, np.bool_)}
    columns |= {name: np.full(n, -1, np.int32) for name in ("link", "group", "falloff")}
    columns |= {"span": np.zeros((n, 3), np.int32), "picture": np.zeros((n, 4), np.int32)}
    columns |= {"faces": faces, "texels": np.zeros((0, 3), np.float32)}
    columns["layers"] = np.ones(n, np.int32)
    columns["seen_by"] = np.full(n, BY_DIFFUSE | BY_GLOSSY, np.int8)
    columns["cone"][:, 0], columns["spread"][:, 0] = EVERYWHERE, np.inf
    columns["forward"][:, 2], columns["right"][:, 0], columns["up"][:, 1] = -1.0, 1.0, 1.0
    falloffs = _Falloffs()
    for k, row in enumerate(rows):
        for name, value in row.items():
            columns[name][k] = falloffs.row_of(value) if name == "falloff" else value
        columns["axis"][k] = row.get("axis", columns["forward"][k])
    columns["falloffs"] = falloffs.tables()
    lamps = Lamps(**columns)
    finite = all(np.isfinite(columns[name]).all() for name in ("position", "size", "radiance"))
    if not finite or (lamps.radiance < 0.0).any():
        raise ValueError("lamps must be finite, and their radiance not negative")
    return lamps


def is_soft(lamps: Lamps) -> np.ndarray:
    """bool (n,): which have a size as they are seen from a point, so that one sample is not all."""
    beam = (lamps.kind == BEAM) | (lamps.kind == ROUND_BEAM)
    return (lamps.size[:, 0] > 0.0) & ~beam


def falloff_knots() -> np.ndarray:
    """float32 (FALLOFF_ROWS,), metres: the distance of each row of Lamps.falloffs."""
    row = np.arange(FALLOFF_ROWS)
    power = NEAREST + row // FALLOFF_STEPS
    return np.ldexp(1.0 + (row % FALLOFF_STEPS) / FALLOFF_STEPS, power).astype(np.float32)


NO_LAMPS = make_lamps([])
