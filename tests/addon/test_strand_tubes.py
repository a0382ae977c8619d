"""Tubes of strands: around the spline, wide enough, and as many as memory has room for."""

import numpy as np
import pytest

from iwis.core.embree.triangle_pairs import paired
from iwis.iwis_addon.export.errors import ExportError
from iwis.iwis_addon.export.meshes.mesh_size import check_made
from iwis.iwis_addon.export.meshes.strand_tubes import (
    Shape,
    Strands,
    choose_shape,
    count_triangles,
    find_rings,
    make_tubes,
)


def strands_of(*keys):
    """Strands of lists of (x, y, z, radius)."""
    first = np.cumsum([0, *map(len, keys)])
    return Strands(np.concatenate(keys).astype(np.float32), first)


def spline(keys, k, u):
    """The Catmull-Rom spline after key k, the slow and obvious way."""
    keys = np.asarray(keys, np.float64)
    a, b, c, d = (keys[np.clip(k + i, 0, len(keys) - 1)] for i in (-1, 0, 1, 2))
    return 0.5 * (
        2 * b + (c - a) * u + (2 * a - 5 * b + 4 * c - d) * u**2 + (3 * b - a - 3 * c + d) * u**3
    )


_BENT = [(0, 0, 0, 0.1), (0.2, 0, 1, 0.2), (1, 0.3, 1.5, 0.1), (2, 0, 1.2, 0.05)]
_STRAIGHT = [(3, 0, 0, 0.1), (3, 0, 1, 0.1)]


@pytest.mark.parametrize("sides", [4, 8])
def test_corners_lie_around_the_spline(sides):
    """At its radius (wider by what makes the mean width right), and normals point away."""
    strands, shape = strands_of(_BENT, [(9, 9, 9, 1)], _STRAIGHT), Shape(sides, 3, False)
    rings = find_rings(strands, shape)
    made = make_tubes(strands, shape, rings)
    assert len(made.triangles) == count_triangles(strands, shape) == 2 * sides * 3 * 4
    keys = [_BENT, None, _STRAIGHT]
    wide = np.pi / (sides * np.sin(np.pi / sides))
    for k in range(len(made.positions)):
        ring = made.ring[k]
        own = keys[rings.strand[ring]]
        x = spline(own, rings.key[ring] - strands.first[rings.strand[ring]], rings.part[ring])
        away = made.positions[k] - x[:3]
        assert np.linalg.norm(away) == pytest.approx(x[3] * wide, abs=1e-5)  # float32 at 3 m
        np.testing.assert_allclose(away, made.normals[k] * x[3] * wide, atol=1e-5)


def test_tubes_look_out_and_do_not_twist():
    """Triangles wind counterclockwise from outside, though the strand turns over and over."""
    t = np.linspace(0.0, 12.0, 200)
    helix = np.stack([np.cos(t), np.sin(t), 0.1 * t, np.full_like(t, 0.05)], -1)
    strands, shape = strands_of(helix), Shape(6, 1, False)
    made = make_tubes(strands, shape, find_rings(strands, shape))
    a, b, c = (made.positions[k].astype(np.float64) for k in made.triangles.T)
    areas = np.cross(b - a, c - a)
    outside = made.normals[made.triangles].mean(1)
    cosine = np.einsum("ij,ij->i", areas, outside) / np.linalg.norm(areas, axis=1)
    assert cosine.min() > 0.5


def test_no_triangle_without_radius():
    """A closed tip is a cone: of its last band one triangle a side is left."""
    strands, shape = strands_of([(0, 0, 0, 0.1), (0, 0, 1, 0.0)]), Shape(4, 1, False)
    made = make_tubes(strands, shape, find_rings(strands, shape))
    assert len(made.triangles) == 4
    a, b, c = (made.positions[k] for k in made.triangles.T)
    assert (np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0.0).all()


def test_keys_on_one_place_are_finite():
    """Two keys at the same place, and a strand that turns back, have frames all the same."""
    strands = strands_of(
        [(0, 0, 0, 0.1), (0, 0, 0, 0.1), (0, 0, 1, 0.1), (0, 0, 0, 0.1)], [(1, 1, 1, 0.1)] * 3
    )
    shape = Shape(4, 2, False)
    made = make_tubes(strands, shape, find_rings(strands, shape))
    assert np.isfinite(made.positions).all() and np.isfinite(made.normals).all()
    np.testing.assert_allclose(np.linalg.norm(made.normals, axis=1), 1.0, atol=1e-5)


def test_few_strands_are_rounder_and_bends_are_finer():
    """A straight strand needs no pieces; a hundred thousand have four sides and go straight."""
    assert choose_shape(strands_of(_STRAIGHT), 4, False) == Shape(32, 1, False)
    assert choose_shape(strands_of(_BENT), 4, False).pieces == 4
    assert choose_shape(strands_of(_BENT), 1, False).pieces == 1
    assert choose_shape(strands_of(_BENT), 4, True) == Shape(32, 1, True)
    keys = np.tile(np.float32(_BENT), (300_000, 1))
    many = Strands(keys, np.arange(0, len(keys) + 1, 4))
    assert choose_shape(many, 4, False) == Shape(4, 1, False)


@pytest.mark.parametrize(
    "count, expected",
    [(4_000, (12, 6)), (30_000, (8, 5)), (60_000, (6, 3)), (200_000, (4, 1))],
)
def test_many_bent_strands_keep_some_pieces(count, expected):
    """Kinks would make them darker, four sides brighter."""
    keys = np.tile(np.float32(_BENT), (count, 1))
    many = Strands(keys, np.arange(0, 4 * count + 1, 4))
    shape = choose_shape(many, 16, False)
    assert (shape.sides, shape.pieces) == expected
    assert count_triangles(many, shape) <= 1 << 23


def test_too_many_strands_name_their_object():
    with pytest.raises(ExportError, match=r"Object Wig: its 9 strands are 4,000,000,000 triangles"):
        check_made("Wig", "9 strands", 4_000_000_000)


def test_tubes_of_two_times_are_turned_alike():
    """A strand that turns a little past where another axis is the nearest: corners go as far."""
    shape = Shape(8, 1, True)
    ends = np.array([[1.0, 0.3, 0.25], [1.0, 0.25, 0.3]])
    one, two = (strands_of([(0, 0, 0, 0.1), (*end, 0.1)]) for end in ends)
    rings = find_rings(one, shape)
    before = make_tubes(one, shape, rings)
    alike, alone = make_tubes(two, shape, rings, one), make_tubes(two, shape, rings)
    np.testing.assert_array_equal(alike.triangles, before.triangles)
    turned = np.linalg.norm(alike.normals - before.normals, axis=1).max()
    ways = ends / np.linalg.norm(ends, axis=1, keepdims=True)
    assert turned <= np.linalg.norm(ways[1] - ways[0]) * 1.001
    assert np.linalg.norm(alone.normals - before.normals, axis=1).max() > 0.5  # it does matter
    np.testing.assert_allclose(alike.normals @ ways[1], 0.0, atol=1e-6)


@pytest.mark.parametrize("tip", [0.05, 0.0])
def test_bands_are_quads_to_embree(tip):
    """All triangles go two by two; of the last band of a closed tip each stands alone."""
    radii = [0.1] * 7 + [tip]
    strands = strands_of([(0, 0, z, radius) for z, radius in enumerate(radii)])
    made = make_tubes(strands, Shape(8, 1, True), find_rings(strands, Shape(8, 1, True)))
    pairs = paired(np.ascontiguousarray(made.triangles))
    assert len(made.triangles) == 8 * (14 if tip else 13)
    assert len(pairs.first) == 8 * 7


def test_straight_pieces_are_as_wide_all_along_and_meet():
    """Every corner at its radius from its own piece's line; at a bend those of both pieces in one
    plane, no further from the key than the bend's mitre."""
    strands, shape = strands_of(_BENT), Shape(16, 1, True)
    rings = find_rings(strands, shape)
    made = make_tubes(strands, shape, rings)
    assert len(made.triangles) == count_triangles(strands, shape)
    keys, wide = np.asarray(_BENT, np.float64), np.pi / (16 * np.sin(np.pi / 16))
    ways = np.diff(keys[:, :3], axis=0)
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    place = made.positions.reshape(-1, 16, 3)
    for r in range(len(rings.key)):
        key, at = rings.key[r], rings.key[r] + rings.last[r]
        away = place[r] - keys[at, :3]
        along = away @ ways[key]
        across = np.linalg.norm(away - along[:, None] * ways[key], axis=1)
        np.testing.assert_allclose(across, keys[at, 3] * wide, atol=1e-5)  # float32 at 3 m
        other = key + 1 if rings.last[r] else key - 1
        plane = ways[key] + (ways[other] if 0 <= other < len(ways) else ways[key])
        np.testing.assert_allclose(away @ plane, 0.0, atol=1e-5)


def test_straight_pieces_that_turn_back_stay_short():
    """A fold, and two keys in one place: no corner more than a radius beyond its key."""
    back = [(0, 0, 0, 0.1), (0, 0, 1, 0.1), (0, 0.01, 0, 0.1), (0, 0.01, 0, 0.1), (1, 0, 0, 0.1)]
    strands, shape = strands_of(back), Shape(8, 1, True)
    made = make_tubes(strands, shape, find_rings(strands, shape))
    assert np.isfinite(made.positions).all()
    assert -0.21 < made.positions[:, 2].min() and made.positions[:, 2].max() < 1.21
