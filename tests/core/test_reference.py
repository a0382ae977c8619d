"""reference.py: the estimators that others are compared with are right themselves."""

import numpy as np
import pytest

from iwis.core._jit import kernel
from iwis.core.comparisons.reference import (
    BSDF_SAMPLING,
    LIGHT_SAMPLING,
    MIS_SAMPLING,
    MixtureSampler,
    hammersley_points,
    make_wis,
    pdf_light,
    sample_light,
)
from iwis.core.paper_mode.paper_tables import TableBuilder
from iwis.core.sampling.incremental import sample_points
from iwis.core.settings import RenderSettings
from iwis.core.unit_square.sphere_map import sphere_grid
from support.naive import radical_inverse
from support.samplers import pixel_points, plain_sequence, random_sequence
from support.scenes import (
    camera_above,
    constant_world,
    diffuse,
    floor,
    gradient_world,
    make_scene,
    one_texel_world,
)
from support.statistics import chi2_p_value, sidak, t_p_value
from support.truths import corner_scene, corner_truth
from support.warps import light_of, square_points

SHARES = {"light": LIGHT_SAMPLING, "bsdf": BSDF_SAMPLING, "mis": MIS_SAMPLING}
# Each where it works: BSDF sampling misses suns, light sampling misses mirrors.
CASES = [
    ("light", "gradient", "diffuse"),
    ("light", "gradient", "alpha 0.2"),
    ("light", "sun over the wall", "diffuse"),
    ("bsdf", "gradient", "diffuse"),
    ("bsdf", "gradient", "alpha 0.05"),
    ("bsdf", "gradient", "alpha 1.0"),
    ("mis", "gradient", "alpha 0.05"),
    ("mis", "sun over the wall", "diffuse"),
    ("mis", "sun in the mirror", "alpha 0.05"),
    ("mis", "sun in the mirror", "alpha 0.2"),
]
N_TESTS = len(CASES) + 2


@kernel
def _sample_many(pyramid, points, directions, pdf):
    for k in range(len(points)):
        sample = sample_light(pyramid, points[k, 0], points[k, 1])
        directions[k, 0], directions[k, 1], directions[k, 2], pdf[k] = sample


@pytest.mark.statistical
@pytest.mark.parametrize(("kind", "world", "material"), CASES)
def test_mean_is_the_true_integral(kind, world, material, rng):
    """t-test of 400 shifted estimates against the quadrature; a twin 5 % too bright is rejected.

    alpha 1e-3 over the file.
    """
    scene = corner_scene(world, material)
    truth = corner_truth(scene, world, material)[1]
    pixels = pixel_points(scene)
    n, count = len(pixels.rows), 512
    sampler = MixtureSampler(
        pixels.points,
        pixels.lobes,
        light_of(scene.environment),
        SHARES[kind],
        random_sequence(rng, n, count),
        pixels.accel.offset,
    )
    settings = RenderSettings(max_samples=count, batch_size=64, stop_rule="FIXED")
    sums, _ = sample_points(sampler, n, pixels.accel, settings)
    estimates = (sums.diffuse + sums.glossy)[:, 1] / count
    truth += np.clip(estimates.mean() - truth, -1e-3 * truth, 1e-3 * truth)  # the quadrature's
    assert t_p_value(estimates, truth) > sidak(1e-3, N_TESTS)
    assert t_p_value(1.05 * estimates, truth) < sidak(1e-3, N_TESTS)


@pytest.mark.statistical
@pytest.mark.parametrize("ground", [0.0, 0.5])
def test_light_sampling_follows_the_light(ground, rng):
    """chi-square of PCG64 points, a twin 5 % off; the density is the one returned."""
    pyramid = light_of(one_texel_world(32, 20, 9, 1e3, ground)).pyramid
    n, side = 300_000, 16 if ground else 64  # the sun alone fills two of 16^2 cells
    directions, pdf = np.empty((n, 3)), np.empty(n)
    _sample_many(pyramid, rng.random((n, 2)), directions, pdf)
    again = [pdf_light(pyramid, *d) for d in directions[:2000]]
    np.testing.assert_allclose(again, pdf[:2000], rtol=1e-12)  # float64
    levels = pyramid.levels
    cut = pyramid._replace(children=np.zeros_like(pyramid.children))  # means of the whole levels
    grid = sphere_grid(1 << levels).astype(np.float64)
    density = np.array([pdf_light(cut, *d) for d in grid])
    assert density.mean() * 4.0 * np.pi == pytest.approx(1.0, abs=1e-5)  # float32 levels
    share = density.reshape(side, -1, side, (1 << levels) // side).sum((1, 3)) / density.sum()
    x, y = square_points(directions).T
    observed, _, _ = np.histogram2d(y, x, side, [[0, 1], [0, 1]])
    assert chi2_p_value(observed, n * share) > sidak(1e-3, N_TESTS)
    wrong = share * np.where(np.arange(side) % 2, 1.05, 1.0)
    assert chi2_p_value(observed, n * wrong / wrong.sum()) < sidak(1e-3, N_TESTS)


def test_hammersley_points_are_hammersleys():
    """k / N, from the middle of its interval, and the radical inverse of k."""
    points = hammersley_points(10) / 2.0**32
    np.testing.assert_allclose(points[:, 0], (np.arange(10) + 0.5) / 10, atol=2.0**-32)
    np.testing.assert_allclose(
        points[:, 1], [radical_inverse(k, 2) for k in range(10)], atol=2.0**-32
    )


def test_black_points_and_worlds_get_no_sample():
    """Nothing to reflect, or nothing that shines."""
    scene = make_scene([floor()], [diffuse((0, 0, 0))], gradient_world(), camera_above(2, 2))
    pixels = pixel_points(scene)
    arguments = (MIS_SAMPLING, plain_sequence(4, 4), pixels.accel.offset)
    for world in (gradient_world(), constant_world((0, 0, 0))):
        sampler = MixtureSampler(pixels.points, pixels.lobes, light_of(world), *arguments)
        assert not sampler.lit().any()


def test_wis_is_the_papers_product_with_its_own_points(table_dir, rng):
    """Fixed count, Hammersley: no shadow, so K = N, and the mean is I_s itself."""
    scene = make_scene([floor()], [diffuse()], gradient_world(), camera_above(4, 4))
    pixels = pixel_points(scene)
    light = light_of(scene.environment)
    settings = RenderSettings(cache_dir=table_dir, max_samples=64, stop_rule="FIXED")
    tables = TableBuilder().tables(light.lookup, scene.materials, settings, 1)
    sequence = random_sequence(rng, 16, 64)
    sampler = make_wis(
        pixels.points, pixels.lobes, pixels.rows, tables, sequence, 64, pixels.accel.offset
    )
    sums, _ = sample_points(sampler, 16, pixels.accel, settings)
    mean = (sums.diffuse + sums.glossy) / 64
    # Directions of the nearest normal's slice that dip below the floor count as hidden: 1 in 64.
    np.testing.assert_allclose(mean, sampler.unoccluded(), rtol=0.02)
