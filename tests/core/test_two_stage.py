"""two_stage.py: [Cline06]'s estimator is right, and better than either factor alone."""

import numpy as np
import pytest

from iwis.core.comparisons.reference import LIGHT_SAMPLING, MixtureSampler
from iwis.core.comparisons.two_stage import PILOT, TwoStageSampler, continue_adaptively
from iwis.core.sampling.incremental import continue_points, new_sums
from iwis.core.sampling.stop_rule import paper_rule
from support.samplers import pixel_points, random_sequence
from support.statistics import sidak, t_p_value
from support.truths import corner_scene, corner_truth
from support.warps import light_of

CASES = [
    ("gradient", "diffuse"),
    ("gradient", "alpha 0.2"),
    ("sun over the wall", "diffuse"),
    ("sun in the mirror", "alpha 0.2"),
]


def _sampler(scene, rng, count, make=TwoStageSampler, extra=()):
    pixels = pixel_points(scene)
    sequence = random_sequence(rng, len(pixels.rows), count)
    light, offset = light_of(scene.environment), pixels.accel.offset
    sampler = make(pixels.points, pixels.lobes, light, *extra, sequence, offset)
    return sampler, new_sums(len(pixels.rows)), pixels.accel


def _run(scene, rng, rule, count, make=TwoStageSampler, extra=()):
    sampler, sums, accel = _sampler(scene, rng, count, make, extra)
    continue_points(sampler, sums, accel, rule)
    return sums


def _adaptive(scene, rng, threshold):
    sampler, sums, accel = _sampler(scene, rng, 96)
    continue_adaptively(sampler, sums, accel, threshold, 96)
    return sums


@pytest.mark.statistical
@pytest.mark.parametrize(("world", "material"), CASES)
def test_mean_is_the_true_integral(world, material, rng):
    """t-test of 400 shifted estimates against the quadrature; a twin 5 % too bright is rejected.

    alpha 1e-3 over the file.
    """
    scene = corner_scene(world, material)
    truth = corner_truth(scene, world, material)[1]
    sums = _run(scene, rng, paper_rule(-1.0, 512, 512), 512)
    estimates = (sums.diffuse + sums.glossy)[:, 1] / 512
    truth += np.clip(estimates.mean() - truth, -1e-3 * truth, 1e-3 * truth)  # the quadrature's
    assert t_p_value(estimates, truth) > sidak(1e-3, len(CASES))
    assert t_p_value(1.05 * estimates, truth) < sidak(1e-3, len(CASES))


def test_variance_is_below_light_samplings(rng):
    """On a glossy floor, both at 64 samples: by a factor of 2 and more."""
    scene, rule = corner_scene("gradient", "alpha 0.2"), paper_rule(-1.0, 64, 64)
    two_stage = _run(scene, rng, rule, 64)
    light = _run(scene, rng, rule, 64, MixtureSampler, (LIGHT_SAMPLING,))
    assert two_stage.glossy[:, 1].var() < 0.5 * light.glossy[:, 1].var()


def test_samples_go_by_the_pilots_variance(rng):
    """Pixels whose pilot is even stop there; none goes beyond the most."""
    scene = corner_scene("gradient", "diffuse")
    sums = _adaptive(scene, rng, 0.1)
    assert sums.count.min() >= PILOT
    assert sums.count.max() <= 96
    strict = _adaptive(scene, rng, 0.02)
    assert strict.count.mean() > sums.count.mean()
