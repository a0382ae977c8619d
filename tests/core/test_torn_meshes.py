"""displacement.py: meshes whose corners have normals, before Blender 5.2 and since."""

import numpy as np

from iwis.core.data.program import Displacement, Op, Program, Ref, SurfaceData
from iwis.core.fine_meshes.displacement import Asked, Movable, displaced, torn
from iwis.core.scene import TriangleMesh
from support.scenes import camera_above

# Two triangles that share the edge from vertex 1 to 2, sharp: normals aside, and up.
LEFT, UP = (-0.6, 0.0, 0.8), (0.0, 0.0, 1.0)


def _pair(second=UP) -> TriangleMesh:
    return TriangleMesh(
        vertices=np.float32([[-1, 0, 0], [0, -1, 0], [0, 1, 0], [1, 0, 0]]),
        triangles=np.int32([[0, 1, 2], [1, 3, 2]]),
        corner_normals=np.repeat(np.float32([LEFT, second])[:, None], 3, axis=1),
        material_index=np.int32([0, 1]),
        object_index=np.zeros(2, np.int32),
    )


def _kinds() -> Movable:
    """Both have normals of corners, and vertices a mean one."""
    yes, no = np.ones(2, bool), np.zeros(2, bool)
    return Movable(yes, no, yes, np.tile(np.float32([UP]), (4, 1)))


def _moved(mesh, kinds, materials):
    """Vertices a metre along their normals, by materials that displace."""
    height = {"Height": np.float32(1.0), "Midlevel": np.float32(0.0), "Scale": np.float32(1.0)}
    program = Program(ops=(Op("ShaderNodeDisplacement", height, {"space": "OBJECT"}),), closures=())
    own = Displacement(program, Ref(0, "Displacement"), False)
    surface = SurfaceData(
        row=np.full(2, -1, np.int32),
        object_to_world=np.eye(4)[None],
        mirrored=np.zeros(1, bool),
        color=np.ones((1, 4), np.float32),
        random=np.zeros(1, np.float32),
        pass_index=np.zeros(1, np.float32),
    )
    asked = Asked(surface, camera_above(), np.zeros(2, np.float32))
    found = displaced(mesh, tuple(own if m else None for m in materials), kinds, asked)
    return found.mesh.vertices[found.mesh.triangles] - mesh.vertices[mesh.triangles]


def test_a_shared_vertex_goes_along_the_normal_of_its_first_corner():
    """Of Blender 5.2: where corners have normals the vertex's own mean does not count."""
    moves = _moved(_pair(), _kinds(), (True, True))
    np.testing.assert_allclose(moves[0], np.tile(LEFT, (3, 1)), atol=1e-6)
    np.testing.assert_allclose(moves[1], [LEFT, UP, LEFT], atol=1e-6)


def test_torn_sides_go_their_own_ways():
    """Before 5.2: each along its normals."""
    moves = _moved(*torn(_pair(), _kinds()), (True, True))
    np.testing.assert_allclose(moves, np.repeat(np.float32([LEFT, UP])[:, None], 3, 1), atol=1e-6)


def test_a_torn_side_whose_material_moves_nothing_stays():
    """Though the vertices at the edge belong to both before they are cut."""
    moves = _moved(*torn(_pair(), _kinds()), (True, False))
    np.testing.assert_allclose(moves[0], np.tile(LEFT, (3, 1)), atol=1e-6)
    assert not moves[1].any()


def test_tearing_makes_vertices_at_sharp_edges_alone():
    """At the same places; where normals are the same the mesh is as it was."""
    mesh, whole = _pair(), _pair(LEFT)
    cut, kinds = torn(mesh, _kinds())
    assert len(cut.vertices) == len(kinds.vertex_normals) == 6 and not kinds.cornered.any()
    np.testing.assert_array_equal(cut.vertices[cut.triangles], mesh.vertices[mesh.triangles])
    same, _ = torn(whole, _kinds())
    np.testing.assert_array_equal(same.triangles, whole.triangles)
    assert len(same.vertices) == 4


def test_what_has_no_normals_of_corners_is_not_torn():
    kinds = _kinds()._replace(cornered=np.zeros(2, bool))
    mesh = _pair()
    assert torn(mesh, kinds) == (mesh, kinds)
