"""lamp_falloff.py, nodes/falloff.py: light that changes with the distance that it goes."""

import types

import numpy as np
import pytest

from iwis.core.data.lamps import (
    BEAM,
    DISC,
    FALLOFF_ROWS,
    RECTANGLE,
    SPHERE,
    SUN,
    falloff_knots,
    make_lamps,
)
from iwis.core.lamplight.lamp_falloff import falloff_at
from iwis.core.nodes.falloff import INFINITELY_FAR, falloff_of, light_falloff
from support.lamp_points import sampled
from support.lamp_rows import area
from support.scenes import diffuse, glossy

ALL = {"outputs": {"Quadratic", "Linear", "Constant"}}
DISTANCES = np.float32([0.0, 0.013, 0.5, 1.0, 3.7, 250.0, 1e6])


def node(distance, strength=1.0, smooth=0.0):
    """The outputs of a Light Falloff node."""
    context = types.SimpleNamespace(ray_length=np.float32(distance))
    inputs = {"Strength": np.float32(strength), "Smooth": np.float32(smooth)}
    return light_falloff(context, ALL, inputs)


def test_the_node_multiplies_by_powers_of_the_distance():
    """Strength, times the distance, times its square."""
    found = node(DISTANCES, 3.0)
    np.testing.assert_allclose(found["Quadratic"], np.full(7, 3.0))
    np.testing.assert_allclose(found["Linear"], 3.0 * DISTANCES, rtol=1e-6)  # float32
    np.testing.assert_allclose(found["Constant"], 3.0 * DISTANCES.astype(float) ** 2, rtol=1e-6)


def test_smooth_dims_what_is_near():
    """By d^2 / (smooth + d^2), each output; below 0 it does nothing, as in Cycles."""
    plain, found, below = node(DISTANCES), node(DISTANCES, smooth=2.0), node(DISTANCES, smooth=-1.0)
    squared = DISTANCES.astype(float) ** 2
    for name, value in found.items():
        np.testing.assert_allclose(value, plain[name] * squared / (2.0 + squared), rtol=1e-6)
        np.testing.assert_array_equal(below[name], plain[name])


def test_what_is_infinitely_far_shines_as_without_the_node():
    """A sun: Strength whatever the output and Smooth, as Cycles renders it."""
    found = node(INFINITELY_FAR, 3.0, 5.0)
    assert {float(value) for value in found.values()} == {3.0}


def table_of(function):
    """Lamps.falloffs' table of one function for three channels."""
    return np.repeat(np.float32(function(falloff_knots().astype(float)))[:, None], 3, axis=1)


@pytest.mark.parametrize(("power", "error"), [(0, 1e-6), (1, 1e-6), (2, 6.2e-5)])
def test_a_table_is_right_between_its_rows(power, error):
    """Exact but for float32 where the function is linear; a square is at the most a quarter of a
    step's square off, (1 / 64)^2 / 4."""
    lamps = make_lamps([{"falloff": table_of(lambda d: d**power)}])
    for far in np.geomspace(1e-3, 1e6, 500):
        np.testing.assert_allclose(falloff_at(lamps, 0, far), np.full(3, far**power), rtol=error)


def test_a_table_ends_where_it_ends():
    """Nearer, farther, and infinitely far are the first and the last row."""
    knots = falloff_knots()
    lamps = make_lamps([{"falloff": table_of(lambda d: d)}])
    assert knots[0] == 2.0**-14 and knots[-1] == 2.0**30 and len(knots) == FALLOFF_ROWS
    for far, end in ((0.0, 0), (1e-9, 0), (1e12, -1), (np.inf, -1)):
        assert falloff_at(lamps, 0, far)[0] == knots[end]


def test_equal_tables_are_kept_once():
    """Of lamps with the same nodes; one without has none."""
    linear, square = table_of(lambda d: d), table_of(lambda d: d * d)
    lamps = make_lamps([{"falloff": linear}, {}, {"falloff": square}, {"falloff": linear.copy()}])
    assert lamps.falloff.tolist() == [0, -1, 1, 0] and len(lamps.falloffs) == 2
    assert lamps.at([2]).falloff.tolist() == [1]


LAMPS = {
    "point": {"kind": SPHERE, "position": (0.5, 0.2, 1.5)},
    "ball": {"kind": SPHERE, "position": (0.5, 0.2, 1.5), "size": (0.2, 0.0)},
    "disc": {"kind": DISC, "position": (0.5, 0.2, 1.5), "size": (0.4, 0.0)},
    "panel": area(RECTANGLE, (0.8, 0.1, 1.0), 0.6, 0.3),
    "beam": area(BEAM, (0.6, 0.0, 0.8), 0.5, 0.3),
}


@pytest.mark.parametrize("name", LAMPS)
@pytest.mark.parametrize("material", [diffuse(), glossy(0.05)], ids=["matte", "gloss"])
def test_the_same_factor_at_all_distances_is_that_factor(name, material):
    """Sample by sample, for both ways of sampling."""
    row = LAMPS[name] | {"radiance": (3.0, 2.0, 1.0)}
    plain = sampled([row], material, pixels=100)
    doubled = sampled([row | {"falloff": table_of(lambda d: 0.0 * d + 2.0)}], material, pixels=100)
    np.testing.assert_allclose(doubled, 2.0 * plain, rtol=1e-6)
    assert plain.any() or name in ("point", "beam")


@pytest.mark.parametrize("kind", ["point", "beam"])
def test_constant_light_is_that_of_a_metre(kind):
    """What falls off with the square, times the square."""
    for far in (0.3, 4.0):
        place = np.array([0.0, 0.0, far])
        row = {"kind": SPHERE, "position": place} if kind == "point" else None
        row = row or area(BEAM, place, 0.5, 0.3, np.eye(3))
        row |= {"radiance": 2.0}
        plain = sampled([row], diffuse(), 1, 1)[0, :3]
        found = sampled([row | {"falloff": table_of(lambda d: d * d)}], diffuse(), 1, 1)[0, :3]
        np.testing.assert_allclose(found, plain * far**2, rtol=1e-4)  # the table's error


def test_many_lamps_are_chosen_by_what_arrives():
    """Of 40 lamps at 1 to 40 m with constant light each brings as much: chosen by what falls off
    with the square, a far one would be brought by a sample in 1600, of 1600 times the weight."""
    rows = [
        {"kind": SPHERE, "position": (0.0, 0.0, 1.0 + k), "radiance": 1.0, "falloff": square}
        for square in [table_of(lambda d: d * d)]
        for k in range(40)
    ]
    found = sampled(rows, diffuse(), pixels=200)[:, 0]
    exact = 40.0 * sampled(rows[:1], diffuse(), 1, 1)[0, 0]
    np.testing.assert_allclose(found, exact, rtol=2e-3)  # shares are even but for the table


def test_lamps_that_are_dark_at_their_middles_distance_are_chosen():
    """A share is 0 only where no light comes: the lamp may shine from its nearer end."""
    gate = table_of(lambda d: (d < 1.0).astype(float))
    panel = area(RECTANGLE, (0.0, 0.0, 1.05), 1.0, 1.0, np.diag([1.0, 1.0, 1.0]))
    tilted = panel | {"position": (0.7, 0.0, 0.8), "falloff": gate, "radiance": 5.0}
    dim = {"kind": SUN, "radiance": 1e-9, "size": (0.0, 0.0)}
    one = sampled([tilted], diffuse(), 2000).mean(0)[0]
    many = sampled([tilted] + [dim] * 20, diffuse(), 2000).mean(0)[0]
    assert one > 0.0
    np.testing.assert_allclose(many, one, rtol=0.02)  # 2000 samples each


def places(function):
    """falloff_of light(k, distance) of 50 places."""
    return falloff_of(lambda k, d: np.float32(function(k[:, None], d[:, None].astype(float))), 50)


def test_a_falloff_is_told_apart_from_what_varies():
    """Colour by place times a function of the distance; its colour is the mean at the distance."""
    tint = np.float32([1.0, 0.5, 0.0])
    found = places(lambda k, d: (1.0 + k) * tint * d / (1.0 + d))
    assert found.whole and not found.even and found.distance == 1.0
    np.testing.assert_allclose(found.color, 25.5 * tint * 0.5, rtol=1e-6)
    knots = falloff_knots()
    np.testing.assert_allclose(found.table[:, 0], 2.0 * knots / (1.0 + knots), rtol=1e-5)
    assert not found.table[:, 2].any()


def test_what_is_the_same_all_over_is_even():
    """Its colours may fall off each in its own way."""
    found = places(lambda k, d: np.concatenate([d, d * d, 1.0 + 0.0 * d], axis=1) + 0.0 * k)
    assert found.even and found.whole
    np.testing.assert_allclose(found.table[7 * 64], 2.0 ** np.array([-7.0, -14.0, 0.0]))


def test_places_that_fall_off_each_in_its_own_way_are_told():
    """One factor is not right for all of them."""
    assert not places(lambda k, d: 1.0 + k % 2 * d * np.ones(3)).whole


def test_light_that_does_not_reach_a_metre_is_looked_for_elsewhere():
    """Nearer, or farther."""
    near = places(lambda k, d: (d < 0.4) * np.ones(3) + 0.0 * k)
    far = places(lambda k, d: (d > 5.0) * np.ones(3) + 0.0 * k)
    assert near.distance == 0.25 and far.distance == 8.0 and near.whole and far.whole
    assert not places(lambda k, d: 0.0 * d * np.ones(3) + 0.0 * k).table.any()
