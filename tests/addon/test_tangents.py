"""Tangents at the corners of triangles (iwis_addon/export/meshes/tangents.py)."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export.meshes.tangents import uv_tangents


def _corners(mesh):
    found = np.empty((len(mesh.loop_triangles), 3), np.int32)
    mesh.loop_triangles.foreach_get("loops", found.ravel())
    return found


@pytest.fixture
def ball(scene):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24)
    bpy.context.object.data.shade_smooth()
    return bpy.context.object.data


def test_without_uv_maps_they_go_round_z(ball):
    """West to east, along the circles of latitude, away from the poles and the seam of 4.5."""
    ball.uv_layers.remove(ball.uv_layers[0])
    corners = _corners(ball)
    found = uv_tangents(ball, "", corners)
    vertices = np.array([loop.vertex_index for loop in ball.loops])[corners]
    places = np.array([vertex.co for vertex in ball.vertices])[vertices]
    x, y, z = np.moveaxis(places, -1, 0)
    inner = (np.abs(z) < 0.7) & ~((np.abs(x) < 0.2) & (y < 0.0))
    east = np.stack([-y, x, 0.0 * x], -1) / np.hypot(x, y)[..., None].clip(1e-6)
    # 48 sides: .13 rad between two faces' own tangents; their mean is that of the circle.
    np.testing.assert_allclose(found[..., :3][inner], east[inner], atol=0.02)
    assert (found[..., 3][inner] == found[..., 3][inner][0]).all()


def test_of_a_uv_map_that_is_not_there_they_are_none(ball):
    corners = _corners(ball)
    assert uv_tangents(ball, "Other", corners) is None
    assert uv_tangents(ball, "", corners).shape == (len(corners), 3, 4)
    ball.uv_layers.remove(ball.uv_layers[0])
    assert uv_tangents(ball, "Other", corners) is None


def test_of_flat_faces_they_are_each_triangles_own(ball):
    """At right angles to it."""
    ball.uv_layers.remove(ball.uv_layers[0])
    ball.shade_flat()
    corners = _corners(ball)
    found = uv_tangents(ball, "", corners)[..., :3]
    normals = np.array([triangle.normal for triangle in ball.loop_triangles])
    # float32
    np.testing.assert_allclose((found * normals[:, None]).sum(-1), 0.0, atol=1e-4)
