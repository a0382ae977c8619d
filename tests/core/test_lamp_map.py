"""Coordinates of what shines in all directions (core/nodes/lamp_map.py)."""

import numpy as np
import pytest

from iwis.core.nodes.lamp_map import LampPlaces


def _lamp(scales):
    turn, _ = np.linalg.qr(np.array([[1.0, 2.0, 0.5], [0.3, -1.0, 2.0], [1.0, 0.2, 0.4]]))
    matrix = np.eye(4)
    matrix[:3, :3] = turn * np.array(scales)
    return LampPlaces(matrix, radius=0.2)


@pytest.mark.parametrize("scales", [(1.0, 1.0, 1.0), (0.5, 2.0, 1.3), (-0.5, 2.0, 1.3)])
def test_uv_of_a_ball_is_by_direction_in_its_own_space(scales):
    """As Cycles maps it: the world's direction by the inverse of the lamp's matrix, scales too."""
    lamp = _lamp(scales)
    u, v = (part.ravel() for part in np.meshgrid([0.1, 0.45, 0.8], [0.2, 0.5, 0.7]))
    _, way = lamp.at(u, v)
    matrix = lamp.to_world[:3, :3]
    world = way @ (matrix / np.linalg.norm(matrix, axis=0)).T
    x, y, z = np.linalg.solve(matrix, world.T)
    length = np.sqrt(x * x + y * y + z * z)
    expected = 0.5 - np.arctan2(x, y) / (2.0 * np.pi), 1.0 - np.arccos(z / length) / np.pi
    found = lamp.uv(u, v, way)
    np.testing.assert_allclose(found[:, :2].T, expected, atol=1e-6)  # float32
    own = np.abs(found[:, 0] - u).max()
    assert (own < 1e-6) if scales[0] == scales[1] else (own > 0.03)
