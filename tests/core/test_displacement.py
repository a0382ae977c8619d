"""Vertices moved by materials (displacement.py), and bumps that look at what they were."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.program import AtRest, Displacement, Op, Program, Ref, SurfaceData
from iwis.core.fine_meshes.displacement import Asked, Copied, Movable, displaced
from iwis.core.nodes import Evaluation, ShadeContext, surface_evaluation
from iwis.core.scene import TriangleMesh
from support.scenes import camera_above

N = 9  # vertices along a side of the grid: 2 m, in the plane z = 0
UP = np.float32([0.0, 0.0, 1.0])


def _grid(material=lambda face: 0 * face) -> TriangleMesh:
    """material: of the rows of triangles"""
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, N), np.linspace(-1.0, 1.0, N))
    vertices = np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], -1).astype(np.float32)
    a = (np.arange(N - 1)[:, None] * N + np.arange(N - 1)).ravel()
    pairs = np.stack([[a, a + 1, a + N + 1], [a, a + N + 1, a + N]])
    triangles = pairs.transpose(2, 0, 1).reshape(-1, 3).astype(np.int32)
    m = len(triangles)
    return TriangleMesh(
        vertices=vertices,
        triangles=triangles,
        corner_normals=np.tile(UP, (m, 3, 1)),
        material_index=material(np.arange(m)).astype(np.int32),
        object_index=np.zeros(m, np.int32),
    )


def _kinds(mesh, flat=False, cornered=False, movable=True) -> Movable:
    flags = (np.full(len(mesh.triangles), kind) for kind in (movable, flat, cornered))
    return Movable(*flags, np.tile(UP, (N * N, 1)))


def _bowl(factor=0.25):
    """The program of a height factor x (x^2 + y^2) along the normal, and its value."""
    place = Op("ShaderNodeNewGeometry", {}, {"outputs": {"Position"}})
    at = Ref(0, "Position")
    square = Op("ShaderNodeVectorMath", {"Vector": at, "Vector_001": at}, _DOT)
    height = {
        "Height": Ref(1, "Value"),
        "Midlevel": np.float32(0.0),
        "Scale": np.float32(factor),
    }
    moves = Op("ShaderNodeDisplacement", height, {"space": "OBJECT"})
    return Program(ops=(place, square, moves), closures=()), Ref(2, "Displacement")


_DOT = {"operation": "DOT_PRODUCT"}


def _run(mesh, displacements, kinds, **options):
    asked = Asked(_surface(mesh), camera_above(), np.zeros(len(displacements), np.float32))
    found = displaced(mesh, tuple(displacements), kinds, asked, **options)
    return found and found.mesh


def _surface(mesh) -> SurfaceData:
    """Of one object, in the middle of the world."""
    return SurfaceData(
        row=np.full(len(mesh.triangles), -1, np.int32),
        object_to_world=np.eye(4)[None],
        mirrored=np.zeros(1, bool),
        color=np.ones((1, 4), np.float32),
        random=np.zeros(1, np.float32),
        pass_index=np.zeros(1, np.float32),
    )


def _bowl_of(mesh, **kinds):
    keeps = kinds.pop("keeps_normals", False)
    return _run(mesh, [Displacement(*_bowl(), keeps)], _kinds(mesh, **kinds))


def test_vertices_go_where_the_height_says():
    mesh = _grid()
    found = _bowl_of(mesh)
    x, y, z = found.vertices.T
    np.testing.assert_allclose(z, 0.25 * (x * x + y * y), atol=1e-6)
    np.testing.assert_array_equal(found.vertices[:, :2], mesh.vertices[:, :2])
    assert found.triangles is mesh.triangles and not mesh.vertices[:, 2].any()


def test_normals_follow():
    """Of the paraboloid, but for what a grid of .25 m shows of it."""
    mesh = _grid()
    found = _bowl_of(mesh)
    inside = (np.abs(mesh.vertices[mesh.triangles]) < 0.99).all(axis=(1, 2))
    x, y, _ = np.moveaxis(found.vertices[found.triangles], -1, 0)
    expected = np.stack([-0.5 * x, -0.5 * y, np.ones_like(x)], -1)
    expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
    np.testing.assert_allclose(found.corner_normals[inside], expected[inside], atol=0.01)


def test_faces_beside_moved_ones_share_their_normals():
    """A vertex between a face that moves and one that does not has the normal of the first."""
    mesh = _grid(lambda face: face // 2 % (N - 1) >= (N - 1) // 2)
    program, value = _bowl()
    moved = _run(mesh, [Displacement(program, value, False), None], _kinds(mesh))
    alone = mesh.material_index == 1
    middle = (np.abs(mesh.vertices[:, 0]) < 1e-6)[mesh.triangles]
    normals, ours = {}, alone[:, None] & middle
    for corner in np.argwhere(~alone[:, None] & middle):
        normals[mesh.triangles[tuple(corner)]] = moved.corner_normals[tuple(corner)]
    assert ours.any()
    for corner in np.argwhere(ours):
        vertex = mesh.triangles[tuple(corner)]
        np.testing.assert_array_equal(moved.corner_normals[tuple(corner)], normals[vertex])
    assert max(np.abs(n - UP).max() for n in normals.values()) > 0.05
    np.testing.assert_array_equal(moved.corner_normals[alone[:, None] & ~middle] - UP, 0.0)


def test_normals_stay_where_a_bump_turns_them():
    mesh = _grid()
    found = _bowl_of(mesh, keeps_normals=True)
    np.testing.assert_array_equal(found.corner_normals, mesh.corner_normals)
    assert found.vertices[:, 2].max() > 0.4


@pytest.mark.parametrize("keeps_normals", [False, True])
def test_flat_faces_have_their_geometric_normal(keeps_normals):
    found = _bowl_of(_grid(), flat=True, keeps_normals=keeps_normals)
    a, b, c = np.moveaxis(found.vertices[found.triangles], 1, 0)
    face = np.cross(b - a, c - a)
    face /= np.linalg.norm(face, axis=-1, keepdims=True)
    np.testing.assert_allclose(found.corner_normals, np.repeat(face[:, None], 3, axis=1), atol=1e-6)


@pytest.mark.parametrize("keeps_normals", [False, True])
def test_normals_of_corners_turn_as_those_of_vertices(keeps_normals):
    """As in Cycles of Blender 5.2: with Displacement and Bump, too."""
    mesh = _grid()
    tilted = np.float32([0.6, 0.0, 0.8])
    own = dataclasses.replace(mesh, corner_normals=np.tile(tilted, (len(mesh.triangles), 3, 1)))
    found = _bowl_of(own, cornered=True, keeps_normals=keeps_normals)
    smooth = dataclasses.replace(mesh, vertices=found.vertices)
    a, b, c = np.moveaxis(smooth.vertices[smooth.triangles].astype(np.float64), 1, 0)
    face = np.cross(b - a, c - a)
    face /= np.linalg.norm(face, axis=-1, keepdims=True)
    whole = np.zeros((N * N, 3))
    np.add.at(whole, mesh.triangles, face[:, None])
    whole /= np.linalg.norm(whole, axis=-1, keepdims=True)
    expected = tilted + whole[mesh.triangles] - UP
    expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
    np.testing.assert_allclose(found.corner_normals, expected, atol=1e-5)


def test_a_vertex_is_moved_by_its_first_triangle():
    """Of those whose material moves any: the first material moves nothing."""
    mesh = _grid(lambda face: np.where(face < 6, 0, 1 + face // 3 % 2))
    up, down = (Displacement(*_bowl(factor), False) for factor in (0.25, -0.5))
    found = _run(mesh, [None, up, down], _kinds(mesh))
    first = np.full(N * N, -1)
    for row in range(len(mesh.triangles))[::-1]:
        if mesh.material_index[row]:
            first[mesh.triangles[row]] = mesh.material_index[row]
    x, y, z = found.vertices.T
    factor = np.select([first == 1, first == 2], [0.25, -0.5], 0.0)
    assert len(set(first)) == 3
    np.testing.assert_allclose(z, factor * (x * x + y * y), atol=1e-6)


def test_copies_have_the_shape_of_the_first():
    """Another instance, of half the size and turned upside down, is the first one's shape so."""
    one, n = _grid(), N * N
    matrix = np.column_stack([np.diag([0.5, -0.5, -0.5]), [3.0, 1.0, 2.0]])
    places = one.vertices @ matrix[:, :3].T + matrix[:, 3]
    both = dataclasses.replace(
        one,
        vertices=np.concatenate([one.vertices, places]).astype(np.float32),
        triangles=np.concatenate([one.triangles, one.triangles + n]),
        corner_normals=np.concatenate([one.corner_normals, -one.corner_normals]),
        material_index=np.tile(one.material_index, 2),
        object_index=np.repeat(np.int32([0, 1]), len(one.triangles)),
    )
    normals = np.repeat([UP, -UP], n, axis=0)
    kinds = _kinds(both)._replace(vertex_normals=normals, copied=(Copied(0, n, n, matrix),))
    surface = _surface(both)
    twice = {
        name: np.repeat(getattr(surface, name), 2, axis=0)
        for name in ("object_to_world", "mirrored", "color", "random", "pass_index")
    }
    asked = Asked(dataclasses.replace(surface, **twice), camera_above(), np.zeros(1, np.float32))
    moved = displaced(both, (Displacement(*_bowl(), False),), kinds, asked).mesh
    expected = moved.vertices[:n] @ matrix[:, :3].T + matrix[:, 3]
    assert np.ptp(moved.vertices[:n, 2]) > 0.4
    np.testing.assert_allclose(moved.vertices[n:], expected, atol=1e-6)  # float32
    turned = moved.corner_normals[: len(one.triangles)] * [1.0, -1.0, -1.0]
    np.testing.assert_allclose(moved.corner_normals[len(one.triangles) :], turned, atol=1e-5)


def test_what_must_not_move_stays():
    """Strands and points, and what has no such material."""
    mesh = _grid()
    assert _bowl_of(mesh, movable=False) is None
    assert _run(mesh, [None], _kinds(mesh)) is None


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e30])
def test_what_is_no_place_moves_nothing(value):
    mesh = _grid()
    far = Displacement(Program(ops=(), closures=()), np.float32([0.0, 0.0, value]), False)
    found = _run(mesh, [far], _kinds(mesh))
    np.testing.assert_array_equal(found.vertices, mesh.vertices)
    assert np.isfinite(found.corner_normals).all()


def _stretched():
    """(mesh at rest, context of the middles of its triangles, which are twice as long along x)."""
    mesh = _grid()
    place = Op("ShaderNodeNewGeometry", {}, {"outputs": {"Position"}})
    factors = {"Vector": Ref(0, "Position"), "Vector_001": np.float32([1.0, 0.0, 0.0])}
    twice = Op("ShaderNodeVectorMath", factors, {"operation": "MULTIPLY"})
    program = Program(ops=(place, twice), closures=())
    moved = _run(mesh, [Displacement(program, Ref(1, "Vector"), True)], _kinds(mesh))
    np.testing.assert_allclose(np.ptp(moved.vertices, axis=0), [4.0, 2.0, 0.0])
    face = np.arange(len(mesh.triangles), dtype=np.int32)
    corners, up = moved.vertices[moved.triangles[face]], np.tile(UP, (len(face), 1))
    a, b, c = np.moveaxis(corners, 1, 0)
    across = np.cross(b - a, c - a)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    weights = np.full((len(face), 2), 1.0 / 3.0, np.float32)
    own = _surface(mesh), camera_above(), np.zeros(1, np.float32), face, weights
    context = ShadeContext(moved, *own, corners.mean(axis=1), up, up, across)
    context.rest = AtRest(mesh, np.ones(1, bool), np.ones(len(mesh.triangles), bool))
    return mesh, context


def _bump_of(output, at_rest):
    """A program of a bump, .1 m high, by the first number of the Geometry node's output."""
    geometry = Op("ShaderNodeNewGeometry", {}, {"outputs": {output}})
    apart = Op("ShaderNodeSeparateXYZ", {"Vector": Ref(0, output)}, {})
    inputs = {"Height": Ref(1, "X"), "Strength": np.float32(1.0), "Distance": np.float32(0.1)}
    bump = Op("ShaderNodeBump", inputs, {"invert": False, "at_rest": at_rest})
    return Program(ops=(geometry, apart, bump), closures=(), displaced=Ref(2, "Normal"))


def test_bumps_look_where_the_surface_was():
    """The height falls from each triangle's first corner to its other ones, .25 m along x or y:
    the normal is as if nothing were stretched."""
    mesh, context = _stretched()
    corners = mesh.vertices[mesh.triangles[context.triangle]]
    to_middle = corners[:, 1:].mean(axis=1) - corners[:, 0]
    along = np.where(to_middle[:, :1] > to_middle[:, 1:2], [[1.0, 0.0]], [[0.0, 1.0]])
    expected = np.concatenate([0.4 * along, np.ones((len(along), 1))], -1)
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    found, other = (
        Evaluation(program, context).vector(program.displaced)
        for program in (_bump_of("Parametric", True), _bump_of("Parametric", False))
    )
    np.testing.assert_allclose(found, expected, atol=2e-3)
    assert np.abs(other - found).max() > 0.05


def test_all_else_sees_the_normal_that_a_displacement_leaves():
    _, context = _stretched()
    program = _bump_of("Parametric", True)
    ops = (*program.ops, Op("ShaderNodeNewGeometry", {}, {"outputs": {"Normal"}}))
    program = dataclasses.replace(program, ops=ops)
    evaluation = surface_evaluation(program, context)
    seen, turned = (evaluation.vector(value) for value in (Ref(3, "Normal"), program.displaced))
    np.testing.assert_array_equal(seen, turned)
    assert np.abs(turned - UP).max() > 0.3


def test_it_can_be_stopped():
    def check():
        raise InterruptedError

    mesh = _grid()
    with pytest.raises(InterruptedError):
        _run(mesh, [Displacement(*_bowl(), False)], _kinds(mesh), check=check)
