"""Coordinates of what shines in all directions (core/nodes/lamp_map.py)."""

import numpy as np
import pytest

from iwis.core.data.program import Op, Program, Ref
from iwis.core.nodes.lamp_map import LampPlaces, lamp_picture


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


def test_a_disc_faces_what_it_lights_and_shows_the_mean_over_it():
    """Of the square of the place across its object, which a scale does not change: half of the
    radius squared over the object's two axes that the disc spans, in every direction."""
    place = Op("ShaderNodeTexCoord", {}, {"outputs": {"Object"}})
    inputs = {"Vector": Ref(0, "Object"), "Vector_001": Ref(0, "Object")}
    squared = Op("ShaderNodeVectorMath", inputs, {"operation": "MULTIPLY", "before": False})
    program, value = Program(ops=(place, squared), closures=()), Ref(1, "Vector")
    for scales in ((1.0, 1.0, 1.0), (0.5, 2.0, 1.25)):
        lamp = LampPlaces(np.diag([*scales, 1.0]), disc=0.4)
        found = lamp_picture(program, value, lamp, None, 64, 32)
        # A wide average of few places each.
        total = (found * np.square(scales)).sum(-1).mean()
        np.testing.assert_allclose(total, 0.5 * 0.4**2, rtol=1e-3)
        poles = (found[[0, -1]] * np.square(scales)).mean((0, 1))
        np.testing.assert_allclose(poles[:2], 0.25 * 0.4**2, rtol=0.1)
        assert poles[2] < 1e-3
        middle = lamp_picture(program, value, lamp._replace(disc=0.0), None, 64, 32)
        assert not middle.any()
