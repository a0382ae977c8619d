"""Normals as those of rounded edges (bevel.py), beside integrals over the surfaces."""

import numpy as np
import pytest

from iwis.core.embree.accel import Accel
from iwis.core.geometry.shading import ShadingPoints
from iwis.core.nodes import ShadeContext
from iwis.core.nodes.near import bevel
from iwis.core.surfaces.bevel import _radius_of, rounded_normals
from iwis.core.unit_square.sequence import PixelSequence, sobol_points
from support.programs import with_programs
from support.scenes import black, box, camera_above, constant_world, join_parts, make_scene

COUNT = 4096
# Of a box from 0 to 2, its top: metres from the edge at x = 2, far from all others.
PLACES = (0.0, 0.02, 0.1, 0.25, 0.39)
RADIUS = 0.4


def _scene(*parts):
    camera, world = camera_above(), constant_world()
    scene = make_scene(list(parts), [black()] * len(parts), world, camera)
    return with_programs(scene, *[None] * len(parts))


BOX = box((0.0, 0.0, 0.0), (2.0, 2.0, 2.0))


def _points(scene, position, up):
    """Points of the scene's face that each is on, float32 (n, 3)."""
    position, n = np.float32(position), len(position)
    up = np.tile(np.float32(up), (n, 1))
    hit, _, _ = Accel(scene.mesh).intersect(position + 0.01 * up, -up)
    none, ones = np.zeros((n, 3), np.float32), np.ones((n, 3), np.float32)
    pixel, below = np.arange(n, dtype=np.int32), np.zeros(n, np.float32)
    passed = np.zeros(n, np.int32)
    return ShadingPoints(pixel, hit, position, up, up, up, none, below, ones, passed)


def _sums(scene, points, radius=RADIUS, count=COUNT):
    n = len(points.pixel)
    seeds = (np.arange(n, dtype=np.uint32) * np.uint32(k) + np.uint32(7) for k in (9176, 7919))
    sequence = PixelSequence(sobol_points(count), *seeds, True)
    own = np.full(n, radius, np.float32)
    return rounded_normals(scene, Accel(scene.mesh), points, own, count, sequence)


def _weight(away, radius, n=600):
    """Of a half plane that begins ``away`` from a point on or above it: the integral of (R - r)^3
    over where it is, by the midpoints of a grid. away: (along the plane, above it), metres"""
    steps = (np.arange(n) + 0.5) / n
    x = away[0] + steps * (radius - away[0])
    y = radius * (2.0 * steps - 1.0)
    r = np.sqrt(x[:, None] ** 2 + y[None, :] ** 2 + away[1] ** 2)
    return (np.maximum(radius - r, 0.0) ** 3).sum() * (radius - away[0]) * 2.0 * radius / n**2


def _on_top(places):
    return [(2.0 - d, 1.0, 2.0) for d in places]


def test_an_edge_is_as_round_as_the_faces_around_weigh():
    """The top counts from the point to the edge and away from it, the side below the edge from
    there on; the normal turns as these are to each other."""
    scene = _scene(BOX)
    found = _sums(scene, _points(scene, _on_top(PLACES), (0.0, 0.0, 1.0)))
    for d, (x, y, z) in zip(PLACES, found, strict=True):
        top = _weight((-d, 0.0), RADIUS)
        side = _weight((0.0, d), RADIUS)
        assert abs(y) < 0.01 * z  # 4096 probes; no edge is near along y
        assert x / z == pytest.approx(side / top, abs=0.01)


def test_far_from_edges_it_is_the_face():
    """To the last bit: no probe finds anything else."""
    scene = _scene(BOX)
    found = _sums(scene, _points(scene, [(1.0, 1.0, 2.0)], (0.0, 0.0, 1.0)), count=16)
    assert found[0, 2] > 0.0 and not found[0, :2].any()


def test_other_objects_do_not_count():
    """A box that all but touches the edge is not there; as part of the same object it is."""
    beside = box((2.001, 0.0, 0.0), (4.0, 2.0, 2.3))
    two, one = _scene(BOX, beside), _scene(join_parts([BOX, beside]))
    alone = _scene(BOX)
    found, as_one, expected = (
        _sums(scene, _points(scene, _on_top([0.1]), (0.0, 0.0, 1.0)))[0]
        for scene in (two, one, alone)
    )
    np.testing.assert_allclose(found, expected, rtol=1e-4)  # float32, other triangles beside
    assert as_one[0] < 0.0 < expected[0]  # its wall looks the other way


def test_far_sides_count():
    """A plate that is thinner than the radius: its back takes off of its front."""
    plate = _scene(box((0.0, 0.0, 1.9), (2.0, 2.0, 2.0)))
    found = _sums(plate, _points(plate, [(1.0, 1.0, 2.0)], (0.0, 0.0, 1.0)))[0]
    alone = _scene(BOX)
    whole = _sums(alone, _points(alone, [(1.0, 1.0, 2.0)], (0.0, 0.0, 1.0)))[0]
    back = _weight((-RADIUS, 0.1), RADIUS) / _weight((-RADIUS, 0.0), RADIUS)
    assert found[2] / whole[2] == pytest.approx(1.0 - back, abs=0.01)


@pytest.mark.parametrize("u", [0.0, 1e-4, 0.1, 0.5, 0.9, 0.999])
def test_radii_are_drawn_as_they_weigh(u):
    """The part of the weight within a radius is u."""
    x = float(_radius_of(np.float32(u)))
    within = 10.0 * x**2 - 20.0 * x**3 + 15.0 * x**4 - 4.0 * x**5
    assert within == pytest.approx(u, abs=3e-6)  # Newton ends below 1e-6; float32


class _Near:
    """Tells of one rounded normal, or of none."""

    def __init__(self, normal):
        self._normal = np.float32(normal)

    def rounded_normal(self, radius, count):
        assert count == 5 and (radius == np.float32(0.3)).all()
        return np.tile(self._normal, (len(radius), 1))


def _node(normal, back=0.0, **inputs):
    context = object.__new__(ShadeContext)
    context.triangle = np.zeros(1, np.int32)
    context.normal = np.float32([[0.0, 0.0, 1.0]])
    context.__dict__["backfacing"] = np.float32([back])
    context.near = None if normal is None else _Near(normal)
    inputs = {"Radius": np.float32(0.3)} | inputs
    return bevel(context, {"samples": 5}, inputs)["Normal"]


def test_node_turns_what_is_seen_from_behind():
    np.testing.assert_array_equal(_node((0.6, 0.0, 0.8)), np.float32([[0.6, 0.0, 0.8]]))
    np.testing.assert_array_equal(_node((0.6, 0.0, 0.8), 1.0), np.float32([[-0.6, 0.0, -0.8]]))


def test_node_without_surroundings_is_the_surface():
    """For shadow rays and lamps, and where probes find nothing."""
    for normal in (None, (0.0, 0.0, 0.0)):
        np.testing.assert_array_equal(_node(normal), [[0.0, 0.0, 1.0]])


def test_node_adds_its_turn_to_another_normal():
    found = _node((0.6, 0.0, 0.8), Normal=np.float32([[0.0, 1.0, 0.0]]))
    expected = np.float32([0.6, 1.0, -0.2])
    np.testing.assert_allclose(found[0], expected / np.linalg.norm(expected), rtol=1e-6)
