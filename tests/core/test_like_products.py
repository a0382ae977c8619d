"""like_products.py: points that are alike share a product, and lose no light by it."""

import numpy as np
import pytest
import seeds

from iwis.core._jit import kernel
from iwis.core.bsdf.lobe_setup import setup_lobes
from iwis.core.bsdf.lobes import DIFFUSE_LOBE
from iwis.core.geometry.shading import ShadingPoints
from iwis.core.products.like_products import (
    ALIKE,
    NEARLY_ALIKE,
    build_products,
    new_product_scratch,
)
from iwis.core.products.product import new_products
from iwis.core.sampling.unbiased_rays import UnbiasedSampler
from iwis.core.scene import EnvironmentMap, MaterialParams
from support.brdf_points import material
from support.samplers import all_rays, random_sequence
from support.scenes import constant_world, diffuse, glossy, principled
from support.warps import PointProduct, light_of

UP = np.array([0.48, -0.6, 0.64])
SEEN_FROM = np.array([0.36, 0.48, 0.8])
NONE = np.float32(0.0)


def _unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def _turned(normal, angle, rng, n):
    """n unit vectors at an angle from one."""
    side = _unit(np.cross(normal, rng.standard_normal((n, 3))))
    return np.cos(angle) * normal + np.sin(angle) * side


@kernel
def _build(lobes, apart, light, products, scratch):
    build_products(lobes, 0, len(lobes.kind), apart, light, products, scratch)


def _lobes(normal, wo, *looks):
    """Lobes of points, float (n, 3), which have the looks by turns."""
    normal, wo = normal.astype(np.float32), np.broadcast_to(wo, normal.shape).astype(np.float32)
    rows = [material(1, **looks[p % len(looks)]) for p in range(len(normal))]
    params = MaterialParams(*(np.concatenate(column) for column in zip(*rows, strict=True)))
    return setup_lobes(params, normal, normal, wo)


def _products(lobes, apart):
    """Products of points in constant light."""
    products = new_products(len(lobes.kind), True)
    _build(lobes, apart, light_of(constant_world()), products, new_product_scratch())
    return products


@pytest.mark.parametrize("look", ["diffuse", "metal", "plastic"])
def test_no_horizon_of_those_that_share_is_dark(look, rng):
    """A product made for normals up to an angle apart has a density wherever one of them is lit.

    One for its own normal alone has not: at .2 rad, for cells of the base reach .13 down.
    """
    angle = np.float32(0.2)
    looks = {"diffuse": diffuse(), "metal": glossy(0.2), "plastic": principled(roughness=0.3)}
    light = light_of(constant_world())
    normals = _turned(UP, angle, rng, 500)
    along = _unit(np.cross(normals, rng.standard_normal((500, 3))))
    low = _unit(along + 1e-3 * normals)  # just above the horizon of each
    shared = PointProduct(light, looks[look], UP, SEEN_FROM, turned=angle)
    assert (shared.pdf(low) > 0.0).all()
    alone = PointProduct(light, looks[look], UP, SEEN_FROM)
    assert (alone.pdf(low) == 0.0).any()


def test_products_are_built_for_the_angle_that_points_may_be_apart(rng):
    """One product of 400 points, whose normals are all but .2 rad from the first one's: none is
    dark just above its own horizon. Made for the first normal alone it is, for some (the twin)."""
    angle = np.float32(0.2)
    normals = np.concatenate([UP[None], _turned(UP, 0.99 * angle, rng, 400)])
    products = _products(_lobes(normals, SEEN_FROM, {"specular_level": 0.0}), angle)
    assert (products.own == 0).all()
    low = _unit(_unit(np.cross(normals, rng.standard_normal((401, 3)))) + 1e-3 * normals)
    product = PointProduct(light_of(constant_world()), diffuse(), UP, SEEN_FROM)
    assert (product.pdf(low) == 0.0).any()
    product.products = products
    assert (product.pdf(low) > 0.0).all()


@pytest.mark.slow
@pytest.mark.parametrize("apart", [NEARLY_ALIKE, ALIKE])
@pytest.mark.parametrize("parameters", [{"metallic": 0.0}, {"metallic": 1.0, "roughness": 0.3}])
def test_products_come_from_points_that_are_alike(apart, parameters, rng):
    """On a ball: no normals farther apart than asked, and fewer products than points."""
    normal = np.repeat(_unit(UP + 0.05 * rng.standard_normal((200, 3))), 2, axis=0)
    lobes = _lobes(normal, SEEN_FROM, parameters)
    products = _products(lobes, apart)
    own = products.own
    assert (own[own] == own).all() and (own <= np.arange(len(own))).all()
    angle = np.arccos(np.clip((lobes.normal * lobes.normal[own]).sum(1), -1.0, 1.0))
    assert angle.max() < apart * 1.05 + 5e-4  # float32's acos
    assert len(np.unique(own)) < 0.51 * len(own)
    assert (products.follow == products.follow[own]).all()
    assert (products.blocks == products.blocks[own]).all()


def test_a_plane_has_one_product(rng):
    """Whatever its colour: a Lambert lobe's product has the same shape."""
    matte = {"specular_level": 0.0}
    looks = [matte | {"base_color": tuple(rng.uniform(0.05, 0.9, 3))} for _ in range(64)]
    lobes = _lobes(np.tile(UP, (64, 1)), SEEN_FROM, *looks)
    assert (lobes.kind == DIFFUSE_LOBE).all()
    assert (_products(lobes, NEARLY_ALIKE).own == 0).all()


@pytest.mark.parametrize(
    "other",
    [
        {"roughness": 0.4},
        {"metallic": 1.0},
        {"base_color": (0.1, 0.1, 0.1)},
        {"specular_level": 0.0},
        {"specular_level": 1.0},
    ],
)
def test_other_materials_have_products_of_their_own(other):
    """Points of one place, in turn of two materials."""
    lobes = _lobes(np.tile(UP, (8, 1)), SEEN_FROM, {"roughness": 0.3}, {"roughness": 0.3} | other)
    np.testing.assert_array_equal(_products(lobes, ALIKE).own, [0, 1] * 4)


@pytest.mark.parametrize(("roughness", "apart"), [(0.2, True), (0.8, False)])
def test_gloss_that_mirrors_another_way_has_a_product_of_its_own(roughness, apart):
    """Points of a plane that are seen from all round, 12 degrees apart: narrow lobes do not share,
    though normals and cosines are the same; of wide ones some do."""
    turn = 2.0 * np.pi * np.arange(30) / 30
    side, other = _unit(np.cross(UP, SEEN_FROM)), np.cross(UP, _unit(np.cross(UP, SEEN_FROM)))
    around = np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * other
    wo = 0.8 * UP + 0.6 * around
    lobes = _lobes(np.tile(UP, (30, 1)), wo, {"metallic": 1.0, "roughness": roughness})
    own = _products(lobes, ALIKE).own
    assert (len(np.unique(own)) == 30) == apart


def test_stretched_gloss_sheen_and_toon_do_not_share():
    """Their products are made of more than what points are compared by."""
    lobes = _lobes(np.tile(UP, (4, 1)), SEEN_FROM, {"metallic": 1.0, "roughness": 0.3})
    assert (_products(lobes, ALIKE).own == 0).all()
    stretched = lobes._replace(narrow=np.full(4, 0.02, np.float32))
    np.testing.assert_array_equal(_products(stretched, ALIKE).own, np.arange(4))
    matte = _lobes(np.tile(UP, (4, 1)), SEEN_FROM, {"specular_level": 0.0})
    assert (_products(matte, ALIKE).own == 0).all()
    for kind in (-1.0, -2.0, -3.0, -4.0):  # sheen and toon
        rough = np.tile(np.float32([0.5, 0.0, 0.2, kind]), (4, 1))
        own = _products(matte._replace(rough=rough), ALIKE).own
        np.testing.assert_array_equal(own, np.arange(4))


def _samples(light, normal, wo, apart, count, **parameters):
    """What each sample of each point brings, float64 (n, count), without shadows."""
    n = len(normal)
    normal, wo = normal.astype(np.float32), wo.astype(np.float32)
    zeros = np.zeros((n, 3), np.float32)
    points = ShadingPoints(
        *(np.zeros(n, np.int32) for _ in range(2)),
        *(zeros, wo, normal, normal, zeros),
        np.zeros(n, np.float32),
        zeros,
        np.zeros(n, np.int32),
    )
    lobes = setup_lobes(material(n, **parameters), normal, normal, wo)
    sequence = random_sequence(np.random.default_rng(7), n, count, "OWEN")
    sampler = UnbiasedSampler(points, lobes, light, sequence, 0.0, apart)
    rays = all_rays(sampler, np.flatnonzero(sampler.lit()), count)
    carried = (rays.diffuse + rays.glossy).astype(np.float64).sum(1)
    place = np.zeros(n, np.int64)
    found = np.zeros((n, count))
    for point, light_of_sample in zip(rays.point, carried, strict=True):
        found[point, place[point]] = light_of_sample
        place[point] += 1
    return found


@pytest.mark.parametrize("parameters", [{}, {"metallic": 1.0, "roughness": 0.4}])
@pytest.mark.parametrize("height", [0.0, 0.02, 0.5])
def test_a_sun_at_the_horizon_stays_whole_and_even(height, parameters, rng):
    """Points that share, a sun of 0.5 degrees near their horizon: the light of products of their
    own, and no sample that outshines them.

    Each mean is within 5 of its standard errors (64 points, of both); the largest sample at most
    32 times its point's mean, as test_unbiased_truth.py allows of rough lobes.
    """
    light = light_of(seeds.world("sun"))
    side = _unit(np.cross(seeds.SUN, np.array([0.3, 0.1, 0.9])))
    normal = _unit(side + height * seeds.SUN + 0.01 * rng.standard_normal((64, 3)))
    wo = _unit(normal + 0.3 * np.array([0.1, 0.8, 0.2]))
    shared = _samples(light, normal, wo, ALIKE, 1024, **parameters)
    alone = _samples(light, normal, wo, NONE, 1024, **parameters)
    error = np.sqrt((shared.var(1) + alone.var(1)) / 1024)
    apart = (shared.mean(1) - alone.mean(1)) / error
    assert np.abs(apart).max() < 5.0
    assert (shared.max(1) / shared.mean(1)).max() < 32.0
    even = light_of(EnvironmentMap(radiance=np.ones((4, 8, 3), np.float32)))
    flat = _samples(even, normal, wo, ALIKE, 64, **parameters)
    assert (flat.max(1) / flat.mean(1)).max() < 10.0
