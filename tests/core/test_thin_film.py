"""What thin films reflect (core/bsdf/thin_film.py): beside sums over wavelengths, and Cycles."""

import numpy as np
import pytest

from iwis.core.bsdf.microfacet import dielectric_blend, f82_curve, f82_edge, schlick_weight
from iwis.core.bsdf.thin_film import INDEXED
from iwis.core.bsdf.thin_film_tables import (
    ACESCG,
    GAUSSIANS,
    REC709,
    REC2020,
    film_space,
    sensitivities,
)
from iwis.core.data.observer import observer
from support.thin_films import GOLD, dielectric, edge_of, fresnel_of, metal

_F = np.float32
_TO_709 = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)


def _by_wavelengths(thickness, index, below, cosine):
    """The mean of what a film reflects of each wavelength, of all orders; below: index of what is
    under it, (3,), complex."""
    wavelengths, functions = observer()
    curves = functions @ _TO_709.T
    sine2 = 1.0 - cosine**2
    inside, under = np.sqrt(index**2 - sine2), np.sqrt(np.asarray(below) ** 2 - sine2 + 0j)
    wave = np.exp(4j * np.pi * thickness * inside / wavelengths)[:, None]
    found = 0.0
    for a, b, c in (
        (cosine, inside, under),
        (index**2 * cosine, inside, index**2 * under / np.asarray(below) ** 2),
    ):
        r12 = (a - b) / (a + b)
        r23 = (b - c) / (b + c)
        found = found + 0.5 * np.abs((r12 + r23 * wave) / (1.0 + r12 * r23 * wave)) ** 2
    return np.clip((found * curves).sum(0) / curves.sum(0), 0.0, 1.0)


@pytest.mark.parametrize("cosine", (1.0, 0.7, 0.3))
@pytest.mark.parametrize(("index", "below"), [(1.33, 1.5), (1.8, 1.2), (1.2, 2.5)])
def test_dielectric_is_the_mean_over_wavelengths(cosine, index, below):
    """But for the chords of Cycles' table, half a hundredth of what goes up and down, and the
    fourth order that it leaves out: .0023 together, where most is mirrored."""
    for thickness in (40.0, 200.0, 650.0):
        expected = _by_wavelengths(thickness, index, np.full(3, below + 0j), cosine)
        ours = dielectric(thickness, index, below, cosine)
        np.testing.assert_allclose(ours, expected, atol=2.5e-3)


@pytest.mark.parametrize("cosine", (1.0, 0.6))
def test_metal_of_indices_is_the_mean_over_wavelengths(cosine):
    """Each channel by its own indices. The fourth order is left out, as in Cycles: .0009."""
    n, k = GOLD
    for thickness in (60.0, 300.0):
        expected = _by_wavelengths(thickness, 1.4, np.array(n) + 1j * np.array(k), cosine)
        ours = metal(thickness, 1.4, n, k, cosine, REC709 | INDEXED)
        np.testing.assert_allclose(ours, expected, atol=4e-3)


@pytest.mark.parametrize("thickness", (0.2, 50.0, 900.0))
@pytest.mark.parametrize("cosine", (1.0, 0.5, 0.1))
def test_film_of_air_is_none(thickness, cosine):
    """Of index 1 it changes no curve: of dielectrics, of metals of colors, of those of indices."""
    for ior in (1.5, 2.4):
        fresnel = fresnel_of(ior)
        bare = fresnel[1] + (1.0 - fresnel[1]) * dielectric_blend(_F(cosine), *fresnel)
        for space in (REC709, GAUSSIANS):
            found = dielectric(thickness, 1.0, ior, cosine, space)
            np.testing.assert_allclose(found, bare, rtol=2e-4)
    f0, tint, s = _F(0.6), _F(0.7), schlick_weight(_F(cosine))
    edge = (f0 + (1.0 - f0) * (6.0 / 7.0) ** 5) * tint
    bare = f82_curve(f0, f82_edge(f0, tint), s, _F(cosine) * s * _F(1.0 - cosine))
    found = metal(thickness, 1.0, f0, edge, cosine)
    np.testing.assert_allclose(found, bare, rtol=2e-3)  # the phases are a conductor's


_COLORS = (0.95, 0.6, 0.1), (1.0, 0.8, 0.3)  # base color, edge tint


def test_dielectrics_are_as_cycles_shows_them():
    """Mirrors in Blender 5.2's pictures, whose table differs from ours by up to a thousandth; and
    in 4.5's, by the Gaussians of the paper, to the last digits."""
    for index, ior, thickness, cosine, shown in (
        (1.33, 1.5, 362.4023, 1.0, (0.0025893, 0.0276957, 0.0337912)),
        (1.33, 1.5, 821.7773, 0.2588190, (0.158744, 0.224552, 0.202598)),
        (2.0, 1.2, 247.5586, 0.5, (0.3228923, 0.2863523, 0.0489518)),
    ):
        found = dielectric(thickness, index, ior, cosine)
        np.testing.assert_allclose(found, shown, atol=3e-4)
    for index, ior, thickness, cosine, shown in (
        (1.33, 1.5, 362.4023, 1.0, (0.0, 0.02826996, 0.03377473)),
        (2.0, 1.2, 247.5586, 0.5, (0.3534668, 0.2806381, 0.0522101)),
        (1.33, 1.5, 15.7891, 0.5, (0.0882912, 0.0877382, 0.0870333)),  # fading out
    ):
        found = dielectric(thickness, index, ior, cosine, GAUSSIANS)
        np.testing.assert_allclose(found, shown, atol=2e-6)


def test_metals_are_as_cycles_shows_them():
    """Mirrors in Blender 5.2's pictures: metals of colors, and one of indices."""
    for base, tint, index, thickness, degrees, shown in (
        (0.7, 1.0, 2.0, 247.5586, 85, (0.664993, 0.835168, 0.614723)),
        (*_COLORS, 1.33, 362.4023, 60, (0.952538, 0.443513, 0.086659)),
        (*_COLORS, 2.0, 419.8242, 0, (0.938715, 0.456092, 0.175452)),
        (*_COLORS, 2.0, 0.8508, 75, (0.925244, 0.563474, 0.324362)),  # fading out
    ):
        found = metal(thickness, index, base, edge_of(base, tint), np.cos(np.radians(degrees)))
        np.testing.assert_allclose(found, shown, atol=5e-4)
    found = metal(304.9805, 2.0, *GOLD, 0.5, REC709 | INDEXED)
    np.testing.assert_allclose(found, (0.968574, 0.787967, 0.234097), atol=5e-4)


def test_all_is_reflected_beyond_the_critical_angle():
    """At the film's upper side, at its lower side, and above a metal."""
    assert (dielectric(300.0, 0.8, 1.5, 0.3) == 1.0).all()
    assert (dielectric(300.0, 1.33, 0.7, 0.3) == 1.0).all()
    assert (metal(300.0, 0.8, 0.5, 0.4, 0.3) == 1.0).all()


def test_extremes_are_finite():
    """Between 0 and 1, whatever is asked."""
    for thickness in (0.11, 1e4, 1e9):
        for index in (1e-5, 0.5, 1.0, 1e6):
            for cosine in (0.0, 1e-6, 1.0):
                found = [dielectric(thickness, index, ior, cosine) for ior in (0.01, 1.0, 1e3)]
                for first, second in ((0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)):
                    found.append(metal(thickness, index, first, second, cosine))
                    found.append(metal(thickness, index, first, second, cosine, INDEXED))
                    found.append(metal(thickness, index, 0.5, 0.5, cosine, GAUSSIANS))
                assert np.isfinite(found).all() and np.min(found) >= 0.0 and np.max(found) <= 1.0


def test_tables_are_those_of_each_space():
    """1 where both ways are equal, less everywhere; other primaries, other colors."""
    tables = sensitivities()
    np.testing.assert_allclose(tables[:, 0], np.tile(_F([1, 1, 1, 0, 0, 0]), (3, 1)), atol=1e-6)
    assert np.abs(tables[:, 400:]).max() < 0.02
    names = ("Linear Rec.709", "Linear Rec.2020", "ACEScg", "something else")
    assert [film_space(name) for name in names] == [REC709, REC2020, ACESCG, REC709]
    # As Blender 5.2 shows a film of 419.9 nm, index 1.5, on 2.25, along the normal.
    red = [dielectric(419.9, 1.5, 2.25, 1.0, space)[0] for space in (REC709, REC2020, ACESCG)]
    assert len(set(red)) == 3
