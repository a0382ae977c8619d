"""sphere_map.py: the squares map to the sphere and the hemisphere, areas and all."""

import numpy as np
import pytest

from iwis.core.unit_square.sphere_map import (
    hemisphere_grid,
    hemisphere_to_square,
    sphere_grid,
    sphere_to_square,
    square_to_hemisphere,
    square_to_sphere,
)

MAPS = {
    "sphere": (square_to_sphere, sphere_to_square, 4.0 * np.pi),
    "hemisphere": (square_to_hemisphere, hemisphere_to_square, 2.0 * np.pi),
}
# Where the maps' branches meet: the centre, the diagonals, the axes, the edges and corners.
SEAMS = [(x, y) for x in (0.0, 0.25, 0.5, 0.75, 1.0) for y in (0.0, 0.25, 0.5, 0.75, 1.0)]


@pytest.mark.parametrize("name", MAPS)
def test_square_to_direction_and_back(name, rng):
    """Every inner point comes back; directions have unit length."""
    to_direction, to_square, _ = MAPS[name]
    for x, y in rng.random((2000, 2)):
        direction = to_direction(x, y)
        assert np.linalg.norm(direction) == pytest.approx(1.0, abs=1e-14)  # float64
        assert to_square(*direction) == pytest.approx((x, y), abs=1e-7)  # sqrt(1 - z) near a pole


@pytest.mark.parametrize("name", MAPS)
def test_direction_to_square_and_back(name, rng):
    """Every direction comes back, those on the seams and the axes too."""
    to_direction, to_square, _ = MAPS[name]
    directions = rng.standard_normal((2000, 3))
    directions[:200, 0] = 0.0
    directions[200:400, 1] = 0.0
    directions[400:600, 2] = 0.0
    directions[600:606] = np.concatenate([np.eye(3), -np.eye(3)])
    if name == "hemisphere":
        directions[:, 2] = np.abs(directions[:, 2])
    for d in directions / np.linalg.norm(directions, axis=-1, keepdims=True):
        x, y = to_square(*d)
        assert 0.0 <= x <= 1.0 and 0.0 <= y <= 1.0
        assert to_direction(x, y) == pytest.approx(tuple(d), abs=3e-8)  # sqrt(1 - |z|) near a pole


@pytest.mark.parametrize("name", MAPS)
def test_seams_give_unit_directions(name):
    """No NaN where branches meet."""
    to_direction, _, _ = MAPS[name]
    for x, y in SEAMS:
        assert np.linalg.norm(to_direction(x, y)) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize("name", MAPS)
def test_density_is_constant(name, rng):
    """The area of a small parallelogram is 4 pi (2 pi) times that of its square, everywhere."""
    to_direction, _, density = MAPS[name]
    step = 1e-5
    for x, y in 0.02 + 0.95 * rng.random((500, 2)):
        u, v = 2.0 * x - 1.0, 2.0 * y - 1.0
        if min(abs(u), abs(v), abs(abs(u) - abs(v)), abs(1.0 - abs(u) - abs(v))) < 4.0 * step:
            continue  # a seam: the map bends there
        dx = np.subtract(to_direction(x + step, y), to_direction(x - step, y))
        dy = np.subtract(to_direction(x, y + step), to_direction(x, y - step))
        area = np.linalg.norm(np.cross(dx, dy)) / (2.0 * step) ** 2
        # Central differences: the relative error grows as step^2 over the distance to a pole^2.
        assert area == pytest.approx(density, rel=1e-4)


def test_hemisphere_is_the_upper_one(rng):
    """z >= 0 all over the square."""
    assert min(square_to_hemisphere(x, y)[2] for x, y in rng.random((1000, 2))) >= 0.0


@pytest.mark.parametrize(
    ("grid", "name"), [(sphere_grid, "sphere"), (hemisphere_grid, "hemisphere")]
)
def test_grids_are_cell_centres_row_by_row(grid, name):
    """Cell (row i, column j) of side 8 is entry 8 i + j."""
    directions = grid(8)
    assert directions.shape == (64, 3) and directions.dtype == np.float32
    for i in range(8):
        for j in range(8):
            expected = MAPS[name][0]((j + 0.5) / 8, (i + 0.5) / 8)
            np.testing.assert_array_equal(directions[8 * i + j], np.float32(expected))
