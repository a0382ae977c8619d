"""Curves Info and Point Info: what they tell of points on strands, and elsewhere."""

import numpy as np
import pytest

from iwis.core.nodes.element_info import curves_info, point_info

OUTPUTS = ("Is Strand", "Intercept", "Length", "Thickness", "Tangent Normal", "Random")


class Context:
    """Two points of an object that is twice as large and stands at x = 5."""

    object = np.zeros(2, np.int32)
    wo = np.float32([[0, 0, 1], [1, 0, 0]])

    def __init__(self, tables):
        self._tables = tables
        matrix = np.diag([2.0, 2.0, 2.0, 1.0])
        matrix[0, 3] = 5.0
        self.surface = type("Surface", (), {"object_to_world": matrix[None]})

    def __len__(self):
        return 2

    def attribute(self, name):
        return self._tables.get(name)

    def vector_to_world(self, vectors):
        return 2.0 * vectors


def test_strand_tells_of_itself():
    """Thickness and tangent in the world; the tangent normal is at right angles to the strand."""
    column = np.float32([[0.25], [0.5]])
    tables = {f"element:{name}": column for name in OUTPUTS}
    tables["element:Tangent"] = np.float32([[3, 0, 4], [0, 2, 0]])
    found = curves_info(Context(tables), {"outputs": OUTPUTS}, {})
    for name in ("Is Strand", "Intercept", "Length", "Random"):
        np.testing.assert_array_equal(found[name], column[:, 0])
    np.testing.assert_allclose(found["Thickness"], [0.5, 1.0], rtol=1e-6)  # float32
    expected = [[-0.8, 0.0, 0.6], [1.0, 0.0, 0.0]]
    np.testing.assert_allclose(found["Tangent Normal"], expected, atol=1e-6)


def test_point_tells_of_itself():
    """Its middle and radius in the world; where there is no point, all is 0."""
    tables = {
        "element:Position": np.float32([[1, 2, 3], [0, 0, 0]]),
        "element:Radius": np.float32([[0.1], [0.0]]),
        "element:Random": np.float32([[0.7], [0.0]]),
    }
    found = point_info(Context(tables), {"outputs": ("Position", "Radius", "Random")}, {})
    np.testing.assert_allclose(found["Position"], [[7, 4, 6], [0, 0, 0]])
    np.testing.assert_allclose(found["Radius"], [0.2, 0.0], rtol=1e-6)
    np.testing.assert_allclose(found["Random"], np.float32([0.7, 0.0]))


@pytest.mark.parametrize("node", [curves_info, point_info])
def test_elsewhere_all_is_zero(node):
    """On a scene of meshes there are no tables."""
    outputs = OUTPUTS if node is curves_info else ("Position", "Radius", "Random")
    for value in node(Context({}), {"outputs": outputs}, {}).values():
        assert not value.any()
