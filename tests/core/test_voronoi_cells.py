"""voronoi_cells.py and its node: distances to random points, against a point after another."""

import itertools

import numpy as np
import pytest

from iwis.core.nodes.hashing import hash_numbers, hash_to_color
from iwis.core.nodes.voronoi import _Cells

DIMENSIONS = (1, 2, 3, 4)
METRICS = {
    "EUCLIDEAN": lambda way, e: np.sqrt((way**2).sum()),
    "MANHATTAN": lambda way, e: np.abs(way).sum(),
    "CHEBYCHEV": lambda way, e: np.abs(way).max(),
    "MINKOWSKI": lambda way, e: (np.abs(way) ** e).sum() ** (1.0 / e),
}
N = 40
ROUNDING = 2e-5  # float32 numbers of some ten


def _wrapped(x):
    return (int(x) + 2**31) % 2**32 - 2**31


def _unit(x):
    return (x & 0x7FFFFFFF) / 0x7FFFFFFF


def _flat(i, j):
    x, y = (_wrapped(v * 1664525 + 1013904223) for v in (i, j))
    for turn in range(2):
        x = _wrapped(x + y * 1664525)
        y = _wrapped(y + x * 1664525)
        if turn == 0:
            x, y = x ^ (x >> 16), y ^ (y >> 16)
    return np.array([_unit(x), _unit(y)])


def _numbers(cell):
    """PCG, of three or four dimensions."""
    v = [_wrapped(c * 1664525 + 1013904223) for c in cell]
    v += [_wrapped(1013904223)] * (3 - len(v))
    last = len(v) - 1
    pairs = [(1, 2), (2, 0), (0, 1)] if last == 2 else [(1, 3), (2, 0), (0, 1), (1, 2)]
    for turn in range(2):
        for k, (a, b) in enumerate(pairs):
            v[k] = _wrapped(v[k] + v[a] * v[b])
        if turn == 0:
            v = [x ^ (x >> 16) for x in v]
    return np.array([_unit(x) for x in v])


def _color(cell):
    if len(cell) == 1:
        return hash_to_color(np.float32([[cell[0]]]))[0]
    return _numbers(cell)[:3]


def _place(cell, randomness):
    """The point of a cell."""
    if len(cell) == 1:
        own = hash_numbers(np.float32([cell[0]]))
    else:
        own = _flat(*cell) if len(cell) == 2 else _numbers(cell)[: len(cell)]
    return np.array(cell) + own * randomness


def _before(cell, turns):
    """Jenkins' numbers of a cell, as Blender 4.5 took them: of these orders of its axes in four
    dimensions, else with 1 and 2 after them."""
    own = [np.float32([c]) for c in cell]
    if len(own) == 4:
        orders = [[own["xyzw".index(axis)] for axis in turn] for turn in turns]
    else:
        orders = [own, *([*own, np.float32([k])] for k in (1.0, 2.0))]
    return np.array([hash_numbers(*order)[0] for order in orders])


@pytest.mark.parametrize("dimensions", [2, 3, 4])
def test_cells_of_before_blender_5(dimensions, rng):
    """Their points and colours; on the line nothing has changed."""
    p = rng.uniform(-9.0, 9.0, (dimensions, N)).astype(np.float32)
    one = np.ones(N, np.float32)
    distance, color, place = _Cells("EUCLIDEAN", one, one, one, True).nearest(p)
    for n in range(N):
        cells = list(_cells_about(p[:, n], 1))
        points = [
            cell + _before(cell, ("xyzw", "wxyz", "zwxy", "yzwx"))[:dimensions] for cell in cells
        ]
        ways = [np.linalg.norm(point - p[:, n]) for point in points]
        k = int(np.argmin(ways))
        np.testing.assert_allclose(distance[n], ways[k], atol=ROUNDING)
        np.testing.assert_allclose(place[:, n], points[k], atol=ROUNDING)
        expected = _before(cells[k], ("xyzw", "zxwy", "wzyx"))
        np.testing.assert_allclose(color[n], expected, atol=1e-6)


def test_the_line_is_the_same_in_all_versions(rng):
    p, one = rng.uniform(-9.0, 9.0, (1, N)).astype(np.float32), np.ones(N, np.float32)
    found, other = (_Cells("EUCLIDEAN", one, one, one, k).nearest(p) for k in (False, True))
    for a, b in zip(found, other, strict=True):
        np.testing.assert_array_equal(a, b)


def _cells_about(p, reach):
    """x runs fastest."""
    first = [int(c) for c in np.floor(p)]
    for offset in itertools.product(range(-reach, reach + 1), repeat=len(p)):
        yield [c + o for c, o in zip(first, offset[::-1], strict=True)]


@pytest.fixture(params=DIMENSIONS)
def case(request, rng):
    """(p float32 (d, n), randomness, exponent, smoothness)"""
    p = rng.uniform(-9.0, 9.0, (request.param, N)).astype(np.float32)
    ends = ((0.2, 1.0), (0.6, 3.0), (0.05, 0.5))
    return p, *(rng.uniform(*pair, N).astype(np.float32) for pair in ends)


@pytest.mark.parametrize("second", [False, True])
@pytest.mark.parametrize("metric", METRICS)
def test_the_nearest_points(metric, second, case):
    p, randomness, exponent, smoothness = case
    found = _Cells(metric, randomness, exponent, smoothness).nearest(p, second)
    for n, (distance, color, place) in enumerate(zip(found[0], found[1], found[2].T, strict=True)):
        at = p[:, n].astype(np.float64)
        cells = list(_cells_about(at, 1))
        places = [_place(cell, randomness[n]) for cell in cells]
        ways = [METRICS[metric](q - at, exponent[n]) for q in places]
        k = np.argsort(ways, kind="stable")[int(second)]
        np.testing.assert_allclose(distance, ways[k], atol=ROUNDING)
        np.testing.assert_allclose(place, places[k], atol=ROUNDING)
        np.testing.assert_allclose(color, _color(cells[k]), atol=1e-6)


@pytest.mark.parametrize("metric", ["EUCLIDEAN", "MINKOWSKI"])
def test_points_that_flow_into_each_other(metric, case):
    p, randomness, exponent, smoothness = (a[..., :4] for a in case)
    found = _Cells(metric, randomness, exponent, smoothness).smooth(p)
    for n, (distance, color, place) in enumerate(zip(found[0], found[1], found[2].T, strict=True)):
        at, soft = p[:, n].astype(np.float64), float(smoothness[n])
        total = np.zeros(4 + len(p))
        for k, cell in enumerate(_cells_about(at, 2)):
            there = _place(cell, randomness[n])
            way = METRICS[metric](there - at, exponent[n])
            h = np.clip(0.5 + 0.5 * (total[0] - way) / soft, 0.0, 1.0)
            h = h * h * (3.0 - 2.0 * h) if k else 1.0
            less = np.full(len(total), soft * h * (1.0 - h))
            less[1:] /= 1.0 + 3.0 * soft
            total += h * (np.concatenate([[way], _color(cell), there]) - total) - less
        expected = np.split(total, [1, 4])
        # Up to 625 steps, each with the last one's rounding.
        np.testing.assert_allclose(distance, expected[0][0], atol=1e-4)
        np.testing.assert_allclose(color, expected[1], atol=1e-4)
        np.testing.assert_allclose(place, expected[2], atol=4e-4)


def test_borders_lie_half_way_between_points(case):
    p, randomness, *rest = case
    found = _Cells("EUCLIDEAN", randomness, *rest).edge(p)
    for n, distance in enumerate(found):
        at = p[:, n].astype(np.float64)
        places = np.array([_place(cell, randomness[n]) for cell in _cells_about(at, 1)])
        if len(p) == 1:  # as Cycles: those of the cell itself
            expected = np.abs((places[[0, 2]] + places[1]) / 2.0 - at).min()
        else:
            nearest = places[np.linalg.norm(places - at, axis=1).argmin()]
            across = places - nearest
            size = np.linalg.norm(across, axis=1)
            ways = ((nearest + places) / 2.0 - at) * across
            expected = (ways.sum(1)[size > 0.01] / size[size > 0.01]).min()
        np.testing.assert_allclose(distance, expected, atol=ROUNDING)


def test_radii_reach_half_way_to_the_next_point(case):
    p, randomness, *rest = case
    cells = _Cells("EUCLIDEAN", randomness, *rest)
    _, _, places = cells.nearest(p)
    for n, radius in enumerate(cells.radius(p)):
        at = places[:, n].astype(np.float64)
        others = [_place(c, randomness[n]) for c in _cells_about(at, 1) if c != list(np.floor(at))]
        expected = np.linalg.norm(np.array(others) - at, axis=1).min() / 2.0
        np.testing.assert_allclose(radius, expected, atol=ROUNDING)


def test_places_that_are_none_have_a_point():
    p = np.float32([[np.nan, np.inf, -np.inf], [0.5, 0.5, 0.5]])
    one = np.ones(3, np.float32)
    for values in _Cells("EUCLIDEAN", one, one, one).nearest(p):
        assert np.isfinite(values).all()
