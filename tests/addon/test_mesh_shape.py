"""Pointiness and Random Per Island; beside Cycles they are in the parity suite."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export.meshes.mesh_shape import islands, pointiness


def _mesh(positions, faces):
    mesh = bpy.data.meshes.new("M")
    mesh.from_pydata(positions, [], faces)
    mesh.update()
    return mesh


def test_a_flat_sheet_is_neither_pointed_nor_hollow(scene):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=5, y_subdivisions=4)
    values = pointiness(bpy.context.object.data)
    np.testing.assert_allclose(values, 0.5, atol=1e-6)


def test_corners_of_a_cube(scene):
    """Three edges leave a corner, each 125.3 degrees away from its normal."""
    bpy.ops.mesh.primitive_cube_add()
    mean_edge = 1.0 / np.sqrt(3.0)  # the mean of three unit vectors at right angles
    expected = np.arccos(-mean_edge) / np.pi
    np.testing.assert_allclose(pointiness(bpy.context.object.data), expected, rtol=1e-5)


def test_split_vertices_count_as_one(scene):
    """A tent of two faces that share no vertex is as pointed as one whose faces do."""
    corners = [(-1, 0, 0), (-1, 1, 0), (0, 1, 1), (0, 0, 1), (1, 0, 0), (1, 1, 0)]
    whole = _mesh(corners, [(0, 3, 2, 1), (3, 4, 5, 2)])
    split = _mesh([*corners, (0, 1, 1), (0, 0, 1)], [(0, 3, 2, 1), (7, 4, 5, 6)])
    values = pointiness(split)[:, 0]
    np.testing.assert_allclose(values[:6], pointiness(whole)[:, 0], atol=1e-6)
    np.testing.assert_allclose(values[[6, 7]], values[[2, 3]])


def test_a_mesh_without_edges(scene):
    mesh = _mesh([(0, 0, 0), (1, 0, 0)], [])
    np.testing.assert_array_equal(pointiness(mesh), 0.0)
    assert len(np.unique(islands(mesh))) == 2


@pytest.mark.parametrize("count", (1, 3))
def test_each_island_has_its_number(scene, count):
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    positions = np.concatenate([square + np.array([2 * k, 0, 0]) for k in range(count)])
    faces = [tuple(range(4 * k, 4 * k + 4)) for k in range(count)]
    values = islands(_mesh(positions.tolist(), faces)).reshape(count, 4)
    assert (values == values[:, :1]).all()
    assert len(np.unique(values)) == count
    assert ((values >= 0.0) & (values <= 1.0)).all()
