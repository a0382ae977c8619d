"""product.py, product_build.py, lobe_cells.py, warp.py: light x BSDF, and the way down it."""

import numpy as np
import pytest

from iwis.core.bsdf.brdf import eval_brdf_cos
from iwis.core.products.product import BASE_BEGIN, BLOCK_BEGIN, BLOCK_CELLS, MAX_BLOCKS
from iwis.core.scene import EnvironmentMap
from support.scenes import (
    constant_world,
    diffuse,
    glossy,
    gradient_world,
    one_texel_world,
    principled,
)
from support.statistics import chi2_p_value, sidak
from support.warps import PointProduct, light_of, square_points

MATERIALS = {
    "diffuse": diffuse((0.7, 0.5, 0.2)),
    "rough": glossy(0.6),
    "shiny": glossy(0.05),
    "sharp": glossy(0.01),
    "mirror": glossy(0.0001),
    "coat": principled(roughness=0.05),
    "varnish": principled(roughness=0.1),
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
    """core.sampling.light_rays.Light by name."""
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
    pdf = _product(lights, light, material).whole_pdf()
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
@pytest.mark.parametrize("material", ["diffuse", "shiny", "coat"])
def test_warp_is_distributed_by_its_density(light, material, lights, rng):
    """chi-square of PCG64 points in 16 x 16 cells of the sphere (64 x 64 for a sun, that
    would fill two of them).

    alpha 1e-3 over the nine tests. The twin, a density 5 % too high in every other column of cells,
    is rejected at the same level.
    """
    n, side = 400_000, 64 if light == "sun and sky" else 16
    product = _product(lights, light, material)
    pdf = product.whole_pdf()
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

    Compared where a cell's 6.3 degrees change neither factor much: above the horizon, lobes of
    alpha .09 and up. Only efficiency hangs on it, not the mean: 5 % on average will do
    (measured: 0.6 % diffuse, 4 % where the Fresnel curve is stood for by two numbers).
    """
    product, cells = _product(lights, "gradient", material), lights["gradient"].cells
    directions = np.stack([cells.x, cells.y, cells.z], -1)
    above = directions @ NORMAL.astype(np.float32) > 0.2
    directions, light = directions[above], cells.light[above]
    brdf = np.array([eval_brdf_cos(product.lobes, 0, *d) for d in directions])
    expected = light * ((brdf[:, :3] + brdf[:, 3:]) @ (0.2126, 0.7152, 0.0722))
    ratio = product.pdf(directions) / expected
    assert np.abs(ratio / np.median(ratio) - 1.0).mean() < 0.05


def test_steep_cells_are_cut(lights):
    """The narrower the lobe, the more blocks, and never too many; none for a Lambert lobe, and none
    where samples follow the lobe itself."""
    blocks = {
        name: int(_product(lights, "hdri", name).products.blocks[0])
        for name in ("diffuse", "rough", "shiny", "sharp", "mirror", "coat")
    }
    assert blocks["diffuse"] == 0 and blocks["rough"] < blocks["shiny"] < blocks["sharp"]
    assert blocks["mirror"] == blocks["coat"] == 0
    assert max(blocks.values()) <= MAX_BLOCKS


@pytest.mark.parametrize("material", ["shiny", "sharp", "varnish"])
def test_blocks_add_up_to_the_cells_they_cut(material, lights):
    """The sum of all is that of the base's cells, and each cut cell that of its block's."""
    products = _product(lights, "hdri", material).products
    tree, links = products.trees[0].astype(np.float64), products.links[0]
    assert tree[0] == pytest.approx(tree[BASE_BEGIN : BASE_BEGIN + 1024].sum(), rel=1e-5)  # float32
    cut = np.flatnonzero(links[:1024])
    assert 0 < len(cut) <= products.blocks[0]
    for cell in cut:
        begin = BLOCK_BEGIN + BLOCK_CELLS * (links[cell] - 1)
        total = tree[begin : begin + BLOCK_CELLS].sum()
        assert tree[BASE_BEGIN + cell] == pytest.approx(total, rel=1e-5)


def test_narrow_lobes_are_left_to_their_own_samples(lights):
    """What the product leaves to the narrowest lobe: all of a mirror, none of what cells hold."""
    follow = {
        name: float(_product(lights, "hdri", name).products.follow[0])
        for name in ("diffuse", "rough", "shiny", "sharp", "mirror", "coat", "plastic")
    }
    assert follow["diffuse"] == 0.0 and follow["rough"] < 1e-3 and follow["shiny"] < 0.01
    assert follow["sharp"] < 0.2 and follow["mirror"] > 0.99
    assert 0.0 < follow["coat"] < 0.9 and follow["plastic"] < 0.01


def test_flat_lobes_are_followed_even_if_they_are_wide(lights):
    """Seen at 0.6 degrees, 100 directions stand in one cell: the lobe's own samples know better."""
    wo = np.array([np.cos(0.01), 0.0, np.sin(0.01)])
    product = PointProduct(lights["constant"], MATERIALS["plastic"], (0.0, 0.0, 1.0), wo)
    assert 0.3 < product.products.follow[0] <= 0.4


def test_narrow_lobes_get_their_own_cells(lights):
    """At alpha .01 the density follows the BSDF inside one cell of the base.

    Twenty directions round the mirrored wo, under constant light: L B / pdf varies by a tenth of
    what B does. (B varies by a factor of 60; a cell of 512^2 is 0.4 degrees wide, the lobe 1.)
    """
    product = _product(lights, "constant", "sharp")
    mirrored = 2.0 * (NORMAL @ WO) * NORMAL - WO
    side = np.cross(NORMAL, WO)
    side /= np.linalg.norm(side)
    turn = np.linspace(-0.03, 0.03, 20)[:, None]
    directions = np.cos(turn) * mirrored + np.sin(turn) * side
    brdf = np.array([eval_brdf_cos(product.lobes, 0, *d)[3] for d in directions.astype(np.float32)])
    ratio = np.log(brdf / product.pdf(directions))
    assert brdf.max() > 20.0 * brdf.min()
    assert ratio.std() < 0.25 * np.log(brdf).std()


@pytest.mark.parametrize("material", ["diffuse", "plastic"])
def test_no_lit_direction_has_density_zero(material, lights, rng):
    """Wherever the cosine is above 0, up to the corners of cells at the horizon."""
    for _ in range(20):
        normal, wo = rng.standard_normal((2, 3))
        normal /= np.linalg.norm(normal)
        wo = normal + 0.3 * wo / np.linalg.norm(wo)
        product = PointProduct(
            lights["constant"], MATERIALS[material], normal, wo / np.linalg.norm(wo)
        )
        # Grazing directions: 1e-6 ... 0.1 above the horizon.
        side = np.cross(normal, rng.standard_normal((2000, 3)))
        side /= np.linalg.norm(side, axis=1)[:, None]
        height = 10.0 ** rng.uniform(-6.0, -1.0, (2000, 1))
        directions = np.sqrt(1.0 - height**2) * side + height * normal
        assert product.pdf(directions).min() > 0.0


def test_product_cells_are_the_pyramids(lights):
    """All cells of the base, each once, with the pyramid's light."""
    light = lights["hdri"]
    expected = light.pyramid.averages[BASE_BEGIN : BASE_BEGIN + 1024]
    np.testing.assert_array_equal(light.cells.light, expected)


def test_cones_hold_their_cells(lights, rng):
    """A group is left out for a normal only where none of its cells could have a lit corner."""
    cells = lights["hdri"].cells
    directions = np.stack([cells.x, cells.y, cells.z], -1)
    left_out = 0
    for normal in rng.standard_normal((500, 3)).astype(np.float32):
        normal /= np.linalg.norm(normal)
        below = np.repeat(cells.groups[:, :3] @ normal <= cells.groups[:, 3], 16)
        assert (directions[below] @ normal < -2.15 / 16).all()
        left_out += below.mean() / 500
    assert left_out > 0.25  # 43 % of the cells are below; groups at the horizon stay


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
