"""weigh.py: what samples of lobes bring that are neither plain gloss nor Lambert's alone."""

import numpy as np
import pytest

from iwis.core.bsdf.ashikhmin_shirley import set_ashikhmin_shirley
from iwis.core.bsdf.sheen import set_sheen
from iwis.core.bsdf.stretched import mean_roughness, stretch_lobes
from iwis.core.bsdf.thin_film_setup import FilmValues, set_film
from iwis.core.bsdf.thin_film_tables import REC709
from iwis.core.bsdf.toon import set_toon
from iwis.core.geometry.shading import ShadingPoints
from iwis.core.sampling.unbiased_rays import UnbiasedSampler
from iwis.core.scene import BECKMANN, DIFFUSE, GLOSSY, PRINCIPLED
from support.brdf_points import directions, evaluated, material, points, sphere_quadrature
from support.samplers import all_rays, random_sequence
from support.scenes import constant_world
from support.warps import light_of

_POINTS, _SAMPLES = 500, 128


def _lobes(kind):
    wo = directions(np.full(_POINTS, 0.8))
    every, none = np.ones(_POINTS, bool), np.zeros(_POINTS, bool)
    width = np.full(_POINTS, 0.5, np.float32)
    grain = np.tile(np.float32([1.5, 0.0, 0.0]), (_POINTS, 1))
    if kind == "brushed, rough below":
        own = {"roughness": float(mean_roughness(width, grain)[0]), "diffuse_roughness": 1.0}
        own |= {"base_color": (0.8, 0.8, 0.8), "metallic": 0.0}
        lobes = points(wo, model=PRINCIPLED, **own)
        stretch_lobes(lobes, width, grain)
        return lobes
    if kind == "filmed, rough below":
        own = {"base_color": (0.8, 0.8, 0.8), "metallic": 0.3, "diffuse_roughness": 1.0}
        lobes, metal = points(wo, model=PRINCIPLED, **own), (None, None)
        film = FilmValues(REC709, 800.0 * width, 3.0 * width, *metal)
        set_film(lobes, material(_POINTS, **own), np.arange(_POINTS), film)
        return lobes
    if kind.startswith("phong"):
        own = {"base_color": (0.8, 0.8, 0.8), "distribution": BECKMANN}
        lobes = points(wo, model=GLOSSY, roughness=0.6, **own)
        if kind == "phong, brushed":
            stretch_lobes(lobes, np.full(_POINTS, 0.6, np.float32), grain)
        set_ashikhmin_shirley(lobes, every)
        return lobes
    lobes = points(wo, model=DIFFUSE)
    if kind in ("fibers", "velvet"):
        set_sheen(lobes, every & (kind == "fibers"), every & (kind == "velvet"), width)
    else:
        set_toon(lobes, every, none, 0.3 * width, 0.2 * width)
    return lobes


@pytest.mark.parametrize(
    "kind",
    [
        "fibers",
        "velvet",
        "toon",
        "phong",
        "phong, brushed",
        "brushed, rough below",
        "filmed, rough below",
    ],
)
def test_samples_bring_the_integral(kind):
    """In even light, of 500 points with 128 samples: within 4 standard errors and the quadrature's
    2e-3. A density that counts the samples of the lobe twice is 4 to 9 % off."""
    lobes = _lobes(kind)
    zeros, up = np.zeros((_POINTS, 3), np.float32), np.tile(np.float32([0, 0, 1]), (_POINTS, 1))
    row, one = np.zeros(_POINTS, np.int32), np.ones((_POINTS, 3), np.float32)
    shading = ShadingPoints(row, row, zeros, lobes.wo, up, up, zeros, zeros[:, 0].copy(), one, row)
    light = light_of(constant_world((1.0, 1.0, 1.0)))
    sequence = random_sequence(np.random.default_rng(3), _POINTS, _SAMPLES, "OWEN")
    sampler = UnbiasedSampler(shading, lobes, light, sequence, 0.0, np.float32(0.0))
    rays = all_rays(sampler, np.arange(_POINTS), _SAMPLES)
    carried = (rays.diffuse + rays.glossy)[:, 0].astype(np.float64)
    means = np.bincount(rays.point, carried, _POINTS) / _SAMPLES
    wi, solid_angle = sphere_quadrature(192, 384)
    value = evaluated(lobes, 0, wi).astype(np.float64)
    expected = float(solid_angle @ (value[:, 0] + value[:, 3]))
    error = means.std() / np.sqrt(_POINTS)
    assert abs(means.mean() - expected) < 4.0 * error + 2e-3 * expected
    assert error < 8e-3 * expected  # of velvet, the least even
