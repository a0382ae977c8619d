"""core/film.py: tiles come together to one picture."""

import numpy as np

from iwis.core.film import LAYERS, Film, Progress, Tile, new_layers


def test_new_layers_have_their_channels_and_are_zero():
    """Every layer of the table, float32 (height, width, channels)."""
    layers = new_layers(5, 3)
    assert {name: layer.shape for name, layer in layers.items()} == {
        name: (3, 5, channels) for name, channels in LAYERS.items()
    }
    assert all(layer.dtype == np.float32 and not layer.any() for layer in layers.values())


def test_film_puts_tiles_where_they_belong(rng):
    """Tiles are placed in the frame; a film of a region starts at the region's corner."""
    whole = {name: rng.random((6, 9, n), np.float32) for name, n in LAYERS.items()}
    film = Film((10, 20, 19, 26))
    for x, width in ((0, 4), (4, 5)):
        for y, height in ((0, 5), (5, 1)):
            part = {k: a[y : y + height, x : x + width] for k, a in whole.items()}
            film.write_tile(Tile(10 + x, 20 + y, width, height, part))
    for name, layer in whole.items():
        np.testing.assert_array_equal(film.layers[name], layer)


def test_film_is_a_sink_that_never_cancels():
    """It takes progress and says nothing."""
    film = Film((0, 0, 2, 2))
    film.progress(Progress(phase="bvh", fraction=0.5))
    assert film.cancelled() is False
