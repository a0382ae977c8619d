"""Mode UNBIASED against MIS of light and BSDF, pixel by pixel; and no sample outshines its pixel.

The long form, twelve pairs of material and HDRI against 64 k samples, is benchmarks/seeds.py.
"""

import numpy as np
import pytest
import seeds

from iwis.core.bsdf.lobe_setup import setup_lobes
from iwis.core.geometry.shading import ShadingPoints
from iwis.core.render import RenderCache
from iwis.core.sampling.unbiased_rays import UnbiasedSampler
from iwis.core.scene import EnvironmentMap
from support.brdf_points import material
from support.samplers import all_rays, random_sequence
from support.warps import light_of

PAIRS = [("diffuse 1", "sun"), ("plastic .05", "hall"), ("metal 0", "sunrise"), ("metal .1", "sun")]


@pytest.mark.statistical
@pytest.mark.parametrize(("name", "hdri"), PAIRS)
def test_ten_seeds_agree_with_mis(name, hdri):
    """Of the pixels of ten renders, as many are within 4.09 standard errors as Student's t says.

    alpha 1e-3 a pair (seeds.least_share). The twin, 5 % too bright, has fewer.
    """
    scene, cache = seeds.pair_scene(name, hdri, 14), RenderCache()
    pictures = seeds.renders(scene, cache, 256, 10)
    reference = seeds.references(scene, cache, 1 << 14)
    found = seeds.agreement(pictures, reference)
    least = seeds.least_share(found.pixels, 0.0027)
    assert found.pixels > 80 and found.within_t >= least
    assert abs(found.difference) < 4.0 * found.error
    assert seeds.agreement(1.05 * pictures, reference).within_t < least


@pytest.fixture(scope="module")
def sun():
    """A sun of 0.5 degrees with 1e5 times the sky, in direction seeds.SUN."""
    return light_of(seeds.world("sun"))


def _largest_samples(light, normal, wo, count, rng, **parameters):
    """float64 (n,): the largest of a point's samples over their mean; all must be finite."""
    n = len(normal)
    normal, wo = normal.astype(np.float32), wo.astype(np.float32)
    zeros = np.zeros((n, 3), np.float32)
    points = ShadingPoints(
        *(np.zeros(n, np.int32) for _ in range(2)),
        zeros,
        wo,
        normal,
        normal,
        zeros,
        np.zeros(n, np.float32),
        zeros,
        np.zeros(n, np.int32),
    )
    lobes = setup_lobes(material(n, **parameters), normal, normal, wo)
    sampler = UnbiasedSampler(points, lobes, light, random_sequence(rng, n, count, "OWEN"), 0.0)
    rays = all_rays(sampler, np.flatnonzero(sampler.lit()), count)
    carried = (rays.diffuse + rays.glossy).astype(np.float64).sum(1)
    assert np.isfinite(carried).all()
    largest, total = np.zeros(n), np.zeros(n)
    np.maximum.at(largest, rays.point, carried)
    np.add.at(total, rays.point, carried)
    return largest * count / total


def _unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


@pytest.mark.parametrize("metallic", [0.0, 1.0])
@pytest.mark.parametrize(
    ("roughness", "most"),
    [(0.0, 700.0), (1e-4, 700.0), (0.02, 320.0), (0.05, 64.0), (0.2, 32.0), (1.0, 32.0)],
)
def test_no_sample_outshines_its_pixel(roughness, most, metallic, sun, rng):
    """The mirrored wo within 1e-4 ... 0.1 rad of the sun, whose rim is a cliff of 1e5.

    Bounds are four times the largest of ten such runs: 172 for mirrors that see the rim (MIS of
    light and BSDF reaches 250), 78 at .02, 16 at .05, 8 above.
    """
    normal = _unit(seeds.SUN + 0.6 * _unit(rng.standard_normal((60, 3))))
    mirrored = 2.0 * (normal @ seeds.SUN)[:, None] * normal - seeds.SUN
    off = rng.standard_normal((60, 3)) * 10.0 ** rng.uniform(-4.0, -1.0, (60, 1))
    parameters = {"roughness": roughness, "metallic": metallic, "base_color": (0.6, 0.6, 0.6)}
    largest = _largest_samples(sun, normal, _unit(mirrored + off), 2048, rng, **parameters)
    assert largest.max() < most


@pytest.mark.parametrize("metallic", [0.0, 1.0])
@pytest.mark.parametrize("roughness", [0.0, 0.02, 0.05, 0.1, 0.3, 0.5, 1.0])
def test_grazing_views_have_no_bright_samples(roughness, metallic, sun, rng):
    """wo 1e-4 ... 0.1 above the horizon: 23 at most in ten such runs; the bound is four times that.

    500 where lobes are not followed there (docs/decisions/0010-narrow-lobes.md).
    """
    normal = _unit(rng.standard_normal((60, 3)))
    side = _unit(np.cross(normal, rng.standard_normal((60, 3))))
    height = 10.0 ** rng.uniform(-4.0, -1.0, (60, 1))
    wo = np.sqrt(1.0 - height**2) * side + height * normal
    parameters = {"roughness": roughness, "metallic": metallic, "base_color": (0.6, 0.6, 0.6)}
    assert _largest_samples(sun, normal, wo, 2048, rng, **parameters).max() < 92.0


@pytest.mark.parametrize("roughness", [0.0, 0.05, 0.5])
def test_constant_and_black_worlds(roughness, rng):
    """Constant light: samples of a metal vary by what its cells are coarse; black: none."""
    normal = _unit(rng.standard_normal((40, 3)))
    wo = _unit(normal + 0.5 * _unit(rng.standard_normal((40, 3))))
    parameters = {"roughness": roughness, "metallic": 1.0, "base_color": (0.6, 0.6, 0.6)}
    even = light_of(EnvironmentMap(radiance=np.ones((4, 8, 3), np.float32)))
    assert _largest_samples(even, normal, wo, 1024, rng, **parameters).max() < 10.0
    dark = light_of(EnvironmentMap(radiance=np.zeros((4, 8, 3), np.float32)))
    n = len(normal)
    lobes = setup_lobes(material(n, **parameters), *(a.astype(np.float32) for a in (normal,) * 3))
    points = ShadingPoints(*(np.zeros(n, np.int32) for _ in ShadingPoints._fields))
    assert not UnbiasedSampler(points, lobes, dark, random_sequence(rng, n, 4), 0.0).lit().any()
