"""Lamps with a picture on them: what points see of it, by analytic means."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.lamps import (
    BY_CAMERA,
    BY_DIFFUSE,
    BY_GLOSSY,
    DISC,
    ELLIPSE,
    RECTANGLE,
    SPHERE,
    make_lamps,
)
from support.lamp_points import sampled
from support.lamp_rows import area
from support.scenes import (
    camera_above,
    constant_world,
    diffuse,
    floor,
    glossy,
    make_picture,
    make_scene,
)

DOWN = np.eye(3)  # an area that shines along -z, its right is x and its up is y
WHITE = diffuse((1.0, 1.0, 1.0))
RED, BLUE = np.float32([1.0, 0.0, 0.0]), np.float32([0.0, 0.0, 1.0])


def with_picture(rows, picture):
    """Lamps of which the last one shows a picture, float32 (h, w, 3)."""
    height, width, _ = picture.shape
    rows = [*rows[:-1], rows[-1] | {"picture": (0, width, height, 0)}]
    return make_lamps(rows)._replace(texels=picture.reshape(-1, 3))


def halves(width=64, height=8):
    """Red on the left, blue on the right."""
    picture = np.empty((height, width, 3), np.float32)
    picture[:, : width // 2], picture[:, width // 2 :] = RED, BLUE
    return picture


def spotlight(half_angle, **fields):
    """A point of 1 W/sr 2 m above the origin, its cone about -z."""
    edge = np.cos(half_angle)
    row = {"kind": SPHERE, "position": (0.0, 0.0, 2.0), "to_cone": np.eye(3), "radiance": 1.0}
    return row | {"cone": (edge, 1e30)} | fields


ROWS = {
    "panel": area(RECTANGLE, (0.3, 0.1, 1.5), 0.8, 0.5, DOWN, radiance=(2.0, 1.0, 0.5)),
    "ellipse": area(ELLIPSE, (0.3, 0.1, 1.5), 0.8, 0.5, DOWN, radiance=(2.0, 1.0, 0.5)),
    "ball": {"kind": SPHERE, "position": (0.3, 0.1, 1.5), "size": (0.2, 0.0), "radiance": 2.0},
    "soft": {"kind": DISC, "position": (0.3, 0.1, 1.5), "size": (0.2, 0.0), "radiance": 2.0},
    "spot": spotlight(0.5),
    "wide spot": spotlight(1.5),
}


@pytest.mark.parametrize("name", ROWS)
@pytest.mark.parametrize("material", [WHITE, glossy(0.05)], ids=["matte", "gloss"])
def test_a_white_picture_changes_nothing(name, material):
    """Sample by sample: the sum of a texel's weights is 1 but for rounding."""
    plain = sampled([ROWS[name]], material, pixels=200)
    white = np.ones((5, 7, 3), np.float32)
    dressed = sampled([], material, pixels=200, lamps=with_picture([ROWS[name]], white))
    np.testing.assert_allclose(dressed, plain, rtol=1e-5)
    assert plain.any()


def test_each_lamp_has_its_own_picture():
    """Texels of the second begin where its row says; the first one has none."""
    rows = [ROWS["ball"], ROWS["panel"]]
    picture = np.full((2, 2, 3), 0.5, np.float32)
    lamps = with_picture(rows, picture)
    texels = np.concatenate([np.full((9, 3), 77.0, np.float32), lamps.texels])
    lamps.picture[1, 0] = 9
    whole = sampled([], WHITE, lamps=lamps._replace(texels=texels), pixels=200)
    apart = [sampled([], WHITE, lamps=lamps.at([k])._replace(texels=texels)) for k in (0, 1)]
    for k, factor in ((0, 1.0), (1, 0.5)):
        plain = sampled([rows[k]], WHITE)
        np.testing.assert_allclose(apart[k].mean(0), factor * plain.mean(0), rtol=1e-5)
    assert whole.any()


def test_halves_of_a_panel_light_by_their_form_factor():
    """The origin sees the red half as a panel of its own, beside the blue one."""
    row = area(RECTANGLE, (0.0, 0.0, 1.0), 1.0, 1.0, DOWN, radiance=1.0)
    light = sampled([], WHITE, lamps=with_picture([row], halves())).mean(0)[:3]
    left = area(RECTANGLE, (-0.25, 0.0, 1.0), 0.5, 1.0, DOWN, radiance=1.0)
    alone = sampled([left], WHITE).mean(0)[0]
    # Texels beside the middle, a 32nd of the picture, are mixed, on both sides alike.
    np.testing.assert_allclose(light, (alone, 0.0, alone), rtol=0.02)


@pytest.mark.parametrize("kind", ["ball", "point", "soft"])
def test_the_side_towards_a_point_is_what_it_sees(kind):
    """Around a lamp u goes round its up axis: half of the map is seen from below."""
    size = {"ball": 0.05, "soft": 0.05}.get(kind, 0.0)
    shape = DISC if kind == "soft" else SPHERE
    frame = {"forward": (0.0, -1.0, 0.0), "right": (1.0, 0.0, 0.0), "up": (0.0, 0.0, 1.0)}
    row = {"kind": shape, "position": (0.0, 0.0, 2.0), "size": (size, 0.0), "radiance": 1.0} | frame
    # Seen from below: along -up. u = (1 - atan2(right, up) / pi) / 2: 0 and 1 there.
    picture = np.zeros((16, 64, 3), np.float32)
    picture[:, :16], picture[:, 48:], picture[:, 16:48] = RED, RED, BLUE
    light = sampled([], WHITE, lamps=with_picture([row], picture)).mean(0)[:3]
    plain = sampled([row], WHITE).mean(0)[0]
    # At a ball's horizon a texel is mixed with the next: a 64th of what is seen, at a slant.
    np.testing.assert_allclose(light, plain * RED, atol=0.01 * plain if kind == "ball" else 1e-6)


@pytest.mark.parametrize("half_angle", [0.4, 1.0])
def test_a_spot_throws_its_picture(half_angle):
    """On the floor the picture is as wide as the cone; x to the right, y up."""
    picture = np.zeros((64, 64, 3), np.float32)
    picture[:, 48:], picture[48:, :, 1] = RED, 1.0
    lamps = with_picture([spotlight(half_angle)], picture)
    wide = 2.0 * np.tan(half_angle)
    scene = make_scene(
        [floor(2.0 * wide)],
        [WHITE],
        constant_world((0.0, 0.0, 0.0)),
        camera_above(32, 32, half=wide),
        lamps=lamps,
    )
    layers, _ = make_picture(scene, max_samples=1, stop_rule="FIXED")
    light = layers["combined"][..., :3]
    x = (np.arange(32) + 0.5) / 16.0 - 1.0
    inside = np.hypot(*np.meshgrid(x, x)) < 1.0
    red, green = light[..., 0] > 1e-4, light[..., 1] > 1e-4
    np.testing.assert_array_equal(red, inside & (x > 0.5)[None, :])
    np.testing.assert_array_equal(green, inside & (x > 0.5)[:, None])


@pytest.mark.parametrize("by_direction", [True, False])
def test_a_ball_in_a_spot_shows_by_place_or_by_direction(by_direction):
    """All its rays to a point go to one half of the plane; of its ball both halves are seen."""
    row = spotlight(0.4, size=(0.1, 0.0), position=(0.3, 0.0, 2.0), forward=(0.0, 0.0, -1.0))
    row |= {"right": (1.0, 0.0, 0.0), "up": (0.0, 1.0, 0.0)}
    lamps = with_picture([row], halves(64, 64))
    lamps.picture[0, 3] = by_direction
    share = sampled([], WHITE, lamps=lamps).mean(0)[:3] / sampled([row], WHITE).mean(0)[0]
    # Of a half of the ball, its edge turned away by t, (1 - sin t) / 2 of the disc is seen.
    half = 0.5 * (1.0 - np.sin(np.arctan(0.15)))
    expected = (1.0, 0.0, 0.0) if by_direction else (half, 0.0, 1.0 - half)
    # 16 000 samples of a half: 0.004; the texels at the edge are mixed, on both sides alike.
    np.testing.assert_allclose(share, expected, atol=0.02)


def test_a_seen_panel_shows_its_picture():
    """Upright to who looks at it along its axis from its front."""
    up = np.diag([1.0, -1.0, -1.0])  # shines upwards; its up is -y
    row = area(RECTANGLE, (0.0, 0.0, 1.0), 1.0, 1.0, up, radiance=1.0)
    lamps = with_picture([row | {"seen_by": BY_DIFFUSE | BY_GLOSSY | BY_CAMERA}], halves())
    scene = make_scene([floor(2.0)], [WHITE], constant_world((0.0, 0.0, 0.0)), camera_above(18, 18))
    layers, _ = make_picture(dataclasses.replace(scene, lamps=lamps), max_samples=1)
    seen = layers["emission"][9]
    np.testing.assert_allclose(seen[5], RED, atol=1e-5)
    np.testing.assert_allclose(seen[12], BLUE, atol=1e-5)
    assert not seen[1].any()
