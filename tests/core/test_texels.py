"""core/textures/texels.py: images looked up, against a texel after another in Python."""

import numpy as np
import pytest

from iwis.core.textures.texels import EXTENSIONS, INTERPOLATIONS, look_up

HEIGHT, WIDTH = 3, 5


def _image(rng, dtype):
    if dtype == np.uint8:
        return rng.integers(0, 256, (HEIGHT, WIDTH, 4), np.uint8)
    return rng.uniform(0.0, 3.0, (HEIGHT, WIDTH, 4)).astype(np.float32)


def _looked_up(image, u, v, interpolation, extension):
    out = np.full((len(u), 4), np.nan, np.float32)
    scale = np.float32(1.0 / 255.0 if image.dtype == np.uint8 else 1.0)
    codes = INTERPOLATIONS[interpolation], EXTENSIONS[extension]
    look_up(image, np.float32(u), np.float32(v), *codes, scale, out)
    return out


def _texel(image, column, row, extension):
    if extension == "REPEAT":
        return image[row % HEIGHT, column % WIDTH]
    if extension == "MIRROR":
        column, row = column % (2 * WIDTH), row % (2 * HEIGHT)
        return image[min(row, 2 * HEIGHT - 1 - row), min(column, 2 * WIDTH - 1 - column)]
    if extension == "EXTEND" or (0 <= row < HEIGHT and 0 <= column < WIDTH):
        return image[min(max(row, 0), HEIGHT - 1), min(max(column, 0), WIDTH - 1)]
    return np.zeros(4)


def _b_spline(distance):
    """The uniform cubic one."""
    a = abs(distance)
    return 2 / 3 - a * a + a**3 / 2 if a < 1.0 else max(2.0 - a, 0.0) ** 3 / 6


def _tent(distance):
    return max(1.0 - abs(distance), 0.0)


def _box(distance):
    return float(-0.5 <= distance < 0.5)


KERNELS = {"Closest": _box, "Linear": _tent, "Cubic": _b_spline, "Smart": _b_spline}


def _expected(image, u, v, interpolation, extension):
    """Each texel weighs by a kernel of the way from its centre."""
    weight, total = KERNELS[interpolation], np.zeros(4)
    x, y = np.float64(np.float32(u)) * WIDTH, np.float64(np.float32(v)) * HEIGHT
    for row in range(int(np.floor(y)) - 2, int(np.floor(y)) + 3):
        for column in range(int(np.floor(x)) - 2, int(np.floor(x)) + 3):
            w = weight(column + 0.5 - x) * weight(row + 0.5 - y)
            if w > 0.0:
                total += w * _texel(image, column, row, extension)
    return total / 255.0 if image.dtype == np.uint8 else total


@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
@pytest.mark.parametrize("extension", EXTENSIONS)
@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_texels_weigh_by_the_way_to_their_centres(dtype, extension, interpolation, rng):
    image = _image(rng, dtype)
    u, v = places = rng.uniform(-2.5, 3.5, (2, 300))
    expected = [_expected(image, *place, interpolation, extension) for place in places.T]
    found = _looked_up(image, u, v, interpolation, extension)
    np.testing.assert_allclose(found, expected, atol=2e-5)  # float32 places, 1e-6 of a texel


@pytest.mark.parametrize("extension", EXTENSIONS)
@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_places_that_are_none_bring_some_texel(extension, interpolation, rng):
    image = _image(rng, np.float32)
    u = np.float32([np.nan, np.inf, -np.inf, 1e30, -1e9])
    found = _looked_up(image, u, u[::-1].copy(), interpolation, extension)
    assert np.isfinite(found).all()
    assert found.max() <= image.max() * 1.0001


def test_clipped_images_end_at_their_border(rng):
    image = _image(rng, np.float32)
    outside = np.float32([-0.5, 1.5, 0.5, 0.5]), np.float32([0.5, 0.5, -0.5, 1.5])
    for interpolation in INTERPOLATIONS:
        assert not _looked_up(image, *outside, interpolation, "CLIP").any()
