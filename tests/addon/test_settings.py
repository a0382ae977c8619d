"""Blender's properties and RenderSettings say the same."""

import dataclasses

import pytest

import iwis
from iwis.core.settings import (
    CHOICES,
    DENOISE_CHOICES,
    LIMITS,
    DenoiseSettings,
    RenderSettings,
)
from iwis.iwis_addon import settings as addon_settings
from iwis.iwis_addon.properties import NOT_ON_SCENE

DENOISE = {field.name: field for field in dataclasses.fields(DenoiseSettings)}
FIELDS = {field.name: field for field in dataclasses.fields(RenderSettings)} | DENOISE
ALL_CHOICES = CHOICES | DENOISE_CHOICES


@pytest.mark.parametrize("name", FIELDS)
def test_every_setting_has_a_property(scene, name):
    """A field is a property of the same default and limits, or a stated exception."""
    if name in NOT_ON_SCENE:
        assert NOT_ON_SCENE[name]
        assert name not in scene.iwis.bl_rna.properties
        return
    rna = scene.iwis.bl_rna.properties[name]
    assert rna.description
    if name in ALL_CHOICES:
        assert rna.default == FIELDS[name].default
        assert tuple(item.identifier for item in rna.enum_items) == ALL_CHOICES[name]
    elif FIELDS[name].type == "bool":
        assert rna.type == "BOOLEAN" and rna.default == FIELDS[name].default
    else:
        assert rna.default == pytest.approx(FIELDS[name].default, rel=1e-7)  # float32
        assert (rna.hard_min, rna.hard_max) == pytest.approx(LIMITS[name], rel=1e-7)  # float32


def test_no_property_is_without_effect(scene):
    """What the panel shows of the sampler reaches the sampler."""
    own = {name for name in scene.iwis.bl_rna.properties.keys() if name not in ("name", "rna_type")}
    assert own - set(FIELDS) == {"bake_type", "keep_film", "use_animated_seed", "viewport"}


def test_defaults_survive_the_way_through_blender(scene):
    """An untouched file renders with the defaults of core.settings, to the last bit."""
    scene.render.threads_mode = "AUTO"
    got = addon_settings.render_settings(scene)
    assert dataclasses.replace(got, cache_dir="") == RenderSettings()
    assert addon_settings.denoise_settings(scene.iwis) == DenoiseSettings()


def test_values_arrive(scene):
    """What is set on the scene is what the core gets."""
    scene.iwis.error_threshold, scene.iwis.max_samples, scene.iwis.batch_size = 0.0, 7, 16
    scene.iwis.estimator, scene.iwis.stop_rule, scene.iwis.seed = "PAPER", "FIXED", 5
    got = addon_settings.render_settings(scene)
    assert (got.error_threshold, got.max_samples, got.batch_size) == (0.0, 7, 16)
    assert (got.estimator, got.stop_rule, got.seed) == ("PAPER", "FIXED", 5)


def test_the_denoisers_settings_arrive(scene):
    """Those of a render and those of the rendered view, which has Cycles' defaults."""
    view = addon_settings.denoise_settings(scene.iwis.viewport)
    quick = {"denoise_prefilter": "FAST", "denoise_quality": "BALANCED"}
    assert view == DenoiseSettings(denoise_passes="ALBEDO", **quick)
    iwis.settings(scene, denoise=True, denoise_passes="NONE", max_samples=9)
    got = addon_settings.denoise_settings(scene.iwis)
    assert got == DenoiseSettings(denoise=True, denoise_passes="NONE")
    assert scene.iwis.max_samples == 9
    assert addon_settings.denoise_settings(scene.iwis.viewport) == view


def test_absurd_values_stop_at_the_limits(scene):
    """A property cannot hold what RenderSettings would refuse."""
    scene.iwis.threads, scene.iwis.max_samples, scene.iwis.coefficients = 10**6, -3, 0.0
    got = addon_settings.render_settings(scene)
    assert (got.threads, got.max_samples) == (LIMITS["threads"][1], 1)
    assert got.coefficients == LIMITS["coefficients"][0]


def test_threads_follow_blender_unless_set(scene):
    """scene.iwis.threads wins; else Blender's fixed number; else 0, all cores."""
    scene.render.threads_mode, scene.render.threads = "FIXED", 3
    assert addon_settings.render_settings(scene).threads == 3
    scene.iwis.threads = 2
    assert addon_settings.render_settings(scene).threads == 2
    scene.iwis.threads, scene.render.threads_mode = 0, "AUTO"
    assert addon_settings.render_settings(scene).threads == 0


def test_cache_folder_comes_from_the_environment(scene, monkeypatch, tmp_path):
    """Without preferences of an installed add-on, IWIS_CACHE_DIR names the folder."""
    monkeypatch.setenv("IWIS_CACHE_DIR", str(tmp_path))
    assert addon_settings.render_settings(scene).cache_dir == str(tmp_path)
    monkeypatch.delenv("IWIS_CACHE_DIR")
    assert addon_settings.render_settings(scene).cache_dir == ""


def test_apply_settings_writes_only_what_is_named(scene):
    """The command line changes what it names and keeps the file's other values."""
    scene.iwis.seed = 9
    addon_settings.apply_settings(scene, RenderSettings(max_samples=12), ["max_samples"])
    assert (scene.iwis.max_samples, scene.iwis.seed) == (12, 9)
