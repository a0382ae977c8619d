"""core/walks/subsurface.py: what artists say of a medium, as walks want it."""

import numpy as np
import pytest

from iwis.core.walks.subsurface import LEGACY, SKIN, VAN_DE_HULST, Media, medium_of

_RADIUS = np.float32([0.01, 0.02, 0.05])


def _extinction(method, g):
    """float64 (3,), of a medium of three radii."""
    numbers = (np.full(1, value, np.float32) for value in (g, 1.4, 1.0))
    color = np.full((1, 3), 0.5, np.float32)
    media = Media(color, _RADIUS[None], *numbers, np.full(1, method, np.int8))
    return medium_of(media).extinction[0].astype(np.float64)


def test_extinction_is_one_over_the_free_path():
    """The radius itself, or a quarter of it over pi; 1e-6 is float32's."""
    np.testing.assert_allclose(_extinction(VAN_DE_HULST, 0.0), 1.0 / _RADIUS, rtol=1e-6)
    np.testing.assert_allclose(_extinction(LEGACY, 0.0), 4.0 * np.pi / _RADIUS, rtol=1e-6)


@pytest.mark.parametrize("method", [LEGACY, SKIN])
@pytest.mark.parametrize("g", [0.3, 0.8])
def test_what_scatters_forwards_scatters_more_often(method, g):
    """As in Cycles: 1 / (1 - g) times, so that light gets as far. The new method takes the radius
    as it is, and so do all where light is scattered backwards."""
    even = _extinction(method, 0.0)
    np.testing.assert_allclose(_extinction(method, g), even / (1.0 - g), rtol=1e-6)
    np.testing.assert_allclose(_extinction(method, -g), even, rtol=1e-6)
    new = _extinction(VAN_DE_HULST, 0.0)
    np.testing.assert_allclose(_extinction(VAN_DE_HULST, g), new, rtol=1e-6)
