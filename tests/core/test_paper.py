"""paper.py and paper_products.py: mode PAPER, I_s from the tables, I_d = I_s K / N."""

import numpy as np
import pytest

from iwis.core.light.environment import eval_environment_many
from iwis.core.paper_mode.paper import PaperSampler
from iwis.core.paper_mode.paper_tables import TableBuilder
from iwis.core.settings import RenderSettings
from support.naive import integrate_diffuse, integrate_glossy
from support.samplers import all_rays, pixel_points, plain_sequence
from support.scenes import (
    camera_at,
    diffuse,
    glossy,
    gradient_world,
    make_picture,
    make_scene,
    principled,
    sphere,
    varied_scene,
)
from support.truths import corner_scene, corner_truth
from support.warps import light_of

COLOR = np.array([0.8, 0.6, 0.3])


def _ball(material, pixels=6):
    """A smooth ball: normals and wo of all kinds."""
    camera = camera_at((0.0, -3.0, 0.4), (0.0, 0.0, 0.0), pixels, pixels, 0.3)
    return make_scene([sphere(rings=16, smooth=True)], [material], gradient_world(), camera)


def _sampler(scene, folder, coefficients=0.05, count=16):
    pixels, light = pixel_points(scene), light_of(scene.environment)
    settings = RenderSettings(coefficients=coefficients, cache_dir=str(folder))
    tables = TableBuilder().tables(light.lookup, scene.materials, settings, 1)
    n = len(pixels.rows)
    sampler = PaperSampler(
        pixels.points,
        pixels.lobes,
        pixels.rows,
        tables,
        plain_sequence(n, count),
        pixels.accel.offset,
    )
    return sampler, pixels, light


@pytest.mark.slow
@pytest.mark.parametrize(
    ("alpha", "mean", "worst"), [(None, 1.5e-3, 1e-2), (0.5, 2e-3, 1.5e-2), (0.2, 3e-3, 4e-2)]
)
def test_unoccluded_light_equals_quadrature(alpha, mean, worst, tmp_path):
    """All coefficients: I_s is off by what grids of 2.2 (cells) and 3.2 degrees (normals) explain.

    Interpolating between normals h = 3.2 degrees apart is off by h^2 / 8 of a second derivative:
    4e-4 for a cosine; for a lobe of width alpha by (h / alpha)^2 / 8: 1e-2 at .2. The worst are
    points near the silhouette, where wo crosses the horizon of neighbouring slices. Three colours
    of light on a coloured surface, each channel on its own.
    """
    material = diffuse(COLOR) if alpha is None else glossy(alpha, COLOR)
    (tmp_path / "file").write_text("tables of 300 MB need not be kept: no folder")
    sampler, pixels, light = _sampler(_ball(material), tmp_path / "file", coefficients=1.0)

    def all_light(directions):
        radiance = np.empty((len(directions), 3), np.float32)
        eval_environment_many(light.lookup, directions.astype(np.float32), radiance)
        return radiance

    truth = []
    for normal, wo in zip(pixels.lobes.normal, pixels.lobes.wo, strict=True):
        normal, wo = normal.astype(np.float64), wo.astype(np.float64)
        if alpha is None:
            truth.append(integrate_diffuse(all_light, COLOR, normal, side=200))
        else:
            truth.append(integrate_glossy(all_light, COLOR, alpha, normal, wo, side=300))
    error = np.abs(sampler.unoccluded() / truth - 1.0)
    assert len(error) > 25
    assert error.mean() < mean and error.max() < worst


@pytest.mark.parametrize("name", ["plastic", "metal", "tinted metal"])
def test_all_curves_add_up_to_the_brdf(name, table_dir):
    """I_s of every Fresnel curve's parts is that of mode UNBIASED, which evaluates the BRDF.

    2 % on average at 5 % of the coefficients: real HDRIs are off by 3 to 12 %, this one is smooth.
    """
    material = {
        "plastic": principled(base_color=COLOR, roughness=0.4),
        "metal": principled(base_color=COLOR, metallic=1.0, roughness=0.4),
        "tinted metal": principled(
            base_color=COLOR, metallic=1.0, roughness=0.4, specular_tint=(0.9, 0.6, 0.3)
        ),
    }[name]
    scene = _ball(material, 10)
    settings = {"max_samples": 256, "stop_rule": "FIXED", "cache_dir": table_dir}
    paper, _ = make_picture(scene, estimator="PAPER", **(settings | {"max_samples": 8}))
    unbiased, _ = make_picture(scene, estimator="UNBIASED", **settings)
    shown = unbiased["samples"][..., 0] > 0
    ratio = paper["unoccluded"][shown] / unbiased["unoccluded"][shown]
    assert np.abs(ratio - 1.0).mean() < 0.02


def test_picture_is_unoccluded_light_times_visibility(table_dir):
    """I_d = I_s K / N in every pixel and channel; K / N <= 1."""
    layers, _ = make_picture(varied_scene(), estimator="PAPER", max_samples=40, cache_dir=table_dir)
    direct = layers["combined"][..., :3] - layers["emission"]
    shaded = layers["samples"][..., 0] > 0
    expected = layers["unoccluded"] * layers["visibility"]
    np.testing.assert_allclose(direct[shaded], expected[shaded], rtol=1e-5)  # float32
    seen = layers["visibility"][..., 0] * layers["samples"][..., 0]
    np.testing.assert_allclose(seen, np.round(seen), atol=1e-4)  # K is a whole number


def test_error_is_equation_7(table_dir):
    """e_d^2 = (N - K) / (N K), what equation 7 is for zeros and ones."""
    settings = {"estimator": "PAPER", "stop_rule": "PAPER", "max_samples": 40}
    layers, _ = make_picture(varied_scene(), cache_dir=table_dir, **settings)
    n, share = layers["samples"][..., 0], layers["visibility"][..., 0]
    seen = share > 0.0
    k = np.round(share[seen] * n[seen])
    expected = np.sqrt((n[seen] - k) / (n[seen] * k))
    # sums of equal squares cancel to 1e-16 of themselves where all is seen: its root is 1e-8
    np.testing.assert_allclose(layers["error"][..., 0][seen], expected, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("material", ["diffuse", "alpha 0.2"])
def test_shadows_are_those_of_the_truth(material, table_dir):
    """A corner with shadows, smooth light: luminance within 5 % of the quadrature.

    I_s is off by 1 %; the visibility is weighed by the product of the nearest normal and wo, each
    up to 2.2 degrees off (alpha .2: 11 degrees), at 5 % of the coefficients. Only luminance: one
    K / N for all channels takes the colour out of shadows, that is equation 2.
    """
    scene = corner_scene("gradient", material)
    truth = corner_truth(scene, "gradient", material)
    layers, _ = make_picture(
        scene, estimator="PAPER", max_samples=256, stop_rule="FIXED", cache_dir=table_dir
    )
    mean = layers["combined"][..., :3].mean((0, 1))
    weights = (0.2126, 0.7152, 0.0722)
    assert mean @ weights == pytest.approx(truth @ weights, rel=0.05)


def test_shares_add_up_and_dark_points_are_not_lit(table_dir):
    """Parts are chosen with probabilities; a point that reflects nothing is told apart."""
    sampler, pixels, _ = _sampler(varied_scene(), table_dir)
    total = sampler.products.share.sum(1)
    black = pixels.rows == 4
    np.testing.assert_allclose(total[~black], 1.0, atol=1e-6)  # float32
    assert not total[black].any() and black.any()
    np.testing.assert_array_equal(sampler.lit(), ~black)


def test_rays_carry_the_unoccluded_light(table_dir):
    """Every ray leaves its face and brings I_s; those below the face are left out."""
    sampler, pixels, _ = _sampler(varied_scene(), table_dir)
    rays = all_rays(sampler, np.flatnonzero(sampler.lit()), 16)
    np.testing.assert_array_equal(rays.diffuse + rays.glossy, sampler.unoccluded()[rays.point])
    normal = pixels.points.geometric_normal[rays.point]
    assert ((rays.directions * normal).sum(-1) > 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(rays.directions, axis=-1), 1.0, atol=1e-6)
