"""import iwis: what a script sets and renders, as arrays."""

import bpy
import numpy as np
import pytest

import iwis
from iwis.core.film import LAYERS
from iwis.iwis_addon.settings import render_settings


def test_settings_from_keywords(scene):
    """They arrive on the scene; what comes back is what a render takes."""
    got = iwis.settings(scene, max_samples=7, stop_rule="FIXED", error_threshold=0.3)
    assert (got.max_samples, got.stop_rule, got.error_threshold) == (7, "FIXED", 0.3)
    assert scene.iwis.max_samples == 7 and got == render_settings(scene)


@pytest.mark.parametrize(
    ("values", "said"),
    [({"max_sampels": 3}, "max_sampels"), ({"max_samples": -3}, "max_samples")],
)
def test_wrong_settings_change_nothing(scene, values, said):
    """A misspelt name or an absurd value is named, and the right ones beside it are not set."""
    before = scene.iwis.batch_size
    with pytest.raises(ValueError, match=said):
        iwis.settings(scene, batch_size=before + 1, **values)
    assert scene.iwis.batch_size == before


def test_render_gives_arrays_and_leaves_the_scene(cube_scene):
    """All layers of the whole frame, with light and samples; engine and switches stay."""
    cube_scene.render.engine = "CYCLES"
    iwis.settings(cube_scene, max_samples=4, stop_rule="FIXED")
    layers = iwis.render(cube_scene)
    assert {name: layer.shape for name, layer in layers.items()} == {
        name: (24, 32, channels) for name, channels in LAYERS.items()
    }
    assert layers["samples"].max() == 4.0
    assert np.isfinite(layers["combined"]).all() and layers["combined"][..., :3].mean() > 0.0
    assert cube_scene.render.engine == "CYCLES" and not cube_scene.iwis.keep_film


def test_render_says_what_is_missing(cube_scene):
    """A scene without a camera, a view layer that is not there."""
    with pytest.raises(KeyError, match="Nothing"):
        iwis.render(cube_scene, layer="Nothing")
    cube_scene.camera = None
    with pytest.raises(RuntimeError, match="camera"):
        iwis.render(cube_scene)
    assert bpy.context.scene.render.engine == "IWIS"
