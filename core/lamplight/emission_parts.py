"""The faces that shine and what each sends out, cut where a material's emission varies over them.

A program is evaluated at points of the faces, seen straight on from in front and from behind, as by
a ray that is neither the camera's nor a shadow's. Large faces are cut into quarters, and parts over
which the light differs most again, until no part matters or there are enough of them: a part then
has the mean of its points.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.program import Program, Ref
from ..data.program_ops import depends_on_around
from ..nodes import Evaluation, ShadeContext
from ..nodes.falloff import Falloff, asks_for_distance, falloff_of
from ..nodes.world_map import reached_ops
from ..scene import BLACK, Scene, TriangleMesh
from .emitter_tree import areas_of, powers_of_faces

_COARSEST = 1 / 2048  # of the area of a material: no larger part
_MOST = 1 << 16  # parts, unless there are more faces
_SURE = 2e-5  # of all light: what a part's points may differ by, times its area
_SAME = 1e-4  # of a part's light: what its points may differ by if it is one light
_POINTS, _FEW_POINTS, _ENOUGH = 8, 3, 1 << 19  # of a part; of one of very many; of all parts
_FIRST, _MANY_POINTS = 1 << 15, 4096  # of all parts that may be cut; of one
_KNOWN = 1 << 18  # of all parts that are no larger than the coarsest
# Of a quarter of those: what is missed by all of its points would be black from then on, while what
# was hit by chance is looked at again. With 8 city windows on facades lost half of their light.
_POINTS_OF_QUARTERS = 32
_CHUNK = 1 << 16  # points evaluated together
_FALLOFF_PLACES = 512  # whose light is looked at from several distances
_STEPS = np.array([[0.7548776662466927], [0.5698402909980532]])  # of a plane lattice


class Parts(NamedTuple):
    """n parts of faces. face: int (n,), row of the mesh; corners: float32 (n, 3, 3), world space;
    radiance: float32 (n, 2, 3), of front and back; falloff: int (n,), row of the falloffs, -1: the
    radiance is the same however far light goes"""

    face: np.ndarray
    corners: np.ndarray
    radiance: np.ndarray
    falloff: np.ndarray


class Told(NamedTuple):
    """Materials whose emission is more than a lamp can have.

    turned: it depends on where it is seen from: the light straight on is taken for all directions
    uneven: it falls off otherwise in one place than in another: as in its brightest ones
    near: it depends on what is near: it lights as where nothing is
    """

    turned: list[int]
    uneven: list[int]
    near: list[int]


def parts_that_shine(
    mesh: TriangleMesh, emission, scene: Scene | None, told: Told, falloffs: list[np.ndarray]
) -> Parts:
    """All faces, or their parts, that give light.

    emission: float32 (k, 3), radiance of each material; scene: with shaders, whose programs say
    what the emission is where it varies; told: gets materials; falloffs: gets Lamps.falloffs
    """
    found, lights_something = [], scene is not None and _reflects(scene)
    for k in range(len(emission)):
        program = None if scene is None or scene.shaders is None else scene.shaders.programs[k]
        varies = program is not None and isinstance(program.emission, Ref)
        if not (lights_something if varies else (emission[k] > 0.0).any()):
            continue
        face = np.flatnonzero(mesh.material_index == k)
        face = face[areas_of(mesh.vertices[mesh.triangles[face]]) > 0.0]
        if not len(face):
            continue
        if varies:
            light, row = _Light(scene, program), -1
            if asks_for_distance(reached_ops(program, program.emission).values()):
                falloff, row = light.falloff(face), len(falloffs)
                light.distance = falloff.distance
                falloffs.append(falloff.table)
                if not falloff.whole:
                    told.uneven.append(k)
            parts = _varying(mesh, face, light)
            found.append(Parts(*parts, np.full(len(parts[0]), row)))
            if depends_on_around(program, program.emission):
                told.near.append(k)
            if light.depends_on_view(face):
                told.turned.append(k)
        else:
            radiance = np.broadcast_to(np.maximum(emission[k], 0.0), (len(face), 2, 3))
            corners = mesh.vertices[mesh.triangles[face]]
            found.append(Parts(face, corners, radiance, np.full(len(face), -1)))
    if not found:
        none = np.zeros(0, int)
        return Parts(none, np.zeros((0, 3, 3), np.float32), np.zeros((0, 2, 3)), none)
    whole = Parts(*map(np.concatenate, zip(*found, strict=True)))
    lit = powers_of_faces(whole.corners, whole.radiance).any(axis=1)
    return Parts(*(column[lit] for column in whole))


def _reflects(scene: Scene) -> bool:
    """Whether there is anything to be lit."""
    programs = () if scene.shaders is None else scene.shaders.programs
    closures = (c for program in programs if program is not None for c in program.closures)
    return bool((scene.materials.model != BLACK).any()) or any(c.model != BLACK for c in closures)


class _FromOutside(ShadeContext):
    """What asks is no ray of the camera, and none of a shadow."""

    camera_ray = False


class _Light:
    """What a material sends out at places on its faces.

    distance: metres that it goes
    """

    def __init__(self, scene: Scene, program: Program):
        self._scene, self._program, self._same_behind = scene, program, None
        self.distance = 1.0

    def __call__(self, face, places) -> np.ndarray:
        """float32 (n, 2, 3), of front and back. face: int (n,); places: float32 (n, 2)"""
        if self._same_behind is None:
            some = slice(None, None, max(len(face) // 4096, 1))
            front, back = (self._side(face[some], places[some], s) for s in (1.0, -1.0))
            self._same_behind = np.array_equal(front, back)
        front = self._side(face, places, 1.0)
        back = front if self._same_behind else self._side(face, places, -1.0)
        return np.stack([front, back], axis=1)

    def depends_on_view(self, face) -> bool:
        """Whether it looks otherwise aslant."""
        face = face[:: max(len(face) // 256, 1)]
        places = np.full((len(face), 2), 1.0 / 3.0, np.float32)
        straight, aslant = (self._side(face, places, 1.0, slope) for slope in (0.0, 1.5))
        return not np.allclose(straight, aslant, rtol=1e-3, atol=1e-6 * np.abs(straight).max())

    def falloff(self, face) -> Falloff:
        """How it changes with the distance."""
        face = face[:: max(len(face) // _FALLOFF_PLACES, 1)]
        count = max(_FALLOFF_PLACES // len(face), 1)
        rows, places = np.repeat(face, count), np.tile(_lattice(count), (len(face), 1))
        n = len(rows)

        def seen(place, distance):
            found = np.empty((len(place), 3), np.float32)
            for sign, which in ((1.0, place < n), (-1.0, place >= n)):
                k = place[which] % n
                if len(k):
                    found[which] = self._side(rows[k], places[k], sign, 0.0, distance[which])
            return found

        return falloff_of(seen, 2 * n)

    def _side(self, face, places, sign, slope=0.0, distance=None):
        chunks = [slice(k, k + _CHUNK) for k in range(0, len(face), _CHUNK)]
        far = np.full(len(face), self.distance) if distance is None else distance
        parts = [self._chunk(face[c], places[c], sign, slope, far[c]) for c in chunks]
        return np.concatenate(parts)

    def _chunk(self, face, places, sign, slope, distance):
        mesh, scene = self._scene.mesh, self._scene
        corners = mesh.vertices[mesh.triangles[face]]
        weights = np.column_stack([1.0 - places.sum(axis=1), places])
        side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        flat = sign * _unit(np.cross(side.astype(np.float64), other))
        smooth = sign * _unit(np.einsum("nc,nck->nk", weights, mesh.corner_normals[face]))
        smooth = np.where(smooth.any(axis=1, keepdims=True), smooth, flat)
        context = _FromOutside(
            mesh,
            scene.shaders.surface,
            scene.camera,
            scene.shaders.material_pass_index,
            face,
            places,
            np.einsum("nc,nck->nk", weights, corners).astype(np.float32),
            _unit(flat + slope * _unit(side)).astype(np.float32),
            smooth.astype(np.float32),
            flat.astype(np.float32),
            distance=distance.astype(np.float32),
        )
        return np.maximum(Evaluation(self._program, context).vector(self._program.emission), 0.0)


def _unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-30)


def _lattice(count: int) -> np.ndarray:
    """float32 (count, 2): even places on a triangle, as weights of its second and third corner."""
    a, b = (np.arange(count) * _STEPS + 0.5) % 1.0
    root = np.sqrt(a)
    return np.column_stack([root * (1.0 - b), root * b]).astype(np.float32)


def _varying(mesh: TriangleMesh, face, light: _Light):
    """The parts of one material's faces: the first three of Parts."""
    area = areas_of(mesh.vertices[mesh.triangles[face]])
    # Places of a part's corners: weights of the second and third corner of its face.
    whole = np.float32([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    work = face, np.broadcast_to(whole, (len(face), 3, 2)), area
    done, limit = [], _COARSEST * area.sum()
    above = np.zeros(len(face))
    while len(work[0]):
        large = work[2] > limit
        mean, spread = _looked_over(*work[:2], large, light)
        whole = mean.sum((1, 2))
        # What is large and all the same stays whole: even points lie best on one face. But not what
        # is darker than all around it: small lights there may have been missed.
        cut = large & ((spread > _SAME * whole) | (whole < (1.0 - _SAME) * above))
        done.append([column[~cut] for column in (*work, mean, spread)])
        above = np.tile(np.maximum(whole, above)[cut], 4)
        work = _quartered(*(column[cut] for column in work))
    return _refined(mesh, *map(np.concatenate, zip(*done, strict=True)), light)


def _looked_over(face, places, large, light: _Light):
    """_looked_at of parts; of those not ``large`` by more points: what they miss is lost."""
    points = int(np.clip(_FIRST // len(face), _FEW_POINTS, _MANY_POINTS))
    points = max(points, _POINTS if len(face) * _POINTS <= _ENOUGH else 0)
    many = max(min(_KNOWN // max(np.count_nonzero(~large), 1), _MANY_POINTS), points)
    mean, spread = np.empty((len(face), 2, 3)), np.empty(len(face))
    for which, count in ((large, points), (~large, many)):
        if which.any():
            mean[which], spread[which] = _looked_at(face[which], places[which], light, count)
    return mean, spread


def _refined(mesh, face, places, area, mean, spread, light):
    """The same parts, those over which the light differs most cut up."""
    total = float((area * mean.sum((1, 2))).sum())
    while len(face) < _MOST and total > 0.0:
        doubt = area * spread
        room = (_MOST - len(face)) // 3
        worst = np.argsort(-doubt, kind="stable")[: min(room, len(face))]
        worst = worst[doubt[worst] > _SURE * total]
        if not len(worst):
            break
        parts = _quartered(face[worst], places[worst], area[worst])
        seen = _looked_at(parts[0], parts[1], light, _POINTS_OF_QUARTERS)
        kept = np.ones(len(face), bool)
        kept[worst] = False
        old = face[kept], places[kept], area[kept], mean[kept], spread[kept]
        joined = map(np.concatenate, zip(old, (*parts, *seen), strict=True))
        face, places, area, mean, spread = joined
    return face, _corners_of(mesh, face, places), mean


def _corners_of(mesh, face, places):
    corners = mesh.vertices[mesh.triangles[face]].astype(np.float64)
    weights = np.concatenate([1.0 - places.sum(2, keepdims=True), places], axis=2)
    return np.einsum("npc,nck->npk", weights, corners).astype(np.float32)


def _quartered(face, places, area):
    a, b, c = places[:, 0], places[:, 1], places[:, 2]
    ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (bc, ca, ab)]
    quarters = np.concatenate([np.stack(part, axis=1) for part in parts])
    return np.tile(face, 4), quarters.astype(np.float32), np.tile(0.25 * area, 4)


def _looked_at(face, places, light: _Light, points: int):
    """(mean radiance (n, 2, 3), spread (n,) of the sum over sides and channels) of parts."""
    n, random = len(face), np.random.default_rng(len(face))
    shift = random.random((2, n, 1))
    # Points of a plane lattice, shifted in each part, folded into the triangle.
    steps = np.arange(points) * _STEPS
    a, b = (shift + steps[:, None, :]) % 1.0
    root = np.sqrt(a)
    u, v = (root * (1.0 - b))[..., None], (root * b)[..., None]
    first, side, other = places[:, :1], places[:, 1:2], places[:, 2:3]
    at = (first + u * (side - first) + v * (other - first)).astype(np.float32)
    radiance = light(np.repeat(face, points), at.reshape(-1, 2)).reshape(n, points, 2, 3)
    return radiance.mean(axis=1), np.ptp(radiance.sum(axis=(2, 3)), axis=1)
