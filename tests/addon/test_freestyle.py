"""Freestyle's lines, which Blender hands to the engine as a scene of its own."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.job import RenderJob
from support.cycles_render import render_cycles
from support.iwis_render import by_pass, render_iwis


@pytest.fixture
def lines_scene(cube_scene):
    """Lines as a pass of their own, half clear."""
    cube_scene.render.use_freestyle = True
    freestyle = cube_scene.view_layers[0].freestyle_settings
    freestyle.as_render_pass = True
    style = bpy.data.linestyles.new("Style")
    lines = freestyle.linesets.new("Lines")
    lines.linestyle, lines.select_silhouette, lines.select_crease = style, True, True
    style.thickness, style.alpha, style.color = 4.0, 0.5, (1.0, 0.2, 0.0)
    return cube_scene


@pytest.mark.slow
def test_lines_are_those_of_cycles(lines_scene, tmp_path):
    """By IWIS too, which needs no GPU; its figures and warnings are those of the picture alone.

    Tolerance: 32 points a pixel, other ones than Cycles'.
    """
    lines_scene.iwis.pixel_filter = "BLACKMAN_HARRIS"
    ours = by_pass(render_iwis(lines_scene, tmp_path))["Freestyle"]
    records = RenderJob.get().records
    assert [(record.layer, record.stats.warnings) for record in records] == [("ViewLayer", [])]
    theirs = render_cycles(lines_scene, tmp_path, passes=(), samples=64, filter_width=1.5)
    theirs = theirs["Freestyle"]
    assert ours.shape == theirs.shape and theirs[..., 3].max() > 0.3
    means = [lines.mean((0, 1))[[0, 1, 3]] for lines in (ours, theirs)]
    np.testing.assert_allclose(*means, rtol=0.02)  # .065 where lines hide those behind them
    assert np.abs(ours - theirs).mean() < 0.01


@pytest.mark.slow
def test_lines_do_not_take_the_place_of_the_kept_film(lines_scene, tmp_path):
    """The last film of the view layer is the picture."""
    lines_scene.iwis.keep_film = True
    layers = by_pass(render_iwis(lines_scene, tmp_path))
    (film,) = RenderJob.get().films.values()
    np.testing.assert_array_equal(film.layers["combined"], layers["Combined"])
    assert bpy.data.scenes[:] == [lines_scene]
