"""core/nodes: what Cycles makes of 0, of negative numbers and of ranges without width."""

import numpy as np
import pytest

from iwis.core.nodes.arithmetic import map_range, math, vector_math
from iwis.core.nodes.color import rgb_to_hsl, rgb_to_hsv
from iwis.core.nodes.coordinates import vector_transform

_NUMBERS = "Value", "From Min", "From Max", "To Min", "To Max", "Steps"


def mapped(values, kind="LINEAR", clamp=False):
    """The result of Map Range of numbers, by _NUMBERS."""
    settings = {"data_type": "FLOAT", "interpolation_type": kind, "clamp": clamp}
    inputs = dict(zip(_NUMBERS, np.float32(values), strict=True))
    return float(map_range(None, settings, inputs)["Result"])


@pytest.mark.parametrize("before, infinite", [(True, True), (False, False)])
def test_zero_to_a_negative_power(before, infinite):
    """Infinite in Blender 4.5, 0 since 5.0; 0 to the power of 0 is 1 in both."""
    a, b = np.float32([0.0, 0.0, -2.0, -2.0]), np.float32([-1.5, 0.0, -2.0, 0.5])
    settings = {"operation": "POWER", "use_clamp": False, "before": before}
    with np.errstate(divide="ignore"):
        found = math(None, settings, {"Value": a, "Value_001": b})["Value"]
    assert list(found) == [np.inf if infinite else 0.0, 1.0, 0.25, 0.0]


def test_modulo_of_vectors_is_by_the_rounded_quotient():
    """1 modulo .1 is .1 less a rounding in Blender 4.5, and nothing since 5.0."""
    a, b = np.float32([[1.0, -7.3, 3.0]]), np.float32([[0.1, 0.0, -2.0]])
    found = {}
    for before in (True, False):
        settings = {"operation": "MODULO", "before": before}
        found[before] = vector_math(None, settings, {"Vector": a, "Vector_001": b})["Vector"]
    np.testing.assert_allclose(found[True], [[0.1, 0.0, 1.0]], atol=1e-6)  # float32
    np.testing.assert_allclose(found[False], [[0.0, 0.0, 1.0]], atol=1e-6)


@pytest.mark.parametrize("kind", ["LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"])
def test_a_range_without_width_gives_zero(kind):
    """Then clamped to where it may be, of smooth steps too."""
    assert mapped([3.0, 1.0, 1.0, 5.0, 7.0, 4.0], kind) == 0.0
    assert mapped([3.0, 1.0, 1.0, 5.0, 7.0, 4.0], kind, clamp=True) == 5.0


@pytest.mark.parametrize("steps, expected", [(4.0, 6.0), (0.0, 5.0), (-2.0, 5.0)])
def test_without_steps_all_is_at_the_low_end(steps, expected):
    """And with four of them half of the way is half of it."""
    assert mapped([0.5, 0.0, 1.0, 5.0, 7.0, steps], "STEPPED") == expected


def test_what_has_no_brightness_has_no_hue():
    """Its largest channel is 0, whatever the others are."""
    found = rgb_to_hsv(np.float32([[-1.0, 0.0, -0.5], [0.0, 0.0, 0.0], [0.2, 0.4, 0.2]]))
    np.testing.assert_allclose(found, [[0, 0, 0], [0, 0, 0], [1 / 3, 0.5, 0.4]], atol=1e-6)


def test_saturation_is_infinite_where_bright_and_dark_cancel():
    """Of HSL, as in Cycles: the least channel is as far below 0 as the largest above. Greys: 0."""
    with np.errstate(divide="ignore"):
        found = rgb_to_hsl(np.float32([[100.0, -100.0, 2.0], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]))
    assert list(found[:, 1]) == [np.inf, 0.0, 0.0]


@pytest.mark.parametrize("kind", ["POINT", "VECTOR", "NORMAL"])
def test_what_stays_in_its_space_stays_as_it_is(kind):
    """A normal keeps its length."""
    settings = {"vector_type": kind, "convert_from": "OBJECT", "convert_to": "OBJECT"}
    given = np.float32([[3.0, 0.0, -4.0]])
    assert vector_transform(None, settings, {"Vector": given})["Vector"] is given
