"""core/geometry/terminator.py: where grazing shadow rays of coarse smooth faces start."""

import numpy as np
import pytest

from iwis.core.bsdf.lobe_setup import setup_lobes
from iwis.core.geometry.shading import shading_points
from iwis.core.geometry.terminator import lift_share
from iwis.core.sampling.unbiased_rays import UnbiasedSampler
from iwis.core.scene import ROUND
from support.brdf_points import material
from support.samplers import all_rays, random_sequence
from support.scenes import (
    camera_above,
    constant_world,
    diffuse,
    make_mesh,
    make_picture,
    make_scene,
    sphere,
)
from support.warps import light_of


def _centre_points(smooth, looking, offset=0.1):
    """Centres of the upper faces of a unit sphere of 12 rings, seen from above or inside."""
    mesh = make_mesh(sphere(rings=12, smooth=smooth))
    upper = mesh.vertices[mesh.triangles][:, :, 2].min(1) > 0.1
    hit = np.flatnonzero(upper).astype(np.int32)
    third = np.full(len(hit), 1.0 / 3.0, np.float32)
    directions = np.tile(np.float32([0.0, 0.0, looking]), (len(hit), 1))
    return shading_points(mesh, hit, third, third, directions, np.float32([offset]))


def test_a_smooth_ball_is_lifted_towards_its_sphere():
    """At least half of the way from facet to sphere: half the parabola is the least height."""
    points = _centre_points(smooth=True, looking=-1.0)
    gap = 1.0 - np.linalg.norm(points.position, axis=1)
    height = np.einsum("ij,ij->i", points.lift, points.normal)
    assert gap.min() > 5e-3
    assert (height > 0.45 * gap).all()  # the patch is a parabola, the gap that of a circle
    assert (points.lift_below == np.float32(0.1)).all()


def test_inside_a_ball_the_lift_is_inwards():
    """Both sides of a face are lifted to the side that the camera sees."""
    points = _centre_points(smooth=True, looking=1.0)
    assert (np.einsum("ij,ij->i", points.lift, points.geometric_normal) >= 0.0).all()


def test_flat_faces_are_not_lifted():
    """Their normals do not bend; what is left is the rounding of a unit sphere in float32."""
    points = _centre_points(smooth=False, looking=-1.0)
    np.testing.assert_allclose(points.lift, 0.0, atol=1e-6)


def test_an_offset_of_zero_lifts_nothing():
    """Nor does a mesh without offsets."""
    assert not _centre_points(smooth=True, looking=-1.0, offset=0.0).lift_below.any()


def test_the_share_is_one_at_the_horizon_and_fades_out():
    """All of it at cosine 0, none from the offset on; twice as far where both cosines are small."""
    share = [
        float(lift_share(np.float32(c), np.float32(0.5), np.float32(0.1))) for c in (0, 0.05, 0.1)
    ]
    assert share == pytest.approx([1.0, 0.5, 0.0], abs=1e-6)
    both = [
        float(lift_share(np.float32(c), np.float32(c), np.float32(0.1))) for c in (0.0, 0.05, 0.075)
    ]
    assert both == pytest.approx([1.0, 1.0, 0.5], abs=1e-6)


def test_rays_of_the_product_start_as_high_as_their_share():
    """On the face, or above it by lift_share of the patch's height; float32's sums are 1e-6 of it.

    Of the light of a white sky half is sampled as Cycles' light samples are, and lifted.
    """
    points = _centre_points(smooth=True, looking=-1.0, offset=0.3)
    n, offset = len(points.pixel), np.float32(1e-3)
    own = points.normal, points.geometric_normal, points.wo
    lobes = setup_lobes(material(n, specular_level=0.0), *own)
    light = light_of(constant_world())
    sequence = random_sequence(np.random.default_rng(5), n, 64, "OWEN")
    sampler = UnbiasedSampler(points, lobes, light, sequence, offset, np.float32(0.0))
    rays = all_rays(sampler, np.arange(n), 64)
    p, face = rays.point, points.geometric_normal[rays.point]
    above = (face * rays.directions).sum(1)
    cosine = (points.normal[p] * rays.directions).sum(1)
    below = np.float32(0.3)
    share = np.array([lift_share(a, c, below) for a, c in zip(above, cosine, strict=True)])
    moved = rays.origins - points.position[p] - offset * face
    lift = points.lift[p]
    height = (moved * lift).sum(1) / (lift * lift).sum(1)
    np.testing.assert_allclose(moved, height[:, None] * lift, atol=1e-6)
    lifted = np.abs(height - share) < 1e-3
    assert (lifted | (np.abs(height) < 1e-3)).all()
    assert (lifted & (share > 0.1)).sum() > 100


def test_what_is_round_is_lit_as_a_ball():
    """A ball of 48 faces under a white sky gives back its albedo all over; with the usual offset
    its facets shade themselves."""
    ball, camera = sphere(rings=4, smooth=True), camera_above(half=0.7)
    means = []
    for offset in (ROUND, 0.1):
        offsets = np.float32([offset])
        scene = make_scene(
            [ball], [diffuse((0.8, 0.8, 0.8))], constant_world(), camera, terminator_offset=offsets
        )
        layers, _ = make_picture(scene, max_samples=64, stop_rule="FIXED")
        means.append(float(layers["combined"][..., :3].mean()))
    # .002: a parabola stands for the sphere, so that some rays start below it
    assert means[0] == pytest.approx(0.8, abs=0.002)
    assert means[1] < 0.797
