"""lamps.py, lamp_shapes.py, lamp_areas.py, lamp_light.py: each lamp brings what it should."""

import math

import numpy as np
import pytest

from iwis.core.data.lamps import (
    BEAM,
    BY_DIFFUSE,
    BY_GLOSSY,
    DISC,
    ELLIPSE,
    NOT_BY_BSDF,
    RECTANGLE,
    ROUND_BEAM,
    SPHERE,
    SUN,
    make_lamps,
)
from support.brdf_points import eval_all
from support.lamp_points import sampled, seen_point
from support.lamp_rows import TILTED, area
from support.scenes import (
    box,
    constant_world,
    diffuse,
    glossy,
    principled,
)
from support.statistics import sidak, t_p_value

DARK = constant_world((0.0, 0.0, 0.0))


def spot(degrees, blend, forward=(0.0, 0.0, -1.0)):
    """Fields of a cone about ``forward``."""
    z = -np.asarray(forward, np.float64)
    x = np.cross((0.0, 1.0, 0.0), z)
    frame = np.stack([x / np.linalg.norm(x), np.cross(z, x / np.linalg.norm(x)), z])
    edge = math.cos(math.radians(degrees) / 2)
    return {"to_cone": frame, "cone": (edge, 1.0 / ((1.0 - edge) * blend))}


def spread(degrees):
    half = math.radians(degrees) / 2
    return {"spread": (math.tan(half), 1.0 / (math.tan(half) - half))}


# Of an area whose plane an uneven scale makes slant.
SLANTED = {"axis": np.array([-0.2, 0.3, -1.0]) / math.sqrt(1.13)}

LAMPS = {
    "sphere": {"kind": SPHERE, "position": (0.5, 0.2, 1.5), "size": (0.4, 0.0)},
    "small sphere": {"kind": SPHERE, "position": (0.5, 0.2, 1.5), "size": (0.002, 0.0)},
    "disc": {"kind": DISC, "position": (0.5, 0.2, 1.0), "size": (0.4, 0.0)},
    "spot": {"kind": SPHERE, "position": (0.5, 0.2, 1.5), "size": (0.3, 0.0)} | spot(50.0, 0.6),
    "sun": {"kind": SUN, "size": (0.3, 0.0), "forward": (-0.6, 0.0, -0.8)},
    "small sun": {"kind": SUN, "size": (0.004, 0.0), "forward": (-0.6, 0.0, -0.8)},
    "rectangle": area(RECTANGLE, (0.8, 0.1, 1.0), 0.6, 0.3),
    "large rectangle": area(RECTANGLE, (0.3, 0.1, 0.4), 3.0, 2.0, np.eye(3)),
    "far rectangle": area(RECTANGLE, (80.0, 10.0, 100.0), 0.6, 0.3),
    "softbox": area(RECTANGLE, (0.6, 0.1, 1.0), 0.9, 0.7, **spread(40.0)),
    "slanted rectangle": area(RECTANGLE, (0.8, 0.1, 1.0), 0.6, 0.3, **SLANTED),
    "slanted, from behind": area(RECTANGLE, (0.8, 0.1, 1.0), 0.6, 0.3, -TILTED, **SLANTED),
    "slanted softbox": area(RECTANGLE, (0.6, 0.1, 1.0), 0.9, 0.7, **SLANTED, **spread(110.0)),
    "ellipse": area(ELLIPSE, (0.8, 0.1, 1.0), 0.6, 0.3),
    "large ellipse": area(ELLIPSE, (0.3, 0.1, 0.4), 3.0, 2.0, np.eye(3)),
    "narrow ellipse": area(ELLIPSE, (0.6, 0.1, 1.0), 1.8, 1.4, **spread(40.0)),
}
MATERIALS = {
    "diffuse": diffuse((0.8, 0.5, 0.3)),
    "gloss": glossy(0.1, (0.9, 0.8, 0.7)),
    "shiny": glossy(0.02, (0.9, 0.8, 0.7)),
    "paint": principled(base_color=(0.2, 0.4, 0.6), roughness=0.4),
}
RADIANCE = (3.0, 2.0, 1.0)


def places_on(lamp):
    """Directions (n, 3) from the origin to a lamp, solid angles, angles from its axis' cosine."""
    size, kind = np.asarray(lamp["size"]), lamp["kind"]
    if kind in (RECTANGLE, ELLIPSE):
        n = 700
        side = (np.arange(n) + 0.5) / n - 0.5
        u, v = (a.ravel() for a in np.meshgrid(side, side))
        inside = (u * u + v * v <= 0.25) | (kind == RECTANGLE)
        u, v = u[inside, None] * size[0], v[inside, None] * size[1]
        place = np.asarray(lamp["position"]) + u * lamp["right"] + v * lamp["up"]
        far = np.linalg.norm(place, axis=1)
        wi = place / far[:, None]
        seen = -wi @ lamp["forward"]
        seen = np.abs(seen) if "axis" in lamp else np.maximum(seen, 0.0)
        cosine = -wi @ lamp.get("axis", lamp["forward"])
        return wi, seen * size.prod() / n**2 / far**2, cosine
    if kind == SUN:
        axis, largest = -np.asarray(lamp["forward"]), size[0]
    else:
        axis = np.asarray(lamp["position"]) / np.linalg.norm(lamp["position"])
        slope = size[0] / np.linalg.norm(lamp["position"])
        largest = math.asin(slope) if kind == SPHERE else math.atan(slope)
    steps, around = 1200, 400
    height = (np.arange(steps) + 0.5) / steps * (2.0 * math.sin(largest / 2) ** 2)
    phi = (np.arange(around) + 0.5) / around * 2.0 * math.pi
    x = np.cross(axis, (0.0, 1.0, 0.0))
    x /= np.linalg.norm(x)
    radius = np.sqrt(height * (2.0 - height))[:, None, None]
    ring = np.cos(phi)[:, None] * x + np.sin(phi)[:, None] * np.cross(axis, x)
    wi = (radius * ring + (1.0 - height)[:, None, None] * axis).reshape(-1, 3)
    solid = np.full(len(wi), 4.0 * math.pi * math.sin(largest / 2) ** 2 / len(wi))
    return wi, solid, None


def truth(lamp, material):
    """(r, g, b) by quadrature over the lamp."""
    wi, solid, cosine = places_on(lamp)
    factor = np.ones(len(wi))
    if "cone" in lamp:
        local = -wi @ np.asarray(lamp["to_cone"]).T
        t = np.clip((-local[:, 2] - lamp["cone"][0]) * lamp["cone"][1], 0.0, 1.0)
        factor = t * t * (3.0 - 2.0 * t)
    if "spread" in lamp:
        tangent = np.sqrt(1.0 - cosine**2) / cosine
        factor = np.maximum(lamp["spread"][0] - tangent, 0.0) * lamp["spread"][1]
    _, lobes, _ = seen_point(material)
    brdf = np.empty((len(wi), 6), np.float32)
    eval_all(lobes, 0, wi.astype(np.float32), brdf)
    brdf = brdf[:, :3] + brdf[:, 3:]
    return (brdf * (factor * solid)[:, None]).sum(0, dtype=np.float64) * RADIANCE


CASES = [(lamp, material) for lamp in LAMPS for material in MATERIALS]


@pytest.mark.slow
@pytest.mark.statistical
@pytest.mark.parametrize(("lamp", "material"), CASES)
def test_light_of_a_lamp_is_its_integral(lamp, material):
    """Means over independent pixels by a t test at alpha = 1e-3 in all, or within the quadrature's
    own error: its cells are cut by the rim of an ellipse, a cone or a sharp lobe."""
    row = LAMPS[lamp] | {"radiance": RADIANCE}
    expected = truth(row, MATERIALS[material]).sum()
    found = sampled([row], MATERIALS[material])
    found = (found[:, :3] + found[:, 3:]).sum(1)
    assert expected > 0.0
    level = sidak(1e-3, len(CASES))
    near = abs(found.mean() / expected - 1.0) <= 2e-3
    assert near or t_p_value(found, expected) > level, (found.mean(), expected)
    wrong = 1.05 * expected
    assert t_p_value(found, wrong) < level or found.std() / found.mean() > 0.5


def one(row, material=MATERIALS["diffuse"], **fields):
    """(r, g, b) by both lobes of one pixel's first sample."""
    found = sampled([{"radiance": RADIANCE} | row], material, 1, 1, **fields)[0]
    return found[:3] + found[3:]


ALBEDO = np.array([0.8, 0.5, 0.3]) / math.pi


@pytest.mark.parametrize("kind", [SPHERE, DISC])
def test_a_lamp_without_size_falls_off_with_the_square(kind):
    """Intensity x cosine / distance^2, and nothing of it is sampled."""
    expected = RADIANCE * ALBEDO * 0.8 / 25.0
    found = one({"kind": kind, "position": (3.0, 0.0, 4.0)})
    np.testing.assert_allclose(found, expected, rtol=2e-6)  # float32


def test_a_sun_without_size_is_an_irradiance():
    """Whatever the distance."""
    found = one({"kind": SUN, "forward": (-0.6, 0.0, -0.8)})
    np.testing.assert_allclose(found, RADIANCE * ALBEDO * 0.8, rtol=2e-6)


@pytest.mark.parametrize("kind", [BEAM, ROUND_BEAM])
def test_a_beam_lights_its_own_shadow_only(kind):
    """Inside its outline its irradiance, outside and behind nothing."""
    inside = one(area(kind, (0.6, 0.0, 0.8), 0.5, 0.3))
    np.testing.assert_allclose(inside, RADIANCE * ALBEDO * 0.8, rtol=2e-6)
    beside = np.array([0.6, 0.0, 0.8]) + 0.27 * TILTED[:, 0]
    corner = np.array([0.6, 0.0, 0.8]) + 0.2 * TILTED[:, 0] + 0.12 * TILTED[:, 1]
    assert not one(area(kind, beside, 0.5, 0.3)).any()
    assert one(area(kind, corner, 0.5, 0.3)).any() == (kind == BEAM)
    assert not one(area(kind, (-0.6, 0.0, -0.8), 0.5, 0.3)).any()


def test_a_cone_is_soft_between_its_two_angles():
    """Smoothstep over the cosine: 1 inside, 1/2 in the middle of the edge, 0 outside."""
    whole = one({"kind": SPHERE, "position": (0.0, 0.0, 2.0)})
    edge = math.cos(math.radians(30.0))
    for cosine, share in ((1.0, 1.0), (edge + 0.25 * (1.0 - edge), 0.5), (edge - 0.01, 0.0)):
        axis = -math.sqrt(1.0 - cosine**2), 0.0, -cosine
        row = {"kind": SPHERE, "position": (0.0, 0.0, 2.0)} | spot(60.0, 0.5, axis)
        np.testing.assert_allclose(one(row), whole * share, atol=1e-5 * whole.max())


def test_a_rectangle_has_its_form_factor():
    """Parallel to the floor, a corner over the point: the textbook's formula for a quarter."""
    width, height, above = 0.7, 0.4, 0.5
    x, y = width / above, height / above
    a, b = math.sqrt(1.0 + x * x), math.sqrt(1.0 + y * y)
    form = (x / a * math.atan(y / a) + y / b * math.atan(x / b)) / (2.0 * math.pi)
    row = area(RECTANGLE, (width / 2, height / 2, above), width, height, np.eye(3))
    found = sampled([row | {"radiance": RADIANCE}], MATERIALS["diffuse"], 500, 16).mean(0)[:3]
    np.testing.assert_allclose(found, RADIANCE * ALBEDO * math.pi * form, rtol=2e-3)


@pytest.mark.parametrize("cone", [{}, spot(50.0, 0.6)], ids=["lamp", "spot"])
def test_inside_a_lamp_is_a_furnace(cone):
    """A sphere of radiance 1 around a floor: each diffuse sample is the albedo. A spot's cone is
    nothing to what is inside of it, as in Cycles."""
    row = {"kind": SPHERE, "position": (0.3, 0.2, 0.1), "size": (5.0, 0.0), "radiance": 1.0} | cone
    found = sampled([row], MATERIALS["diffuse"], 50, 1)[:, :3]
    np.testing.assert_allclose(found, np.tile(ALBEDO * math.pi, (50, 1)), rtol=1e-5)


def test_inside_a_lamp_things_throw_shadows():
    """Under a roof that ends at 35 degrees on one side (1 - sin 35) / 2 of the light is left, .21,
    and a little over its other ends; rays end at the lamp's far side, not at the point."""
    row = {"kind": SPHERE, "position": (0.3, 0.2, 0.1), "size": (5.0, 0.0), "radiance": 1.0}
    roof = box((-0.07, -1.0, 0.1), (1.0, 1.0, 0.12))
    found = sampled([row], MATERIALS["diffuse"], 4000, 1, blocker=roof)[:, 0]
    assert 0.18 < (found > 0.0).mean() < 0.26


@pytest.mark.parametrize("lamp", ["sphere", "sun", "rectangle", "ellipse"])
def test_a_mirror_shows_the_lamp(lamp):
    """Every sample of a mirror that looks into the lamp is close to the lamp's radiance."""
    row = LAMPS[lamp] | {"radiance": 1.0, "position": (0.6, 0.0, 0.8)}
    total = sampled([row], glossy(1e-3, (1.0, 1.0, 1.0)), 500, 1)[:, 3]
    # One in a hundred samples of the lamp meets the lobe's tail; four standard errors are 0.018.
    assert abs(total.mean() - 1.0) < 0.01 and total.std() < 0.1


def test_a_perfect_mirror_shows_no_lamp_without_size():
    """As in Cycles: no light finds a point in a mirror."""
    row = {"kind": SPHERE, "position": (0.6, 0.0, 0.8)}
    assert not one(row, glossy(1e-8)).any()
    assert one(row, glossy(0.04)).any()


def test_without_multiple_importance_no_mirror_shows_a_lamp():
    """Its own samples are all there is, whole: gloss has the same mean (four standard errors), with
    more noise."""
    row = LAMPS["sphere"] | {"radiance": 1.0, "position": (0.6, 0.0, 0.8)}
    alone = row | {"seen_by": BY_DIFFUSE | BY_GLOSSY | NOT_BY_BSDF}
    assert not one(alone, glossy(1e-8)).any() and one(row, glossy(1e-8)).any()
    np.testing.assert_array_equal(one(alone), one(row))
    both, own = (sampled([lamp], MATERIALS["gloss"])[:, 3] for lamp in (row, alone))
    assert abs(own.mean() - both.mean()) < 4.0 * own.std() / math.sqrt(len(own))
    assert own.std() > 2.0 * both.std()


def test_shadows_end_at_the_lamp():
    """A box before the lamp hides it, behind it not; without shadows neither does."""
    lamp = {"kind": SPHERE, "position": (0.0, 0.0, 1.0)}
    free = one(lamp)
    assert free.any()
    between, behind = (
        box((-0.1, -0.1, 0.5), (0.1, 0.1, 0.6)),
        box((-0.1, -0.1, 1.0), (0.1, 0.1, 1.2)),
    )
    assert not one(lamp, blocker=between).any()
    np.testing.assert_array_equal(one(lamp, blocker=behind), free)
    np.testing.assert_array_equal(one(lamp | {"shadow": False}, blocker=between), free)
    assert not one({"kind": SUN}, blocker=behind).any()


def test_lamps_light_the_lobes_that_see_them():
    """Cycles' ray visibility: diffuse and glossy apart."""
    row = LAMPS["sphere"] | {"radiance": 1.0}
    both = sampled([row], MATERIALS["paint"], 20, 1)
    for seen_by, part in ((BY_DIFFUSE, slice(0, 3)), (BY_GLOSSY, slice(3, 6))):
        found = sampled([row | {"seen_by": seen_by}], MATERIALS["paint"], 20, 1)
        np.testing.assert_array_equal(found[:, part], both[:, part])
        found[:, part] = 0.0
        assert not found.any()


def test_lamps_that_make_no_sense_are_refused():
    """They would spread NaN over the picture."""
    for bad in ({"radiance": -1.0}, {"radiance": np.nan}, {"position": (0.0, np.inf, 0.0)}):
        with pytest.raises(ValueError, match="lamps must be finite"):
            make_lamps([{"kind": SUN} | bad])


def test_slanted_area_is_seen_from_the_side_of_its_axis():
    """By where its middle is, whichever side of its plane that is."""
    row = LAMPS["slanted rectangle"] | {"radiance": RADIANCE}
    away = row | {"axis": -SLANTED["axis"]}
    assert sampled([row], diffuse((0.8, 0.5, 0.3))).any()
    assert not sampled([away], diffuse((0.8, 0.5, 0.3))).any()
