"""core/lamplight/lamp_choice.py: of many lamps a point takes those that bring it most."""

import numpy as np
import pytest

from iwis.core._jit import kernel
from iwis.core.bsdf.lobes_at import lobes_at
from iwis.core.data.lamps import DISC, RECTANGLE, SPHERE, SUN, make_lamps
from iwis.core.lamplight.lamp_choice import ALL_LAMPS, powers_of, share_out
from iwis.core.lamplight.lamp_cones import cone_factor, soft_cone_factor
from iwis.core.lamplight.lamp_shares import PlainLamps, plain_lamps
from support.lamp_points import sampled, seen_point
from support.scenes import diffuse, glossy, principled
from support.statistics import sidak, t_p_value

MATTE = diffuse((0.8, 0.5, 0.3))
MATERIALS = {
    "paint": principled(base_color=(0.2, 0.4, 0.6), roughness=0.4),
    "shiny": glossy(0.02, (0.9, 0.8, 0.7)),
}


@pytest.mark.slow
@pytest.mark.statistical
def test_many_lamps_are_chosen_from_without_bias():
    """40 lamps, of which 8 are taken: the mean is that of all by name, alpha 1e-3."""
    rng = np.random.default_rng(5)
    rows = []
    for _ in range(30):
        position = rng.uniform((-3.0, -3.0, 0.5), (3.0, 3.0, 3.0))
        kind = (SPHERE, RECTANGLE)[int(rng.integers(2))]
        size = (0.2, 0.0) if kind == SPHERE else (0.3, 0.2)
        rows.append({"kind": kind, "position": position, "size": size, "radiance": rng.random()})
    rows.append({"kind": SUN, "radiance": 0.01, "size": (0.05, 0.0)})
    rows += _turned_spots(rng, 10, 0.2)
    assert len(rows) > ALL_LAMPS
    for material in ("paint", "shiny"):
        expected = sum(
            sampled(rows[k : k + 14], MATERIALS[material], 1000, 64).mean(0).sum()
            for k in range(0, len(rows), 14)
        )
        found = sampled(rows, MATERIALS[material], 8000, 8).sum(1)  # sees an error of 5 %
        # The other way has an error too: 64000 stratified samples, 1e-3 of the sum.
        near = abs(found.mean() / expected - 1.0) < 2e-3
        assert near or t_p_value(found, expected) > sidak(1e-3, 2)
        assert t_p_value(found, 1.05 * expected) < 1e-3


def _turned_spots(rng, count, radius=0.0):
    """Rows of spots of a radius over the floor, 34 degrees wide each way, at places on it."""
    rows = []
    for _ in range(count):
        position = rng.uniform((-3.0, -3.0, 0.5), (3.0, 3.0, 3.0))
        forward = rng.uniform((-3.0, -3.0, 0.0), (3.0, 3.0, 0.0)) - position
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, (0.3, 0.5, 0.7))
        right /= np.linalg.norm(right)
        up = np.cross(right, forward)
        frame = {"forward": forward, "right": right, "up": up}
        cone = {"to_cone": np.stack([right, up, -forward]), "cone": (np.cos(0.6), 30.0)}
        lamp = {"kind": SPHERE, "position": position, "radiance": 5.0, "size": (radius, 0.0)}
        rows.append(lamp | frame | cone)
    return rows


def test_many_lamps_are_chosen_from_by_what_they_bring():
    """Of 60 balls half are below the floor, of 60 spots, hard and soft, most shine elsewhere: one
    sample of eight lamps has little noise where nothing is between (by power and distance alone .4
    and .45, and 1.3 of soft spots each of which had a tenth of its light outside its cone)."""
    rng = np.random.default_rng(3)
    places = rng.uniform((-3.0, -3.0, -3.0), (3.0, 3.0, 3.0), (60, 3))
    balls = [
        {"kind": SPHERE, "position": place, "size": (0.05, 0.0), "radiance": 5.0}
        for place in places
    ]
    for rows in (balls, _turned_spots(rng, 60), _turned_spots(rng, 60, 0.05)):
        light = sampled(rows, MATTE, 2000, 1).sum(axis=1)
        assert 0.0 < light.std() < 0.1 * light.mean()


@kernel
def _fill_cones(lamps, along, sine, out):
    for k in range(len(along)):
        x, y, z = np.float64(along[k, 0]), np.float64(along[k, 1]), np.float64(along[k, 2])
        out[k, 0] = cone_factor(lamps, 0, x, y, z)
        out[k, 1] = soft_cone_factor(lamps, 0, x, y, z, sine)


@pytest.mark.parametrize("shape", ["round", "scaled", "sheared"])
def test_a_soft_spot_has_a_share_where_any_of_it_shines(shape, rng):
    """By the mean of its middle and its brightest place: from 0, where nothing comes through, and
    half of the most of 400 places on it, to what the middle and that make, and not much more."""
    frame, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    shapes = {"round": np.eye(3), "scaled": np.diag([1.0, 3.0, 1.0])}
    shapes["sheared"] = np.array([[1.0, 0.6, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    row = {"kind": SPHERE, "size": (0.1, 0.0), "cone": (np.cos(0.5), 8.0), "radiance": 1.0}
    lamps, sine = make_lamps([row | {"to_cone": shapes[shape] @ frame}]), 0.15
    middles = rng.normal(size=(2000, 3))
    middles /= np.linalg.norm(middles, axis=1)[:, None]
    aside = np.cross(middles[:, None], rng.normal(size=(2000, 400, 3)))
    aside *= np.tan(np.arcsin(sine)) / np.linalg.norm(aside, axis=2)[..., None]
    found, places = np.empty((2000, 2)), np.empty((2000 * 400, 2))
    _fill_cones(lamps, middles, sine, found)
    _fill_cones(lamps, (middles[:, None] + aside).reshape(-1, 3), sine, places)
    middle, share = found.T
    most = np.maximum(places[:, 0].reshape(2000, 400).max(1), middle)
    assert ((middle > 0.0) & (middle < 1.0)).any() and ((most > 0.0) & (middle == 0.0)).any()
    assert (share >= 0.5 * (middle + most) - 1e-6).all()  # float32 columns of the lamp
    if shape == "round":
        np.testing.assert_allclose(share, 0.5 * (middle + most), atol=2e-3)  # 400 places' best
    assert (share == 0.0).mean() > 0.5


def _ceiling():
    """Rows of 64 areas that shine down, a metre from each other."""
    places = [(x - 3.5, y - 3.5, 4.0) for x in range(8) for y in range(8)]
    down = {"forward": (0.0, 0.0, -1.0), "right": (1.0, 0.0, 0.0), "up": (0.0, -1.0, 0.0)}
    area = {"kind": RECTANGLE, "size": (0.3, 0.3), "radiance": 5.0} | down
    return [area | {"position": place} for place in places]


def _points(rng):
    places = rng.uniform((-3.0, -3.0, 0.5), (3.0, 3.0, 3.0), (60, 3))
    return [{"kind": SPHERE, "position": place, "radiance": 5.0} for place in places]


def test_gloss_is_lit_by_those_of_many_lamps_that_it_mirrors():
    """One sample of eight lamps has little noise on gloss, too (by the cosine alone, over its mean:
    metal .85 and 1.13, paint .075 and .032)."""
    rows = _ceiling(), _points(np.random.default_rng(3))
    for material, most in ((glossy(0.09, (0.9, 0.8, 0.7)), 0.15), (MATERIALS["paint"], 0.03)):
        for lamps in rows:
            light = sampled(lamps, material, 4000, 1).sum(axis=1)
            assert 0.0 < light.std() < most * light.mean()


@kernel
def _fill_shares(lamps, powers, plain, points, lobes, shares):
    share_out(lamps, powers, plain, points, 0, lobes_at(lobes, 0), shares)


def _share_out(lamps, points, lobes, together=True):
    """float64 (n,): shares of the first point; together: of plain lamps by share_plain"""
    powers = powers_of(lamps)
    plain, shares = plain_lamps(lamps, powers), np.empty(len(powers))
    if not together:
        no = [column[:0] for column in plain[2:-1]]
        every = np.arange(len(powers), dtype=np.int32)
        plain = PlainLamps(every[:0], every, *no, plain.most)
    _fill_shares(lamps, powers, plain, points, lobes, shares)
    return shares


@pytest.mark.parametrize(("material", "lit"), [("paint", True), ("matte", False)])
def test_lamps_below_the_shading_normal_light_gloss(material, lit):
    """Where glossy light follows another normal, a lamp that only that one sees is drawn, too: else
    its light would be lost. Of what is matte it brings nothing."""
    points, lobes, _ = seen_point(MATERIALS.get(material, MATTE))
    tilted = np.float32([[np.sin(0.3), 0.0, np.cos(0.3)]])
    places = [(3.0, 0.0, -0.3)] + [(0.1 * k, 1.0, 2.0) for k in range(ALL_LAMPS)]
    lamps = make_lamps([{"kind": SPHERE, "position": p, "radiance": 1.0} for p in places])
    shares = _share_out(lamps, points, lobes._replace(glossy_normal=tilted))
    assert (shares[0] > 0.0) == lit and (shares[1:] > 0.0).all()
    assert _share_out(lamps, points, lobes)[0] == 0.0


@pytest.mark.parametrize("far", [0.4, 0.01, 0.0])
def test_a_lamp_that_a_point_is_in_has_the_share_of_half_its_radius(far):
    """However near its middle the point is: else all samples would go to that lamp alone, and at
    the middle itself no share would be a number."""
    points, lobes, _ = seen_point(MATTE)
    others = [{"kind": SPHERE, "position": (0.1 * k, 1.0, 2.0)} for k in range(ALL_LAMPS)]

    def shares_of(z):
        ball = {"kind": SPHERE, "position": (0.0, 0.0, z), "size": (1.0, 0.0), "radiance": 0.01}
        rows = [ball] + [row | {"radiance": 1.0} for row in others]
        return _share_out(make_lamps(rows), points, lobes)

    found = shares_of(far)
    assert 0.0 < found[0] < found.sum()
    # The point lies on a floor at 0, but for what float32 rays of 10 m leave of it.
    np.testing.assert_allclose(found, shares_of(0.5), rtol=1e-5)


@pytest.mark.parametrize("material", ["matte", "paint", "shiny", "mirror", "metal"])
def test_plain_lamps_have_the_same_shares_together(material, rng):
    """As one by one, but for float32: balls and discs of all sizes and powers, near and far, above
    and below, among spots and areas; .1 % of a share, and of the largest where one is sharp."""
    own = {"matte": MATTE, "mirror": glossy(0.0, (1.0, 1.0, 1.0)), "metal": glossy(0.3, (0.9,) * 3)}
    points, lobes, _ = seen_point((MATERIALS | own)[material])
    rows = _turned_spots(rng, 8) + _ceiling()[:8]
    for kind in (SPHERE, DISC):
        for far in 10.0 ** rng.uniform(-1.0, 3.0, 100):
            place, size = rng.normal(size=3), (rng.choice([0.0, 0.3, 2.0]) * far, 0.0)
            place *= far / np.linalg.norm(place)
            ball = {"kind": kind, "position": place, "size": size}
            rows.append(ball | {"radiance": 10.0 ** rng.uniform(-3.0, 3.0)})
    lamps = make_lamps(rows)
    found, expected = (_share_out(lamps, points, lobes, way) for way in (True, False))
    assert len(plain_lamps(lamps, powers_of(lamps)).row) == 200 and (expected > 0.0).any()
    np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-3 * expected.max())


def test_powers_are_intensities_and_a_suns_irradiance():
    """Along a lamp's axis: radiance x area; pi sin^2 of half the angle, of a sun."""
    rows = [{"kind": SUN, "size": (0.1, 0.0)}, {"kind": SUN}, {"kind": SPHERE, "size": (0.5, 0.0)}]
    rows.append({"kind": RECTANGLE, "size": (2.0, 3.0)})
    powers = powers_of(make_lamps([row | {"radiance": 2.0} for row in rows]))
    expected = [2.0 * np.pi * np.sin(0.1) ** 2, 2.0, 2.0 * np.pi * 0.25, 12.0]
    np.testing.assert_allclose(powers, expected, rtol=1e-5)
