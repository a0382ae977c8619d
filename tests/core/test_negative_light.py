"""Light below 0, which filters leave round the sun of many an HDRI, takes away, as in Cycles."""

import numpy as np
import pytest

from iwis.core.bsdf.luminance import luminance, magnitude
from iwis.core.light.environment import make_lookup, srgb_encode, takes_away
from iwis.core.light.light_tree import build_pyramid
from iwis.core.render_cache import RenderCache
from iwis.core.scene import CLOSEST, EnvironmentMap
from support.light_leaves import light_weights
from support.scenes import (
    camera_above,
    constant_world,
    diffuse,
    floor,
    glossy,
    gradient_world,
    make_picture,
    make_scene,
)

DAY, NIGHT = (1.0, 0.5, 2.0), (-0.5, 0.25, -0.25)
MEAN = np.add(DAY, NIGHT) / 2.0


def half_world(**fields) -> EnvironmentMap:
    """DAY from one side of the meridian, NIGHT from the other."""
    radiance = np.full((16, 32, 3), DAY, np.float32)
    radiance[:, :16] = NIGHT
    return EnvironmentMap(radiance=radiance, interpolation=CLOSEST, **fields)


def floor_under(world, material=None, **settings):
    """float64 (3,): the mean of a floor's picture."""
    scene = make_scene([floor()], [material or diffuse((0.8, 0.8, 0.8))], world, camera_above())
    layers, _ = make_picture(scene, stop_rule="FIXED", max_samples=256, **settings)
    return layers["combined"][..., :3].mean((0, 1), dtype=np.float64)


def test_magnitude_is_the_luminance_of_what_is_positive(rng):
    """To the last bit, and 0 of black alone."""
    for color in rng.random((50, 3)).astype(np.float32):
        assert magnitude(*color) == luminance(*color) == magnitude(*(-color))
    assert magnitude(*np.float32([-1.0, luminance(1, 0, 0) / luminance(0, 1, 0), 0.0])) > 0.1


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_tree_holds_what_takes_away(sign, rng):
    """Its samples' mean is the light with its sign; no weight is above 8, the tree's own bound.

    1 %: 5 standard errors of 200 000 samples whose weights spread by .9.
    """
    lookup = make_lookup(half_world(strength=np.full(3, sign, np.float32)))
    pyramid = build_pyramid(lookup)
    weights = light_weights(pyramid, lookup, 200_000, rng)
    assert weights.mean() == pytest.approx(sign * luminance(*MEAN), rel=0.01)
    assert np.abs(weights).max() < 8.0 * pyramid.averages[0]
    assert pyramid.averages[0] == pytest.approx(
        (magnitude(*DAY) + magnitude(*NIGHT)) / 2.0, rel=1e-4
    )


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BLACKMAN_HARRIS"])
def test_a_floor_has_the_sum(pixel_filter):
    """Half a sky of either: its albedo times their mean. 1 %: 65 536 samples that spread by 1."""
    found = floor_under(half_world(), pixel_filter=pixel_filter)
    np.testing.assert_allclose(found, 0.8 * MEAN, rtol=0.01)


def test_a_dark_sky_makes_pictures_negative():
    """In gloss as well; where nothing but negative light is, no sample is dropped."""
    world = constant_world((-1.0, -0.5, -2.0))
    np.testing.assert_allclose(floor_under(world), [-0.8, -0.4, -1.6], rtol=1e-3)
    turned = constant_world((1.0, 0.5, 2.0))
    shiny = floor_under(world, glossy(0.2)), floor_under(turned, glossy(0.2))
    np.testing.assert_allclose(shiny[0], -shiny[1], rtol=1e-6)


def test_mode_paper_counts_it_as_dark(table_dir):
    """Its tables are of light that adds: half of DAY's sky. 3 %: 5 % of the coefficients."""
    found = floor_under(half_world(), estimator="PAPER", cache_dir=table_dir)
    green = 0.8 * np.float64([DAY[0], DAY[1] + NIGHT[1], DAY[2]]) / 2.0
    np.testing.assert_allclose(found, green, rtol=0.03)


def test_a_negative_strength_keeps_the_tree():
    """Of the world with the other sign, as strong as it."""
    worlds = (gradient_world(strength=np.full(3, s, np.float32)) for s in (3.0, -3.0))
    light, turned = (RenderCache().light(world).pyramid for world in worlds)
    np.testing.assert_array_equal(light.averages, turned.averages)
    assert light.averages.min() > 0.0


def test_srgb_encodes_a_line_below_zero():
    """As the decoder reads it; without a warning of NumPy's."""
    np.testing.assert_array_equal(
        srgb_encode(np.float32([-1.0, -0.5])), np.float32([-12.92, -6.46])
    )


def ringing_world(taken):
    """A sun of one texel in a grey sky, and round it ``taken`` of its light below 0."""
    radiance = np.full((64, 128, 3), 0.3, np.float32)
    radiance[47:50, 50:53] = -taken * 3000.0 / 8.0
    radiance[48, 51] = 3000.0
    return EnvironmentMap(radiance=radiance)


def test_a_little_below_zero_does_not_count():
    """Below .5 % of all light; the cache tells of the last world."""
    cache = RenderCache()
    for taken, counts in ((0.1, True), (0.003, False), (0.02, True), (0.0, False)):
        world = ringing_world(taken)
        assert takes_away(world) == counts
        cache.light(world)
        assert cache.takes_away == counts


def test_counts_do_not_follow_a_pixels_luck():
    """PERCEPTUAL has the brightness of FIXED; where pixels end by their own samples, 1 % more.

    .6 %: four standard errors of six pictures whose means spread by .35 %.
    """
    scene = make_scene([floor()], [diffuse()], ringing_world(0.15), camera_above(32, 32))
    own = {"pixel_filter": "BLACKMAN_HARRIS", "max_samples": 256}

    def light(rule, seed):
        layers, _ = make_picture(scene, stop_rule=rule, seed=seed, **own)
        return layers["combined"][..., :3].mean(dtype=np.float64)

    truth = light("FIXED", 99)
    found = np.mean([light("PERCEPTUAL", seed) for seed in range(6)])
    assert found == pytest.approx(truth, rel=0.006)
