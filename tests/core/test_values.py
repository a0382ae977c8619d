"""core/nodes/values.py: the values of nodes."""

import numpy as np
import pytest

from iwis.core.nodes.values import as_number, as_vector, convert, dot, normalized


@pytest.mark.parametrize("n", [1, 5])
@pytest.mark.parametrize("value", [2.0, np.float64([1.0, 2.0, 3.0]), np.broadcast_to(1.0, (5, 3))])
def test_values_are_arrays_of_one_kind(value, n):
    """Else kernels are compiled once more, in the middle of a render: for read-only arrays, too."""
    if np.ndim(value) == 2:
        value = value[:n]
    found = [as_vector(value, n)]
    if np.ndim(value) == 0:
        found.append(as_number(value, n))
    for array in found:
        assert array.dtype == np.float32 and len(array) == n
        assert array.flags.c_contiguous and array.flags.writeable
        np.testing.assert_array_equal(array, np.broadcast_to(value, array.shape))


def test_a_value_that_is_an_array_already_is_not_copied():
    vectors = np.ones((4, 3), np.float32)
    assert as_vector(vectors, 4) is vectors
    assert as_number(vectors[:, 0], 4).flags.c_contiguous


def test_rows_of_vectors(rng):
    a, b = rng.standard_normal((2, 50, 3)).astype(np.float32)
    a[0] = 0.0
    np.testing.assert_allclose(dot(a, b), np.einsum("ij,ij->i", a, b), atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(normalized(a)[1:], axis=1), 1.0, atol=1e-6)
    np.testing.assert_array_equal(normalized(a)[0], 0.0)
    np.testing.assert_allclose(convert(a, "VECTOR", "NUMBER"), a.mean(1), atol=1e-6)
