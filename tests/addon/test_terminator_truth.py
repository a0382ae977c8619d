"""Blender's shadow terminator geometry offset against Cycles, on a coarse mesh."""

import dataclasses

import numpy as np
import pytest
import scenes
from run_cycles import render_cycles, use_cycles
from run_iwis import IwisRun, export_open_file

from iwis.core.settings import RenderSettings

SAMPLES = 256


@pytest.mark.slow
@pytest.mark.statistical
@pytest.mark.parametrize("metallic", [0.0, 1.0])
def test_coarse_smooth_mesh_at_blenders_default(metallic):
    """Unsubdivided Suzanne: the mean within .3 %, without the offset more than .4 % too dark.

    Two pictures of 256 samples have a mean error of some .05 %; .3 % is six times that.
    """
    scene = scenes.new_scene("workshop", 0.0, (64, 64))
    monkey = scenes.add_monkey(
        scenes.principled((0.8, 0.6, 0.4), 0.5, metallic), (0.0, 0.0, 0.0), 1.0, 0
    )
    monkey.shadow_terminator_geometry_offset = 0.1
    scenes.add_camera(scene, (1.5, -5.0, 1.0), (0.0, 0.0, 0.0), 30.0)
    use_cycles(scene, 1)
    exported = export_open_file(scene).scene
    settings = RenderSettings(
        stop_rule="FIXED", max_samples=SAMPLES, pixel_filter="CENTER", threads=1
    )
    reference = render_cycles(scene, SAMPLES)
    inside = reference.alpha > 0.999

    def difference(changed):
        film, _ = IwisRun(changed, settings).render()
        ours = film.layers["combined"][..., :3]
        return (
            ours[inside].mean(dtype=np.float64) / reference.rgb[inside].mean(dtype=np.float64) - 1
        )

    assert np.ptp(exported.terminator_offset) == 0.0 and exported.terminator_offset[0] > 0.0
    assert abs(difference(exported)) < 3e-3
    assert difference(dataclasses.replace(exported, terminator_offset=None)) < -4e-3
