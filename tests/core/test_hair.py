"""Strands of hair: hair.py, hair_frame.py, hair_cells.py, hair_setup.py, round_points.py."""

import numpy as np
import pytest

from iwis.core._jit import kernel
from iwis.core.bsdf.hair import ray_start
from iwis.core.bsdf.hair_setup import HairValues, set_hair, set_starts
from iwis.core.bsdf.lobes_at import lobes_at
from iwis.core.bsdf.sheen import diffuse_colors
from iwis.core.data.program import HAIR_BELL_REFLECTION, HAIR_BELL_TRANSMISSION, HAIR_CHIANG
from iwis.core.geometry.round_points import Circles, circles, normals_of_strands
from iwis.core.nodes.hair_info import hair_pigment
from support.brdf_points import evaluated, sphere_quadrature
from support.scenes import constant_world, diffuse
from support.strands import cone_mesh
from support.warps import PointProduct, light_of

_SEEN = [(0.0, 0.1, 0.995), (0.6, 0.3, 0.74), (0.1, 0.8, 0.59), (-0.5, -0.7, 0.5)]


def _values(model=HAIR_CHIANG, roughness=0.3, radial=0.3, absorption=0.0, **more):
    numbers = {"coat": 0.0, "ior": 1.55, "offset": 0.035} | more
    return HairValues(
        model,
        np.float32([[1.0, 0.0, 0.0]]),
        np.full((1, 3), absorption, np.float32),
        np.float32([roughness]),
        np.float32([radial]),
        **{name: np.float32([value]) for name, value in numbers.items()},
    )


def _product(wo, side, **values):
    """PointProduct of one side of a strand along x, under a constant world."""

    def prepare(lobes):
        set_hair(lobes, np.array([0]), _values(**values), np.float32([side]))
        lobes.normal[:] *= np.float32(side)

    wo = np.array(wo) / np.linalg.norm(wo)
    world = light_of(constant_world())
    return PointProduct(world, diffuse((1.0, 1.0, 1.0)), wo=wo, change=prepare)


def _round(wo, wi, **values):
    """float32 (n, 3): BSDF x cosine of both sides together; nothing of it is diffuse."""
    both = [evaluated(_product(wo, side, **values).lobes, 0, wi) for side in (1.0, -1.0)]
    assert not any(value[:, :3].any() for value in both)
    assert not (both[0][:, 3:] * both[1][:, 3:]).any()  # each side has its own half
    return both[0][:, 3:] + both[1][:, 3:]


@pytest.mark.parametrize("wo", _SEEN)
@pytest.mark.parametrize("roughness", [0.2, 0.3, 0.7])
def test_a_strand_without_pigment_gives_all_light_back(wo, roughness):
    """What is mirrored and what goes through add up to 1, but for the cut series of Cycles' I0: up
    to 2 % of what is mirrored, which is a tenth. (Tilted cuticles give some 2 % more or less.)"""
    wi, solid_angle = sphere_quadrature(256, 512)
    value = _round(wo, wi, roughness=roughness, radial=roughness, offset=0.0)
    whole = solid_angle.astype(np.float64) @ value.astype(np.float64)
    np.testing.assert_allclose(whole, 1.0, atol=4e-3)


def _reference(wo, wi, h, sigma, beta_m, beta_n, eta, tilt):
    """[Chiang16, eq. 1 to 10], float64, strand along x; wo, wi unit; the angle phi from wo on."""
    v = (0.726 * beta_m + 0.812 * beta_m**2 + 3.7 * beta_m**20) ** 2
    s = np.sqrt(np.pi / 8) * (0.265 * beta_n + 1.194 * beta_n**2 + 5.372 * beta_n**22)
    theta_o, theta_i = np.arcsin(wo[0]), np.arcsin(wi[:, 0])
    phi = np.arctan2(wi[:, 2], wi[:, 1]) - np.arctan2(wo[2], wo[1])
    gamma_o = np.arcsin(h)
    eta_across = np.sqrt(eta**2 - np.sin(theta_o) ** 2) / np.cos(theta_o)
    gamma_t = np.arcsin(h / eta_across)
    way = 2.0 * np.cos(gamma_t) / np.sqrt(1.0 - (np.sin(theta_o) / eta) ** 2)
    cosine = np.cos(theta_o) * np.cos(gamma_o)
    inside = np.sqrt(1.0 - (1.0 - cosine**2) / eta**2)
    rs = (cosine - eta * inside) / (cosine + eta * inside)
    rp = (eta * cosine - inside) / (eta * cosine + inside)
    f, t = 0.5 * (rs**2 + rp**2), np.exp(-sigma * way)
    parts = [f, (1 - f) ** 2 * t, (1 - f) ** 2 * t**2 * f]
    parts.append(parts[2] * f * t / (1 - f * t))
    total = 0.0
    for p, (a, turn, width) in enumerate(
        zip(parts, (2 * tilt, -tilt, -4 * tilt, 0.0), (v, v / 4, 4 * v, 4 * v), strict=True)
    ):
        angle = theta_i + turn
        x = np.cos(angle) * np.cos(theta_o) / width
        m = np.i0(np.abs(x)) * np.exp(-np.sin(angle) * np.sin(theta_o) / width)
        m /= 2.0 * width * np.sinh(1.0 / width)
        n = 1.0 / (2.0 * np.pi)
        if p < 3:
            off = phi - (2 * p * gamma_t - 2 * gamma_o + p * np.pi)
            off = np.abs((off + np.pi) % (2 * np.pi) - np.pi) / s
            n = np.exp(-off) / (s * (1 + np.exp(-off)) ** 2) / np.tanh(np.pi / (2 * s))
        total = total + a * m * n
    return total


@pytest.mark.parametrize("wo", _SEEN)
def test_principled_hair_is_the_papers(wo, rng):
    """Of widths where x of I0 stays below 6: there ten terms are I0 to 1e-5."""
    wi = rng.normal(size=(3000, 3))
    wi = np.float32(wi / np.linalg.norm(wi, axis=1)[:, None])
    ours = _round(wo, wi, roughness=0.8, radial=0.6, absorption=0.4, offset=0.1)
    unit = np.array(wo) / np.linalg.norm(wo)
    # The normal is z: as seen along x, so far from wo's direction across the strand.
    h = -np.sin(np.arctan2(1.0, 0.0) - np.arctan2(unit[2], unit[1]))
    wanted = _reference(unit, wi.astype(np.float64), h, 0.4, 0.8, 0.6, 1.55, 0.1)
    inner = np.abs(wi[:, 2]) > 1e-3  # on the border between both sides neither may have it
    np.testing.assert_allclose(ours[inner, 0], wanted[inner], rtol=2e-3, atol=1e-6)


def test_coat_narrows_what_is_mirrored_alone():
    """In the mirrored direction there is more light, in all of the sphere as much as before."""
    wo, wi = (0.0, 0.1, 0.995), np.float32([[0.0, -0.1, 0.995]])
    wi /= np.linalg.norm(wi)
    plain, coated = (_round(wo, wi, coat=coat, absorption=50.0, offset=0.0) for coat in (0.0, 0.8))
    assert coated[0, 0] > 2.0 * plain[0, 0]


@pytest.mark.parametrize(
    ("model", "whole"),
    [(HAIR_BELL_REFLECTION, np.sqrt(0.5)), (HAIR_BELL_TRANSMISSION, 1.0)],
)
def test_bells_of_the_hair_bsdf(model, whole):
    """Round the strand the cosine's bell is cut at a quarter turn; along it nothing is lost."""
    wi, solid_angle = sphere_quadrature(512, 1024)
    value = _round((0.3, 0.4, 0.86), wi, model=model, roughness=0.2, radial=1.0, offset=0.0)
    found = solid_angle.astype(np.float64) @ value.astype(np.float64)
    np.testing.assert_allclose(found, whole, rtol=5e-3)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("wo", _SEEN[:3])
def test_samples_follow_the_strand(wo, side, rng):
    """Light over density varies by less than its mean, by a third of what a Lambert lobe leaves."""
    product = _product(wo, side, absorption=0.5)
    directions, pdf = product.warp(rng.random((8000, 2)))
    value = evaluated(product.lobes, 0, np.float32(directions))[:, 3]
    weights = value / pdf
    assert weights.std() < 0.9 * weights.mean()
    cosines = directions @ product.lobes.normal[0]
    plain = value / np.maximum(cosines, 1e-6) * np.pi
    wi, solid_angle = sphere_quadrature(128, 256)
    whole = solid_angle @ evaluated(product.lobes, 0, wi)[:, 3]
    assert weights.mean() == pytest.approx(whole, rel=5.0 * weights.std() / whole / 8000**0.5)
    assert weights.std() < plain.std()
    assert product.whole_pdf().mean() * 4.0 * np.pi == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("model", [HAIR_CHIANG, HAIR_BELL_REFLECTION, HAIR_BELL_TRANSMISSION])
def test_hair_is_glossy_and_both_sides_have_its_color_in_the_pass(model):
    both = [_product(_SEEN[0], side, model=model).lobes for side in (1.0, -1.0)]
    assert not any(diffuse_colors(lobes).any() for lobes in both)
    np.testing.assert_allclose(sum(lobes.glossy_color for lobes in both), 1.0, rtol=1e-6)


def test_dark_hair_has_its_samples_in_front():
    """What goes through blond hair is most of its light, and nothing of what goes through black."""
    blond, black = (_product(_SEEN[0], -1.0, absorption=a).lobes for a in (0.0, 50.0))
    assert blond.glossy_color[0, 0] > 0.8 and black.glossy_color[0, 0] == pytest.approx(0.1)


@pytest.mark.parametrize("part", [0.0, 0.25, 1.0])
def test_circles_of_a_cone(part):
    """Its radius where the point is, the axis, and how it narrows; rays start outside of it."""
    mesh = cone_mesh()
    corners = mesh.vertices[mesh.triangles]
    low, high = corners[..., 2] == 0.0, corners[..., 2] > 0.0
    weights = np.where(low, (1.0 - part) / low.sum(1, keepdims=True), 0.0)
    weights = weights + np.where(high, part / high.sum(1, keepdims=True), 0.0)
    places = np.einsum("ij,ijk->ik", weights, corners)
    found = circles(mesh, np.arange(len(mesh.triangles)), np.float32(places))
    np.testing.assert_allclose(found.radius, 0.3 - 0.1 * part, rtol=1e-5)
    np.testing.assert_allclose(np.abs(found.axis[:, 2]), 1.0, rtol=1e-5)
    np.testing.assert_allclose(found.slope * found.axis[:, 2], -0.05, rtol=1e-4)
    assert (found.reach * np.cos(np.pi / 8) > found.radius).all()


@kernel
def _start(lobes, position, wi, out):
    at = lobes_at(lobes, 0)
    for k in range(len(wi)):
        x, y, z = ray_start(
            at, (position[0], position[1], position[2]), wi[k, 0], wi[k, 1], wi[k, 2]
        )
        out[k, 0], out[k, 1], out[k, 2] = x, y, z


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("slope", [0.0, 0.1])
def test_rays_start_where_they_have_left_the_strand(side, slope, rng):
    """On the ray from the place on a cone along x, and on the cone that is reach / radius wider."""
    lobes = _product((0.0, 0.3, 0.9), side).lobes
    own = Circles(
        np.float32([0.1]), np.float32([0.11]), np.float32([[1, 0, 0]]), np.float32([slope])
    )
    way = set_starts(lobes, np.array([0]), own, np.array([side < 0.0]))
    place = np.array([0.0, 0.0, 0.1])  # the axis is x, the normal z
    moved = np.float32(place + way[0] * np.array([0.0, 0.0, 1.0]))
    wi = rng.normal(size=(2000, 3))
    wi[:, 2] = side * np.abs(wi[:, 2])
    wi = np.float32(wi / np.linalg.norm(wi, axis=1)[:, None])
    wi = np.ascontiguousarray(wi[np.abs(wi[:, 0]) < 0.95])
    out = np.empty_like(wi)
    _start(lobes, moved, wi, out)
    offset = out - place
    along = np.einsum("ij,ij->i", offset, wi)
    np.testing.assert_allclose(offset, along[:, None] * wi, atol=2e-6)
    assert (along > 0.0).all()
    np.testing.assert_allclose(
        np.hypot(out[:, 1], out[:, 2]), 0.11 + slope * out[:, 0], rtol=1e-3, atol=1e-5
    )


def test_normals_at_right_angles_to_strands():
    found = normals_of_strands(np.float32([[0.6, 0.0, 0.8]]), np.float32([[1.0, 0.0, 0.0]]))
    np.testing.assert_allclose(found, [[0.0, 0.0, 1.0]], atol=1e-6)


class _Strand:
    """A context of one strand whose Random is .75."""

    def __len__(self):
        return 1

    def attribute(self, name):
        return np.float32([[0.75]]) if name == "element:Random" else None


def _pigment(parametrization, huang=False, **inputs):
    own = {
        "Color": np.float32([0.5, 0.3, 0.1]),
        "Tint": np.ones(3, np.float32),
        "Absorption": np.float32([0.1, 0.2, 0.3]),
        "Melanin": np.float32(0.5),
        "Redness": np.float32(0.25),
        "Roughness": np.float32(0.2),
        "Radial": np.float32(0.3),
        "Random Color": np.float32(0.0),
        "Random Roughness": np.float32(0.0),
    }
    settings = {"parametrization": parametrization, "huang": huang}
    return hair_pigment(_Strand(), settings, own | inputs)


def test_pigment_of_a_color_gives_it_back():
    """[Chiang16, eq. 9] one way and back: also what Cycles calls the color of absorption."""
    found = _pigment("COLOR")
    np.testing.assert_allclose(found["color"], [[0.5, 0.3, 0.1]], rtol=1e-5)
    x = 0.3
    reach = 5.969 - 0.215 * x + 2.532 * x**2 - 10.73 * x**3 + 5.574 * x**4 + 0.245 * x**5
    wanted = (np.log([0.5, 0.3, 0.1]) / reach) ** 2
    np.testing.assert_allclose(found["absorption"], wanted[None], rtol=1e-5)


def test_pigment_of_melanin():
    """-log(1 - .5) of it, a quarter of that red; white tint adds nothing."""
    amount = -np.log(0.5)
    wanted = amount * (
        0.75 * np.array([0.506, 0.841, 1.653]) + 0.25 * np.array([0.343, 0.733, 1.924])
    )
    np.testing.assert_allclose(_pigment("MELANIN")["absorption"], wanted[None], rtol=1e-5)
    assert (_pigment("ABSORPTION")["absorption"] == np.float32([[0.1, 0.2, 0.3]])).all()


def test_strands_differ_by_their_random_number_or_the_one_given():
    """.75: a quarter off the mean, times 2."""
    more = _pigment("MELANIN", **{"Random Color": np.float32(0.4)})["absorption"]
    wanted = _pigment("MELANIN", Melanin=np.float32(0.5 * 1.2))["absorption"]
    np.testing.assert_allclose(more, wanted, rtol=1e-5)
    rough = {"Random Roughness": np.float32(0.6)}
    assert _pigment("COLOR", **rough)["roughness"] == pytest.approx(0.2 * 1.3)
    assert _pigment("COLOR", **rough, Random=np.float32(0.25))["radial"] == pytest.approx(0.3 * 0.7)
    assert _pigment("COLOR", huang=True)["radial"] == pytest.approx(0.2)


def test_black_hair_is_finite():
    found = _pigment("COLOR", Color=np.zeros(3, np.float32))
    assert all(np.isfinite(value).all() for value in found.values())
