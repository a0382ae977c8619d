"""Pixel filters against Cycles' of the same name and width, on leaves before the sky.

No pixel is left out, edges least of all. Cycles takes its first sample at the pixel's centre,
whatever the filter: 1/512 of the picture here.
"""

import math

import numpy as np
import pytest
import scenes
from agreement import compare
from run_cycles import render_cycles, use_cycles
from run_iwis import IwisRun, export_open_file

from iwis.core.settings import RenderSettings

SIZE, SAMPLES = (32, 32), 512
RATIO_LIMIT = 1.3  # as in test_truth.py


def _leaves():
    """The benchmark's foliage, aimed up so that half of it stands before the sky."""
    scene = scenes.foliage(size=SIZE)
    scene.camera.location = (0.0, -2.4, 1.5)
    scene.camera.rotation_euler = (math.radians(108.0), 0.0, 0.0)
    scene.camera.data.angle = math.radians(30.0)
    return scene


def _cycles(scene, kind, width, samples):
    """Two pictures, other seeds."""
    use_cycles(scene, 1)
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = kind, width
    return [render_cycles(scene, samples, seed=100 + k) for k in range(2)]


def _iwis(scene, kind, width, samples):
    """Combined of two pictures; many points a pixel, for it is edges that are compared."""
    settings = RenderSettings(
        pixel_filter=kind,
        filter_width=width,
        stop_rule="FIXED",
        max_samples=samples,
        batch_size=2,
        threads=1,
    )
    run = IwisRun(export_open_file(scene).scene, settings)
    return [run.render(seed=k)[0].layers["combined"] for k in range(2)]


def _as_rgb(pictures):
    return [np.repeat(alpha.reshape(*SIZE[::-1], 1), 3, -1) for alpha in pictures]


@pytest.mark.slow
@pytest.mark.statistical
@pytest.mark.parametrize(
    ("kind", "width"), [("BLACKMAN_HARRIS", 2.5), ("BOX", 1.5), ("GAUSSIAN", 2.5)]
)
def test_filters_are_those_of_cycles(kind, width):
    """Light and alpha differ by what the noise of both explains, and have no sign."""
    scene = _leaves()
    theirs = _cycles(scene, kind, width, SAMPLES)
    mine = _iwis(scene, kind, width, SAMPLES)
    alphas = _as_rgb([timed.alpha for timed in theirs])
    assert ((alphas[0] > 0.01) & (alphas[0] < 0.99)).mean() > 0.2  # rich in edges
    everywhere = np.ones(SIZE[::-1], bool)
    for found, wanted in (
        ([layer[..., :3] for layer in mine], [timed.rgb for timed in theirs]),
        (_as_rgb([layer[..., 3] for layer in mine]), alphas),
    ):
        agreement, _ = compare(found, wanted, everywhere)
        assert agreement.ratio <= RATIO_LIMIT, agreement
        # 1.25: mean absolute to standard deviation of a normal error; the sum averages the pixels
        error = 1.25 * agreement.noise / math.sqrt(agreement.pixels)
        assert abs(agreement.signed) <= max(2e-3, 3.0 * error), agreement


@pytest.mark.slow
@pytest.mark.statistical
def test_another_width_is_noticed():
    """The twin of the test above that must fail: a third wider."""
    scene = _leaves()
    alphas = _as_rgb([timed.alpha for timed in _cycles(scene, "BLACKMAN_HARRIS", 1.5, 128)])
    mine = _as_rgb([layer[..., 3] for layer in _iwis(scene, "BLACKMAN_HARRIS", 2.0, 128)])
    agreement, _ = compare(mine, alphas, np.ones(SIZE[::-1], bool))
    assert agreement.ratio > 1.5 * RATIO_LIMIT
