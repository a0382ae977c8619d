"""Lobes with thin films (core/bsdf/thin_film_setup.py), in brdf.py and the product's cells."""

import numpy as np
import pytest

from iwis.core import render
from iwis.core.bsdf.lobes import THIN_FILM
from iwis.core.bsdf.stretched import stretch_lobes
from iwis.core.bsdf.thin_film import dielectric_film
from iwis.core.bsdf.thin_film_setup import FilmValues, set_film
from iwis.core.bsdf.thin_film_tables import GAUSSIANS, REC709
from iwis.core.data.program import Closure, Program, ThinFilm
from iwis.core.nodes.layers import through_glass
from iwis.core.products.lobe_cells import gloss_at
from iwis.core.scene import GGX, GLOSSY, MULTI_GGX, PRINCIPLED
from iwis.core.settings import RenderSettings
from iwis.core.surfaces.surface import closure_layers
from support.brdf_points import directions, evaluated, material, points
from support.programs import with_programs
from support.samplers import pixel_points
from support.scenes import camera_above, constant_world, floor, make_scene, principled
from support.thin_films import GOLD, dielectric, edge_of, fresnel_of, metal
from support.warps import PointProduct, light_of

_F = np.float32


def _film(n, thickness=350.0, ior=1.33, space=REC709, indices=(None, None)):
    numbers = (np.full(n, value, np.float32) for value in (thickness, ior))
    own = [None if m is None else np.tile(_F(m), (n, 1)) for m in indices]
    return FilmValues(space, *numbers, *own)


def _filmed(wo, film=None, **values):
    """Lobes of a Principled BSDF with a film, seen from wo (n, 3)."""
    lobes, n = points(wo, **values), len(wo)
    set_film(lobes, material(n, **values), np.arange(n), film or _film(n))
    return lobes


@pytest.mark.parametrize("thickness", (0.0, 0.05, -200.0, np.nan))
def test_no_film_changes_nothing(thickness):
    """None, one below a tenth of a nanometre, less than none, none that is a number."""
    wo = directions([0.8])
    plain = points(wo, metallic=0.4, base_color=(0.5, 0.6, 0.7))
    lobes = _filmed(wo, _film(1, thickness), metallic=0.4, base_color=(0.5, 0.6, 0.7))
    for ours, theirs in zip(lobes[:-1], plain[:-1], strict=True):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("metallic", (0.0, 1.0))
def test_films_that_are_no_numbers_reflect_some_light(metallic):
    """An index that is infinite, none, or below 0, as if it were very large or small; no end."""
    wi = _F([[-0.5, 0.2, 0.8426]])
    for thickness, ior in ((300.0, np.inf), (300.0, np.nan), (300.0, -1.0), (np.inf, 1.33)):
        lobes = _filmed(directions([0.7]), _film(1, thickness, ior), metallic=metallic)
        assert np.isfinite(lobes.glossy_color).all() and np.isfinite(lobes.diffuse).all()
        value = evaluated(lobes, 0, wi)
        assert np.isfinite(value).all() and value[0, 3:].min() > 0.0


@pytest.mark.parametrize("metallic", (0.0, 0.6, 1.0))
@pytest.mark.parametrize("grain", (0.0, 1.5))
def test_gloss_is_that_of_its_facets_times_their_color(metallic, grain):
    """Beside a mirror of the same roughness that reflects all; brushed, too."""
    wo, rng = directions([0.7]), np.random.default_rng(5)
    wi = rng.normal(size=(500, 3))
    wi[:, 2] = np.abs(wi[:, 2]) + 0.05
    wi = _F(wi / np.linalg.norm(wi, axis=1)[:, None])
    base, tint = (0.8, 0.5, 0.3), (0.9, 0.7, 0.5)
    own = {"roughness": 0.6, "distribution": GGX}
    lobes = _filmed(wo, metallic=metallic, base_color=base, specular_tint=tint, **own)
    white = points(wo, model=GLOSSY, **own)
    if grain:
        for each in (lobes, white):
            stretch_lobes(each, _F([0.6]), _F([[grain, 0.0, 0.0]]))
    facets = evaluated(white, 0, wi)[:, 3]
    half = wi + wo
    cosines = (half * wo).sum(1) / np.linalg.norm(half, axis=1)
    fresnel, level = fresnel_of(1.5), _F(0.04) * _F(tint)
    for i in np.flatnonzero(facets > 1e-3)[:60]:
        film = _F(350.0), _F(1.33), _F(REC709)
        clear = np.array(dielectric_film(film, fresnel, tuple(level), cosines[i]))
        steel = metal(350.0, 1.33, base, edge_of(base, tint), cosines[i])
        color = (1.0 - metallic) * clear + metallic * steel
        np.testing.assert_allclose(evaluated(lobes, 0, wi)[i, 3:], facets[i] * color, rtol=2e-3)


@pytest.mark.parametrize("distribution", (GGX, MULTI_GGX))
def test_paint_gets_what_a_mirror_with_the_film_leaves(distribution):
    """As Cycles estimates it; Glossy Color is the rest, of the most reflective channel."""
    wo, base = directions([0.5]), (0.8, 0.8, 0.8)
    lobes = _filmed(wo, base_color=base, distribution=distribution, roughness=0.3)
    plain = points(wo, base_color=base, distribution=distribution, roughness=0.3)
    np.testing.assert_allclose(lobes.diffuse[0], 0.8 * (1.0 - lobes.glossy_color[0].max()), 1e-6)
    color = dielectric(350.0, 1.33, 1.5, 0.5)
    ratio = lobes.glossy_color[0] / color
    assert np.ptp(ratio) < 1e-5 and ratio[0] == pytest.approx(1.0, abs=0.03)
    assert lobes.kind[0] == plain.kind[0] | THIN_FILM
    np.testing.assert_array_equal(lobes.weight, plain.weight)  # later bounces as without a film


def test_film_is_seen_on_what_reflects_nothing_itself():
    """Of index 1: all that is mirrored is the film's own."""
    lobes = _filmed(directions([0.9]), ior=1.0, base_color=(0.0, 0.0, 0.0))
    assert lobes.kind[0] & THIN_FILM
    expected = dielectric(350.0, 1.33, 1.0, 0.9)
    np.testing.assert_allclose(lobes.glossy_color[0], expected, rtol=1e-5)
    assert expected.max() > 0.01


def test_metals_have_no_film_in_blender_4():
    """Its own Cycles' way: the dielectric beside it has one."""
    own = {"metallic": 1.0, "base_color": (0.8, 0.5, 0.3), "specular_tint": (0.9, 0.7, 0.5)}
    wo, wi = directions([0.7]), _F([[-0.5, 0.2, 0.8426]])
    plain = points(wo, **own)
    lobes = _filmed(wo, _film(1, space=GAUSSIANS), **own)
    np.testing.assert_allclose(lobes.glossy_color, plain.glossy_color, rtol=1e-6)
    np.testing.assert_allclose(evaluated(lobes, 0, wi), evaluated(plain, 0, wi), rtol=1e-5)


def test_later_bounces_of_a_metal_by_indices_are_its_own():
    """Roughness 1 beside a mirror along the normal, as Blender 5.2's Glossy Color has it."""
    own = {"metallic": 1.0, "roughness": 1.0, "distribution": MULTI_GGX}
    lobes = _filmed(directions([1.0]), _film(1, 240.0, 1.33, indices=GOLD), **own)
    mirror = _filmed(directions([1.0]), _film(1, 240.0, 1.33, indices=GOLD), metallic=1.0)
    ratio = lobes.glossy_color[0] / mirror.glossy_color[0]
    np.testing.assert_allclose(ratio, (0.9460, 0.7641, 0.4671), atol=2e-4)


def test_glass_lets_through_what_its_film_does_not_mirror():
    """Of a ray along the normal."""

    class Seen:
        normal = geometric_normal = _F([[0.0, 0.0, 1.0]])
        wo, shadow, backfacing = directions([1.0]), False, _F(0.0)

        def __len__(self):
            return 1

    one = np.ones(3, np.float32)
    inputs = {"Weight": one, "Tint": one, "IOR": _F(1.5), "Roughness": _F(0.2)}
    inputs |= {"Thickness": _F(350.0), "Film IOR": _F(1.8)}
    found = through_glass(Seen(), {"space": REC709}, inputs)
    mirrored = dielectric(350.0, 1.8, 1.5, 1.0)
    np.testing.assert_allclose(found[""][0], 1.0 - mirrored.max(), rtol=1e-5)


def test_products_cells_know_the_film():
    """Their curve goes through what the film mirrors, where that is not far below the rest."""
    lobes = _filmed(directions([0.6]), metallic=1.0, base_color=(0.9, 0.6, 0.3))
    cell = gloss_at(lobes, 0, _F(0.0))
    bent = 0.4**5
    own = lobes.glossy_color[0] @ [0.2126, 0.7152, 0.0722]
    assert cell.head_on * (1.0 - bent) + cell.grazing * bent == pytest.approx(own, rel=1e-3)


def test_samples_of_the_product_fit_the_film(rng):
    """In even light, rough metal: weights spread by .2 to .3 of the mean, as without a film."""
    own = {"metallic": 1.0, "base_color": (0.9, 0.6, 0.3), "roughness": 0.5}
    params = material(1, **own)
    product = PointProduct(
        light_of(constant_world()),
        principled(**own),
        wo=(0.0, 0.6, 0.8),
        change=lambda lobes: set_film(lobes, params, np.arange(1), _film(1, 300.0)),
    )
    assert product.lobes.kind[0] & THIN_FILM
    wi, pdf = product.warp(rng.random((20_000, 2)))
    weight = evaluated(product.lobes, 0, _F(wi)).sum(axis=1) / pdf
    assert weight.std() < 0.35 * weight.mean()


_FILM = ThinFilm(_F(350.0), _F(1.33), REC709)
_HALF = np.full(3, 0.5, np.float32)


def _floor(*closures):
    scene = make_scene([floor()], [principled()], constant_world(), camera_above(8, 6))
    return with_programs(scene, Program(ops=(), closures=closures))


def test_half_a_closure_has_the_whole_film():
    """Its weight is of the light, not of the film's numbers; the other half has none."""
    whole = Closure(PRINCIPLED, GGX, np.ones(3, np.float32), {}, film=_FILM)
    half, plain = whole._replace(weight=_HALF), whole._replace(weight=_HALF, film=None)
    scene, mixed = _floor(whole), _floor(half, plain)
    points = pixel_points(scene).points
    (alone,), layers = closure_layers(scene, points), closure_layers(mixed, points)
    np.testing.assert_array_equal(layers[0].lobes.tint, alone.lobes.tint)
    np.testing.assert_allclose(layers[0].lobes.tint[0], (350.0, 1.33, REC709))
    wi = _F([[0.1, -0.2, 0.9747]])
    ours, all_of_it = (evaluated(own.lobes, 0, wi) for own in (layers[0], alone))
    np.testing.assert_allclose(ours, 0.5 * all_of_it, rtol=1e-5)
    assert not (layers[1].lobes.kind & THIN_FILM).any()


def test_mode_paper_says_that_it_leaves_films_out():
    """Its tables are those of the material's row."""
    closure = Closure(PRINCIPLED, GGX, np.ones(3, np.float32), {})
    for film, told in ((None, 0), (_FILM, 1)):
        warnings = []
        scene = _floor(closure._replace(film=film))
        render._as_settings_show(scene, RenderSettings(estimator="PAPER"), warnings)
        assert sum("thin films" in line for line in warnings) == told
