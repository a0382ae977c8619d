"""core/product.py: the product of light and BSDF, and the warp through it."""

import numpy as np
import pytest

from iwis.core.brdf import eval_brdf_cos
from iwis.core.lobes import setup_lobes
from iwis.core.product import NARROW_LEVEL, WIDE_LEVEL, choose_level, product_cells
from iwis.core.pyramid import level_offset
from iwis.core.scene import EnvironmentMap
from support.scenes import (
    constant_world,
    diffuse,
    glossy,
    gradient_world,
    make_materials,
    one_texel_world,
    principled,
)
from support.statistics import chi2_p_value, sidak
from support.warps import PointProduct, light_of, square_points

MATERIALS = {
    "diffuse": diffuse((0.7, 0.5, 0.2)),
    "rough": glossy(0.6),
    "shiny": glossy(0.05),
    "mirror": glossy(0.002),
    "plastic": principled(roughness=0.3),
    "metal": principled(metallic=1.0, roughness=0.7, base_color=(0.9, 0.6, 0.2)),
}
NORMAL = np.array([0.48, -0.6, 0.64])
WO = np.array([0.36, 0.48, 0.8])


def _noise_world():
    """An HDRI of noise over four decades: every level of the quadtree has something to choose."""
    noise = np.random.default_rng(5).standard_normal((32, 64, 3))
    return EnvironmentMap(radiance=np.exp(1.5 * noise).astype(np.float32))


@pytest.fixture(scope="module")
def lights():
    """core.light_rays.Light by name."""
    worlds = {
        "hdri": _noise_world(),
        "sun": one_texel_world(32, 22, 40, 1e5),
        "sun and sky": one_texel_world(32, 22, 40, 1e5, ground=0.5),
        "constant": constant_world(),
        "gradient": gradient_world(),
    }
    return {name: light_of(world) for name, world in worlds.items()}


def _product(lights, light, material):
    return PointProduct(lights[light], MATERIALS[material], NORMAL, WO)


CASES = [(light, material) for light in ("hdri", "sun", "constant") for material in MATERIALS]


@pytest.mark.parametrize(("light", "material"), CASES)
def test_density_integrates_to_one(light, material, lights):
    """Over all cells of the light's finest level, where it is constant: exact but for rounding."""
    pdf = _product(lights, light, material).finest_pdf()
    # float32 trees of 12 levels: the sums of the levels agree to 1e-6
    assert pdf.mean() * 4.0 * np.pi == pytest.approx(1.0, abs=1e-5)
    assert pdf.min() >= 0.0


@pytest.mark.parametrize(("light", "material"), CASES)
def test_warp_returns_the_density_at_its_direction(light, material, lights, rng):
    """pdf of the warp = pdf_product there, for all points; directions are unit."""
    product = _product(lights, light, material)
    directions, pdf = product.warp(rng.random((5000, 2)))
    np.testing.assert_allclose(np.linalg.norm(directions, axis=-1), 1.0, atol=5e-7)  # float32
    # float32, other order. A direction within 1e-7 of a cell's border is rounded over it: at most
    # 2 x 512 borders x 1e-7 of the points, times the ten cases where it may happen, once in 5000.
    differs = np.abs(product.pdf(directions) / pdf - 1.0) > 1e-5
    assert differs.sum() <= 5
    assert (pdf > 0.0).all()


@pytest.mark.parametrize("point", [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)])
def test_corners_of_the_square_get_light(point, lights):
    """0 and the largest number below 1 neither leave the sphere nor land where nothing is."""
    point = np.minimum(point, 1.0 - 2.0**-53)
    for light in ("sun", "hdri"):
        product = _product(lights, light, "diffuse")
        directions, pdf = product.warp(point[None])
        assert np.isfinite(directions).all() and pdf[0] > 0.0


@pytest.mark.statistical
@pytest.mark.parametrize("light", ["hdri", "sun and sky", "constant"])
@pytest.mark.parametrize("material", ["diffuse", "shiny", "plastic"])
def test_warp_is_distributed_by_its_density(light, material, lights, rng):
    """chi-square of PCG64 points in 16 x 16 cells of the sphere (64 x 64 for a sun, that
    would fill two of them).

    alpha 1e-3 over the nine tests. The twin, a density 5 % too high in every other column of cells,
    is rejected at the same level.
    """
    n, side = 400_000, 64 if light == "sun and sky" else 16
    product = _product(lights, light, material)
    pdf = product.finest_pdf()
    share = pdf.reshape(side, len(pdf) // side, side, -1).sum((1, 3)) / pdf.sum()
    directions, _ = product.warp(rng.random((n, 2)))
    x, y = square_points(directions).T
    observed, _, _ = np.histogram2d(y, x, side, [[0, 1], [0, 1]])
    assert chi2_p_value(observed, n * share) > sidak(1e-3, 9)
    wrong = share * np.where(np.arange(side) % 2, 1.05, 1.0)
    assert chi2_p_value(observed, n * wrong / wrong.sum()) < sidak(1e-3, 9)


@pytest.mark.parametrize("material", ["diffuse", "rough", "metal", "plastic"])
def test_cells_follow_light_times_brdf(material, lights):
    """The density is what it stands for: L B over the integral of L B, within what a cell blurs.

    Compared where a cell's 6.3 (2.8) degrees change neither factor much: above the horizon, lobes
    of alpha .09 and up. Only efficiency hangs on it, not the mean: 5 % on average will do
    (measured: 0.6 % diffuse, 4 % where the Fresnel curve is stood for by two numbers).
    """
    product = _product(lights, "gradient", material)
    cells = product_cells(lights["gradient"].pyramid, WIDE_LEVEL)
    directions = np.stack([cells.x, cells.y, cells.z], -1)
    above = directions @ NORMAL.astype(np.float32) > 0.2
    directions, light = directions[above], cells.light[above]
    brdf = np.array([eval_brdf_cos(product.lobes, 0, *d) for d in directions])
    expected = light * ((brdf[:, :3] + brdf[:, 3:]) @ (0.2126, 0.7152, 0.0722))
    ratio = product.pdf(directions) / expected
    assert np.abs(ratio / np.median(ratio) - 1.0).mean() < 0.05


@pytest.mark.parametrize(
    ("material", "level"),
    [("diffuse", WIDE_LEVEL), ("rough", WIDE_LEVEL), ("shiny", NARROW_LEVEL)],
)
def test_narrow_lobes_get_finer_cells(material, level, lights):
    """64^2 cells below alpha .5, 32^2 else."""
    assert _product(lights, "constant", material).level == level


def test_glossy_points_alone_decide():
    """alpha of a material without gloss means nothing."""
    up = np.float32([[0, 0, 1]])
    lobes = setup_lobes(make_materials(diffuse(roughness=0.1)), up, up, up)
    assert choose_level(lobes, 0) == WIDE_LEVEL


@pytest.mark.parametrize("level", [WIDE_LEVEL, NARROW_LEVEL])
def test_product_cells_are_the_pyramids(level, lights):
    """All cells of the level, each once, with the pyramid's light."""
    pyramid = lights["hdri"].pyramid
    cells = product_cells(pyramid, level)
    assert sorted(cells.morton) == list(range(4**level))
    begin = level_offset(level)
    np.testing.assert_array_equal(cells.light, pyramid.averages[begin + cells.morton])


def test_black_light_has_an_empty_product():
    """total 0 is how a sampler knows that nothing is to be had."""
    assert PointProduct(light_of(constant_world((0, 0, 0))), MATERIALS["plastic"]).total == 0.0


@pytest.mark.parametrize("azimuth", [0, 20, 45, 70])
def test_suns_that_just_touch_the_horizon_are_not_lost(azimuth):
    """A cell whose centre is below the horizon keeps some density if its rim is above.

    One texel of light stands 1 degree above the horizon of a tilted surface.
    """
    height, row = 256, 128 + 40
    column = 100 + azimuth
    latitude = ((row + 0.5) / height - 0.5) * np.pi
    longitude = (0.5 - (column + 0.5) / (2 * height)) * 2.0 * np.pi
    sun = np.array(
        [
            np.cos(latitude) * np.cos(longitude),
            np.cos(latitude) * np.sin(longitude),
            np.sin(latitude),
        ]
    )
    side = np.cross(sun, (0.0, 0.0, 1.0))
    side /= np.linalg.norm(side)
    light = light_of(one_texel_world(height, row, column))
    for turn in np.linspace(0.0, 2.0 * np.pi, 9):
        across = np.cos(turn) * side + np.sin(turn) * np.cross(side, sun)
        normal = np.cos(np.radians(89.0)) * sun + np.sin(np.radians(89.0)) * across
        product = PointProduct(light, diffuse(), normal, normal)
        assert product.total > 0.0 and product.pdf(sun[None])[0] > 0.0
