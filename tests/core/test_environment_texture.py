"""core/nodes/images.environment_texture: a map on a surface, beside the same map as a world."""

import numpy as np
import pytest

from iwis.core.data.program import ImageTiles
from iwis.core.light.environment import eval_environment_many, make_lookup
from iwis.core.nodes.images import environment_texture
from iwis.core.scene import CLOSEST, EQUIRECTANGULAR, LINEAR, MIRROR_BALL, EnvironmentMap

HEIGHT, WIDTH = 16, 32


class _Points:
    """As much of a Context as the node asks for."""

    def __init__(self, position):
        self.position = position

    def __len__(self):
        return len(self.position)


def _color(texels, projection, interpolation, context, inputs):
    rgba = np.concatenate([texels, np.ones((HEIGHT, WIDTH, 1), np.float32)], -1)
    settings = {
        "image": ImageTiles({(0, 0): rgba}, False),
        "interpolation": interpolation,
        "extension": "REPEAT",
        "projection": projection,
        "tiled": False,
        "unassociate": False,
    }
    return environment_texture(context, settings, inputs)["Color"]


@pytest.mark.parametrize("projection", [EQUIRECTANGULAR, MIRROR_BALL])
@pytest.mark.parametrize("interpolation", ["Closest", "Linear"])
def test_a_direction_has_the_color_of_the_world(projection, interpolation, rng):
    """However long the vector is. Within a row of the pole a linear map of a surface goes on at the
    other pole (it repeats), as in Cycles: such directions are left out. At most one in 100 lies so
    near a texel's edge that rounding decides."""
    texels = rng.uniform(0.0, 1.0, (HEIGHT, WIDTH, 3)).astype(np.float32)
    wi = rng.normal(size=(2000, 3))
    wi /= np.linalg.norm(wi, axis=1)[:, None]
    wi = np.float32(wi[np.abs(wi[:, 2]) < np.cos(np.pi / HEIGHT)])
    known = CLOSEST if interpolation == "Closest" else LINEAR
    world = EnvironmentMap(radiance=texels, projection=projection, interpolation=known)
    expected = np.empty((len(wi), 3), np.float32)
    eval_environment_many(make_lookup(world), wi, expected)
    inputs = {"Vector": wi * np.float32(3.0)}
    found = _color(texels, projection, interpolation, _Points(np.zeros_like(wi)), inputs)
    near = np.abs(found - expected).max(axis=1) < 2e-4
    assert near.mean() > 0.99


def test_without_a_vector_it_is_the_place(rng):
    """As seen from the origin."""
    texels = rng.uniform(0.0, 1.0, (HEIGHT, WIDTH, 3)).astype(np.float32)
    place = np.float32(rng.normal(size=(50, 3)) * 4.0)
    given = texels, EQUIRECTANGULAR, "Linear", _Points(place)
    np.testing.assert_array_equal(_color(*given, {}), _color(*given, {"Vector": place}))


def test_no_direction_is_the_corner(rng):
    """Of a vector of no length Cycles shows the map's first texel."""
    texels = rng.uniform(0.0, 1.0, (HEIGHT, WIDTH, 3)).astype(np.float32)
    nowhere = np.zeros((1, 3), np.float32)
    found = _color(texels, EQUIRECTANGULAR, "Closest", _Points(nowhere), {})
    np.testing.assert_array_equal(found, texels[:1, 0])
