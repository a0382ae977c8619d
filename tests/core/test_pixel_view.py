"""pixel_view.py: the maps are the light, the BSDF and the samples that the picture has."""

import numpy as np
import pytest

from iwis.core.settings import RenderSettings
from iwis.core.windows.pixel_view import draw_pixel_view, look_at_pixel, map_directions, map_texels
from support.scenes import make_picture, varied_scene

SETTINGS = {"pixel_filter": "CENTER", "max_samples": 32, "stop_rule": "FIXED"}


def test_texels_and_directions_are_inverse():
    """The direction of a texel's middle falls into that texel."""
    rows, columns = map_texels(map_directions(16), 16)
    expected = np.divmod(np.arange(16 * 32), 32)
    np.testing.assert_array_equal((rows, columns), expected)


@pytest.mark.parametrize("pixel", [(20, 14), (12, 10)])
def test_a_view_tells_the_pixel_of_the_picture(pixel):
    """Count and visible share are the rendered pixel's; the product's integral is its light.

    The picture learns of visibility from neighbours, the view does not: their samples differ.
    """
    x, y = pixel
    layers, _ = make_picture(varied_scene(), **SETTINGS)
    view = look_at_pixel(varied_scene(), RenderSettings(**SETTINGS), x, y, 128)
    assert view.count == layers["samples"][y, x, 0]
    seen = (~view.occluded).sum() / view.count
    assert seen == pytest.approx(
        layers["visibility"][y, x, 0],
        abs=0.15,  # 1.7 sigma of 32 samples; inverted: .27 or more
    )
    np.testing.assert_allclose(view.position, layers["position"][y, x], atol=1e-5)
    altitude = np.pi * ((np.arange(128) + 0.5) / 128 - 0.5)
    solid_angle = np.cos(altitude)[:, None, None] * (np.pi / 128) ** 2
    unoccluded = (view.product * solid_angle).sum(axis=(0, 1))
    # 32 samples of a product that is sampled nearly exactly; the map's texels are 1.4 degrees
    np.testing.assert_allclose(unoccluded, layers["unoccluded"][y, x], rtol=0.15)


def test_samples_lie_where_the_product_is():
    """No direction carries less than a hundredth of the mean: nothing is sent below the surface."""
    view = look_at_pixel(varied_scene(), RenderSettings(**SETTINGS), 20, 14, 64)
    rows, columns = map_texels(view.directions, 64)
    assert (view.product[rows, columns].max(axis=1) > 0.0).mean() > 0.9
    assert len(view.directions) <= view.count == 32


def test_a_pixel_of_very_many_samples_shows_each_once():
    """More than are put in order at once (sample_order.py)."""
    settings = RenderSettings(**SETTINGS | {"max_samples": 20_000})
    view = look_at_pixel(varied_scene(), settings, 20, 14, 64)
    assert view.count == 20_000 and len(view.directions) > 0.9 * view.count
    assert len(np.unique(view.directions, axis=0)) > 0.999 * len(view.directions)


def test_the_picture_has_both_colors_of_dots():
    """Red ones of the samples that saw light, blue ones of the others, four maps in a frame."""
    view = look_at_pixel(varied_scene(), RenderSettings(**SETTINGS), 20, 14, 64)
    view = view._replace(occluded=np.arange(len(view.occluded)) % 2 == 0)
    picture = draw_pixel_view(view)
    assert picture.shape == (136, 264, 4) and picture.min() >= 0.0 and picture.max() <= 1.0
    dots = picture[:64, -128:, :3]
    assert ((dots[..., 0] > 0.99) & (dots[..., 2] < 0.1)).any()
    assert ((dots[..., 2] > 0.99) & (dots[..., 0] < 0.2)).any()


def test_a_pixel_without_an_object_is_named():
    """So is one outside the frame."""
    with pytest.raises(ValueError, match=r"\(0, 27\) shows no object"):
        look_at_pixel(varied_scene(), RenderSettings(**SETTINGS), 0, 27)
    with pytest.raises(ValueError, match="outside the frame"):
        look_at_pixel(varied_scene(), RenderSettings(**SETTINGS), 40, 0)
