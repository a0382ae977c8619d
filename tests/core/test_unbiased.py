"""unbiased.py: a fixed count converges to the true integral, whatever light and lobe."""

import numpy as np
import pytest

from iwis.core.sampling.unbiased_rays import UnbiasedSampler
from support.samplers import all_rays, pixel_points, plain_sequence
from support.scenes import (
    camera_above,
    diffuse,
    floor,
    gradient_world,
    make_picture,
    make_scene,
    varied_scene,
)
from support.statistics import sidak, t_p_value
from support.truths import CASES, corner_scene, corner_truth
from support.warps import light_of


@pytest.mark.statistical
@pytest.mark.parametrize(("world", "material"), CASES)
def test_mean_is_the_true_integral(world, material):
    """t-test of 400 shifted estimates of 256 samples against the quadrature, with shadows.

    alpha 1e-3 over all cases. The quadrature's own error (between grids of 500^2 and 700^2 points:
    below 0.1 %) is allowed for. A twin that is 5 % too bright is rejected.
    """
    scene = corner_scene(world, material)
    truth = corner_truth(scene, world, material)[1]
    layers, _ = make_picture(scene, max_samples=256, stop_rule="FIXED")
    estimates = layers["combined"][..., 1].ravel().astype(np.float64)
    truth += np.clip(estimates.mean() - truth, -1e-3 * truth, 1e-3 * truth)
    assert t_p_value(estimates, truth) > sidak(1e-3, len(CASES))
    assert t_p_value(1.05 * estimates, truth) < sidak(1e-3, len(CASES))


def test_every_channel_is_the_true_integral():
    """Coloured light on a coloured surface: red, green and blue, not luminance times a colour."""
    scene = corner_scene("gradient", "diffuse")
    truth = corner_truth(scene, "gradient", "diffuse")
    layers, _ = make_picture(scene, max_samples=1024, stop_rule="FIXED")
    mean = layers["combined"][..., :3].mean((0, 1))
    # 400 x 1024 samples: standard error 0.05 % (measured), quadrature 0.1 %
    np.testing.assert_allclose(mean, truth, rtol=3e-3)


def test_without_occluders_nothing_is_lost():
    """What was seen is all there is: visibility 1 where no ray is blocked, I_s = I_d."""
    scene = make_scene([floor()], [diffuse()], gradient_world(), camera_above())
    layers, _ = make_picture(scene, max_samples=32, stop_rule="FIXED")
    np.testing.assert_array_equal(layers["unoccluded"], layers["combined"][..., :3])
    assert (layers["visibility"] == 1.0).all()


def test_rays_leave_the_surface_with_light():
    """Every ray starts off its face on the viewer's side, goes up, and carries finite light."""
    scene = varied_scene()
    pixels = pixel_points(scene)
    n = len(pixels.rows)
    sampler = UnbiasedSampler(
        pixels.points,
        pixels.lobes,
        light_of(scene.environment),
        plain_sequence(n, 16),
        pixels.accel.offset,
    )
    lit = sampler.lit()
    rays = all_rays(sampler, np.arange(n), 16)
    normal = pixels.points.geometric_normal[rays.point]
    assert ((rays.directions * normal).sum(-1) > 0.0).all()
    height = ((rays.origins - pixels.points.position[rays.point]) * normal).sum(-1)
    np.testing.assert_allclose(height, pixels.accel.offset, rtol=0.3)  # float32, metres away
    carried = rays.diffuse + rays.glossy
    assert np.isfinite(carried).all() and (carried >= 0.0).all() and (carried.max(1) > 0.0).all()
    assert lit[np.unique(rays.point)].all()
    black = pixels.rows == 4  # emits, reflects nothing
    assert black.any() and not lit[black].any()
