"""The world's lookup against its formulas in float64, one texel at a time."""

import math

import numpy as np
import pytest

from iwis.core._jit import kernel
from iwis.core.light.environment import (
    eval_environment,
    eval_environment_many,
    fast_atan2,
    make_lookup,
    srgb_decode,
    srgb_encode,
)
from iwis.core.scene import (
    CLOSEST,
    EQUIRECTANGULAR,
    LINEAR,
    LINEAR_SRGB,
    MIRROR_BALL,
    EnvironmentMap,
)

HEIGHT, WIDTH = 6, 12


@kernel
def _atan2_many(y, x, out):
    for i in range(len(out)):
        out[i] = fast_atan2(y[i], x[i])


@kernel
def _decode_many(encoded, out):
    for i in range(len(out)):
        out[i] = srgb_decode(encoded[i])


def coordinates(direction, projection):
    """(u, v) of a direction in float64, from the module's docstring."""
    x, y, z = (float(c) for c in direction / np.linalg.norm(direction))
    if projection == EQUIRECTANGULAR:
        return 0.5 - math.atan2(y, x) / (2 * math.pi), 0.5 + math.asin(z) / math.pi
    s = math.sqrt((1.0 - y) / 2.0)
    return 0.5 + x / (4 * s), 0.5 + z / (4 * s)


def decoded(value):
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def radiance_at(environment, direction):
    """The lookup, slow and obvious."""
    texels = environment.radiance.astype(float)
    height, width, _ = texels.shape
    u, v = coordinates(environment.world_to_map @ [*direction, 1.0], environment.projection)
    if environment.interpolation == CLOSEST:
        return texels[int(v * height) % height, int(u * width) % width]
    if environment.interpolation == LINEAR_SRGB:
        texels = srgb_encode(environment.radiance).astype(float)
    s, t = u * width - 0.5, v * height - 0.5
    total = np.zeros(3)
    for i in (math.floor(t), math.floor(t) + 1):
        for j in (math.floor(s), math.floor(s) + 1):
            weight = (1.0 - abs(t - i)) * (1.0 - abs(s - j))
            total += weight * texels[i % height, j % width]
    total = decoded(total) if environment.interpolation == LINEAR_SRGB else total
    return total * environment.strength


def some_map(rng, **values):
    return EnvironmentMap(radiance=rng.random((HEIGHT, WIDTH, 3), np.float32), **values)


def some_directions(rng, n):
    d = rng.normal(size=(n, 3))
    return (d / np.linalg.norm(d, axis=1, keepdims=True)).astype(np.float32)


def looked_up(environment, directions):
    out = np.empty_like(directions)
    eval_environment_many(make_lookup(environment), directions, out)
    return out


@pytest.mark.parametrize("interpolation", [LINEAR, LINEAR_SRGB])
@pytest.mark.parametrize("projection", [EQUIRECTANGULAR, MIRROR_BALL])
def test_lookup_equals_the_formulas(rng, projection, interpolation):
    """With a matrix that turns, stretches and moves, and a strength for each channel."""
    matrix = np.column_stack([np.eye(3) + 0.3 * rng.random((3, 3)), [0.1, -0.2, 0.1]])
    environment = some_map(
        rng,
        projection=projection,
        interpolation=interpolation,
        world_to_map=matrix.astype(np.float32),
        strength=np.array([0.5, 1.0, 2.0], np.float32),
    )
    directions = some_directions(rng, 2000)
    expected = [radiance_at(environment, d) for d in directions]
    # u and v are off by 2e-7, which is 2e-6 texels at a slope of 2 a texel; near a singularity
    # of the projection by 50 times that.
    np.testing.assert_allclose(looked_up(environment, directions), expected, rtol=0, atol=2e-4)


@pytest.mark.parametrize("projection", [EQUIRECTANGULAR, MIRROR_BALL])
def test_closest_takes_the_texel_that_the_coordinate_lies_in(rng, projection):
    environment = some_map(rng, projection=projection, interpolation=CLOSEST)
    directions = some_directions(rng, 2000)
    uv = np.array([coordinates(d.astype(float), projection) for d in directions])
    inside = np.abs(uv * (WIDTH, HEIGHT) % 1.0 - 0.5).max(axis=1) < 0.4999  # not on a border
    expected = [radiance_at(environment, d) for d in directions[inside]]
    np.testing.assert_array_equal(looked_up(environment, directions)[inside], expected)


def test_linear_is_the_texel_at_its_centre(rng):
    """u = (j + 1/2) / w, v = (i + 1/2) / h; row 0 looks along -z."""
    environment = some_map(rng)
    i, j = np.indices((HEIGHT, WIDTH))
    phi = (0.5 - (j + 0.5) / WIDTH) * 2 * np.pi
    latitude = ((i + 0.5) / HEIGHT - 0.5) * np.pi
    directions = np.stack(
        [np.cos(latitude) * np.cos(phi), np.cos(latitude) * np.sin(phi), np.sin(latitude)], -1
    )
    ours = looked_up(environment, directions.reshape(-1, 3).astype(np.float32))
    # The coordinates' 2e-7 times 12 texels.
    np.testing.assert_allclose(ours.reshape(HEIGHT, WIDTH, 3), environment.radiance, atol=5e-6)


def test_length_of_the_direction_does_not_matter(rng):
    directions = some_directions(rng, 100)
    environment = some_map(rng)
    for factor in (1e-12, 1e-3, 1e3, 1e12):
        scaled = (directions * np.float32(factor)).astype(np.float32)
        # The last bit of the scaled directions, 6e-8 of the coordinates, times 12 texels.
        np.testing.assert_allclose(
            looked_up(environment, scaled), looked_up(environment, directions), atol=1e-5
        )


@pytest.mark.parametrize("interpolation", [LINEAR, CLOSEST, LINEAR_SRGB])
@pytest.mark.parametrize("projection", [EQUIRECTANGULAR, MIRROR_BALL])
@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (4, 1), (3, 7)])
def test_no_direction_leaves_the_map(rng, projection, interpolation, shape):
    """Axes, poles, seam, zero, tiny, huge, NaN and infinity: always a mix of texels."""
    special = (0.0, -0.0, 1.0, -1.0, 1e-30, -1e-30, 1e30, np.nan, np.inf, -np.inf, 0.3)
    grid = np.stack(np.meshgrid(special, special, special), -1).reshape(-1, 3)
    radiance = 0.25 + 0.5 * rng.random((*shape, 3), np.float32)
    environment = EnvironmentMap(
        radiance=radiance, projection=projection, interpolation=interpolation
    )
    ours = looked_up(environment, grid.astype(np.float32))
    assert ours.min() > 0.2499 and ours.max() < 0.7501


@pytest.mark.parametrize("projection", [EQUIRECTANGULAR, MIRROR_BALL])
def test_directions_near_an_axis_stay_in_the_map(rng, projection):
    """Where a mirror ball's formula is a quotient of two roundings: still the texels' formula."""
    axis = np.repeat([[0.0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1], [1, 0, 0]], 400, 0)
    off = rng.normal(size=axis.shape) * 10.0 ** rng.uniform(-8, -2, (len(axis), 1))
    directions = (axis + off).astype(np.float32)
    environment = some_map(rng, projection=projection)
    ours = looked_up(environment, directions)
    assert ours.min() >= 0.0 and ours.max() <= 1.0
    away = np.abs(off).max(1) > 1e-3 if projection == MIRROR_BALL else np.abs(off).max(1) > 1e-5
    near_minus_y = axis[:, 1] < 0.0  # the rim, where all directions are one
    some = directions[away & ~near_minus_y]
    expected = [radiance_at(environment, d) for d in some]
    np.testing.assert_allclose(looked_up(environment, some), expected, rtol=0, atol=2e-3)


def test_zero_vector_is_looked_up_at_zero(rng):
    """As in Cycles: the corner where four texels meet."""
    environment = some_map(rng)
    corner = environment.radiance[[0, 0, -1, -1], [0, -1, 0, -1]].mean(axis=0)
    ours = looked_up(environment, np.zeros((1, 3), np.float32))
    np.testing.assert_allclose(ours[0], corner, rtol=1e-6)


def test_one_lookup_equals_many(rng):
    environment = some_map(rng)
    directions = some_directions(rng, 50)
    lookup = make_lookup(environment)
    single = [eval_environment(lookup, *d) for d in directions]
    assert all(isinstance(value, float) for value in single[0])
    np.testing.assert_array_equal(np.float32(single), looked_up(environment, directions))


def test_fast_atan2_is_accurate(rng):
    """6e-7 rad: the polynomial's 2.5e-7 and two roundings near pi."""
    angle = np.concatenate([np.linspace(-np.pi, np.pi, 20001), rng.uniform(-3.2, 3.2, 20000)])
    radius = 10.0 ** rng.uniform(-10, 10, len(angle))
    y, x = (radius * np.sin(angle)).astype(np.float32), (radius * np.cos(angle)).astype(np.float32)
    out = np.empty_like(x)
    _atan2_many(y, x, out)
    error = np.abs(out - np.arctan2(y.astype(float), x.astype(float)))
    assert np.minimum(error, 2 * np.pi - error).max() < 6e-7  # -0 and +0 differ by a turn


def test_srgb_encode_and_decode_are_inverse(rng):
    """And equal the standard's formula; above 1 as well."""
    linear = np.concatenate([rng.random(1000), 10 * rng.random(100), [0, 1, 0.0031308]])
    linear = linear.astype(np.float32)
    out = np.empty_like(linear)
    _decode_many(srgb_encode(linear), out)
    # powf: two units in the last place, and the encoding's rounding times 2.4; at the joint of the
    # two pieces the standard itself leaves 1e-4 of its value.
    np.testing.assert_allclose(out, linear, rtol=2e-6, atol=1e-6)
    np.testing.assert_allclose(out, decoded(srgb_encode(linear).astype(float)), rtol=2e-6)


def test_lookup_shares_the_texels():
    """A map of an eighth of a gigabyte is not copied."""
    environment = EnvironmentMap(radiance=np.ones((4, 8, 3), np.float32))
    assert make_lookup(environment).texels is environment.radiance
