"""emitters.py, lamp_meshes.py: faces that shine light other surfaces as area lamps do."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.lamps import BLOCK, MESH, NO_LAMPS, RECTANGLE
from iwis.core.geometry.closed_meshes import hidden_sides
from iwis.core.lamplight.emitter_tree import face_nodes
from iwis.core.lamplight.emitters import with_emitters
from iwis.core.lamplight.lamp_meshes import sample_mesh
from iwis.core.scene import TriangleMesh
from support.lamp_points import sampled
from support.scenes import box, diffuse, glossy, join_parts, principled, quad
from support.statistics import sidak, t_p_value

RADIANCE = np.array([[0.0, 0.0, 0.0], [3.0, 2.0, 1.0]], np.float32)
RIGHT, UP = np.array([0.8, 0.0, -0.6]), np.array([0.0, 1.0, 0.0])
FORWARD = np.array([-0.6, 0.0, -0.8])
MATERIALS = {
    "diffuse": diffuse((0.8, 0.5, 0.3)),
    "gloss": glossy(0.1, (0.9, 0.8, 0.7)),
    "shiny": glossy(0.02, (0.9, 0.8, 0.7)),
    "paint": principled(base_color=(0.2, 0.4, 0.6), roughness=0.4),
}


def sheet(steps, center=(0.8, 0.1, 1.0), width=0.6, height=0.3, turned=False, material=1):
    """A rectangle of 2 steps^2 triangles of uneven sizes."""
    place = np.linspace(0.0, 1.0, steps + 1) ** 1.5 - 0.5
    u, v = (a.ravel()[:, None] for a in np.meshgrid(place * width, place * height))
    corner = np.arange(steps * (steps + 1)).reshape(steps, steps + 1)[:, :-1].ravel()
    one = np.stack([corner, corner + 1, corner + steps + 2], 1)
    other = np.stack([corner, corner + steps + 2, corner + steps + 1], 1)
    triangles = np.concatenate([one, other]).astype(np.int32)
    return mesh_of(np.asarray(center) + u * RIGHT + v * UP, triangles[:, :: -1 if turned else 1])


def mesh_of(vertices, triangles, material=1):
    m = len(triangles)
    rows = np.full(m, material, np.int32)
    return TriangleMesh(
        vertices=np.ascontiguousarray(vertices, np.float32),
        triangles=np.ascontiguousarray(triangles, np.int32),
        corner_normals=np.zeros((m, 3, 3), np.float32),
        material_index=rows,
        object_index=np.zeros(m, np.int32),
    )


def test_nothing_shines_costs_nothing():
    """No lamp of emission 0 or less, nor of faces without area or with NaN."""
    assert with_emitters([], sheet(2), np.zeros((2, 3), np.float32)) is NO_LAMPS
    assert with_emitters([], sheet(2), -RADIANCE) is NO_LAMPS
    bad = np.array([[0, 0, 0], [1, 0, 0], [np.nan, 1, 0]])
    lamps = with_emitters([], mesh_of(bad, [[0, 1, 2], [0, 1, 1]]), RADIANCE)
    assert len(lamps.kind) == 0


@pytest.mark.parametrize("steps", [1, 3, 40])
def test_lamps_hold_every_face_once(steps):
    """Powers of each side add up to the sheet's, in whole blocks, in boxes of a tree."""
    lamps = with_emitters([], sheet(steps), RADIANCE)
    assert lamps.kind.tolist() == [MESH]
    assert lamps.span[0].tolist() == [0, len(lamps.faces.corners), 0]
    assert not len(lamps.faces.corners) % BLOCK
    strength = np.sqrt((RADIANCE[1] ** 2).mean())
    whole = lamps.faces.power.sum(axis=0) / strength
    np.testing.assert_allclose(whole, 0.6 * 0.3, rtol=1e-5)  # float32 corners
    for first, end, root in lamps.span:
        _check_tree(lamps.faces, first // BLOCK, end // BLOCK, root)


def _check_tree(faces, first, end, node):
    """Leaves first ... end - 1 are below a node, within its box, with its power."""
    assert faces.leaves[node] == end - first
    rows = slice(first * BLOCK, end * BLOCK)
    corners = faces.corners[rows].reshape(-1, 3)
    assert (corners >= faces.nodes[node, :3]).all() and (corners <= faces.nodes[node, 3:6]).all()
    np.testing.assert_allclose(faces.nodes[node, 6], faces.power[rows].mean(1).sum(), rtol=1e-5)
    if end - first > 1:
        middle = first + faces.leaves[node + 1]
        _check_tree(faces, first, middle, node + 1)
        _check_tree(faces, middle, end, node + 2 * faces.leaves[node + 1])


def _hidden(vertices, triangles):
    """The side of its faces that is seldom drawn, -1 = none."""
    mesh = mesh_of(vertices, triangles)
    power = with_emitters([], mesh, RADIANCE).faces.power
    power = power[power[:, 0] > 0.0]
    share = power[:, 1] / power[:, 0]
    assert np.ptp(share) < 1e-6
    return -1 if share[0] == 1.0 else int(share[0] < 1.0)


def test_the_inside_of_closed_surfaces_is_seldom_drawn():
    """Of a box the backs of its faces, or their fronts if it is turned over; of seams whatever; an
    open box has no inside, nor has one with a face that is turned over, nor a sheet, nor what can
    be looked through."""
    vertices, triangles = box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))[:2]
    triangles = np.asarray(triangles)
    seams = np.asarray(vertices)[triangles.ravel()], np.arange(len(triangles) * 3).reshape(-1, 3)
    over = np.concatenate([triangles[:1, ::-1], triangles[1:]])
    assert _hidden(vertices, triangles) == _hidden(*seams) == 1
    assert _hidden(vertices, triangles[:, ::-1]) == 0
    for open_one in (triangles[1:], over, np.concatenate([triangles, triangles[:1]])):
        assert _hidden(vertices, open_one) == -1
    mesh = mesh_of(vertices, triangles)
    every = np.arange(len(triangles))
    assert (hidden_sides(mesh, every, every == 2) == 1.0).all()
    flat = sheet(3)
    assert _hidden(flat.vertices, flat.triangles) == -1


def test_each_object_has_an_inside_of_its_own():
    """A box, one turned over, an open one and one with a corner that is no number, in one table."""
    vertices, triangles = box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))[:2]
    vertices, triangles = np.asarray(vertices, np.float32), np.asarray(triangles)
    broken = vertices.copy()
    broken[0, 0] = np.nan
    kinds = [
        (vertices, triangles),
        (vertices + 3.0, triangles[:, ::-1]),
        (vertices, triangles[1:]),
        (broken, triangles),
    ]
    firsts = np.cumsum([0] + [len(v) for v, _ in kinds])
    mesh = mesh_of(
        np.concatenate([v for v, _ in kinds]),
        np.concatenate([t + first for (_, t), first in zip(kinds, firsts, strict=False)]),
    )
    owner = np.repeat(np.arange(4, dtype=np.int32), [len(t) for _, t in kinds])
    every = np.arange(len(owner))
    found = hidden_sides(dataclasses.replace(mesh, object_index=owner), every, every < 0)
    sides = [[1.0, 0.1], [0.1, 1.0], [1.0, 1.0], [1.0, 1.0]]
    np.testing.assert_array_equal(found, np.array(sides)[owner])


def test_faces_are_drawn_by_how_they_are_turned():
    """A sheet seen flat has a hundredth of the area of slats around that are seen edge on, nearly:
    by power and distance alone one sample in fifty would go to it, but most of the light is its."""
    flat = sheet(1, (0.2, 0.0, 1.0), 0.05, 0.05)
    parts = [(flat.vertices, flat.triangles)]
    for k in range(200):  # seen edge on, nearly: they point at the origin
        center = np.array((0.4 + 0.002 * k, 0.3, 0.8))
        ray = center / np.linalg.norm(center)
        aside = np.cross(ray, (0.0, 0.0, 1.0))
        tilted = aside + 0.01 * np.cross(ray, aside)
        corner = center - 0.5 * 0.05 * (ray + tilted)
        quad_ = np.stack([corner, corner + 0.05 * ray, corner + 0.05 * tilted])
        parts.append((quad_, np.array([[0, 1, 2]])))
    starts = np.cumsum([0] + [len(v) for v, _ in parts])
    vertices = np.concatenate([v for v, _ in parts])
    triangles = np.concatenate([t + s for (_, t), s in zip(parts, starts, strict=False)])
    lamps = with_emitters([], mesh_of(vertices, triangles), RADIANCE)
    place = *(0.0, 0.0, 0.0), *(0.0, 0.0, 1.0)
    drawn = [sample_mesh(lamps, 0, *place, a, 0.5) for a in (np.arange(4096) + 0.5) / 4096]
    light = np.array([np.divide(sample[2] * sample[4], sample[5]) for sample in drawn])
    own = np.isin([lamps.faces.face[max(sample[6], 0) // 2] for sample in drawn], (0, 1))
    share = light[own].sum() / light.sum()
    assert share > 0.6 and own.mean() > 0.5


def test_sheets_are_drawn_by_the_side_that_shines():
    """Of two alike, of which one shows its back, the other one is drawn, from the top of the tree
    on: by how faces are turned alone each had half of the samples."""
    sheets = [sheet(12, (0.8, 0.1, 1.0)), sheet(12, (0.7, -0.5, 1.0), turned=True)]
    starts = np.cumsum([0] + [len(one.vertices) for one in sheets])
    vertices = np.concatenate([one.vertices for one in sheets])
    pairs = zip(sheets, starts, strict=False)
    triangles = np.concatenate([one.triangles + start for one, start in pairs])
    own = with_emitters([], mesh_of(vertices, triangles), RADIANCE)
    one_sided = own.faces.power * (1.0, 0.0)
    nodes, leaves = face_nodes(own.faces.corners, one_sided)
    lamps = own._replace(faces=own.faces._replace(power=one_sided, nodes=nodes, leaves=leaves))
    place = *(0.0, 0.0, 0.0), *(0.0, 0.0, 1.0)
    drawn = [sample_mesh(lamps, 0, *place, a, 0.5) for a in (np.arange(512) + 0.5) / 512]
    seen = np.array([sample[4] > 0.0 and sample[6] % 2 == 0 for sample in drawn])
    assert seen.mean() > 0.9


def test_a_face_within_rounding_of_a_point_brings_nothing():
    """A sheet that shines, nearer than rays start off their point (1.9e-6 m here): it is the face
    that the point is on. Samples would find a cosine in the rounding."""
    own = quad((-0.5, -0.5, 1e-6), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    both = np.stack([RADIANCE[1], RADIANCE[1]])
    vertices, triangles = join_parts([own])[:2]
    for sides in (triangles, triangles[:, ::-1]):
        lamps = with_emitters([], mesh_of(vertices, sides), both)
        assert not sampled([], MATERIALS["diffuse"], 2000, 4, lamps=lamps).any()


CASES = [(steps, turned, name) for steps, turned in ((1, False), (9, True)) for name in MATERIALS]


@pytest.mark.slow
@pytest.mark.statistical
@pytest.mark.parametrize(("steps", "turned", "name"), CASES)
def test_a_mesh_lights_as_a_rectangle_does(steps, turned, name):
    """On both sides, however it is cut; t test at alpha = 1e-3 in all; 5 % more is rejected."""
    row = {"kind": RECTANGLE, "position": (0.8, 0.1, 1.0), "size": (0.6, 0.3)}
    row |= {"right": RIGHT, "up": UP, "forward": FORWARD, "radiance": RADIANCE[1]}
    # The rectangle's own estimator agrees with quadrature (test_lamps.py); its error here is small.
    expected = sampled([row], MATERIALS[name], 4000, 32).sum(1).mean()
    lamps = with_emitters([], sheet(steps, turned=turned), RADIANCE)
    found = sampled([], MATERIALS[name], lamps=lamps).sum(1)
    near = abs(found.mean() / expected - 1.0) < 2e-3
    assert near or t_p_value(found, expected) > sidak(1e-3, len(CASES)), (found.mean(), expected)
    wrong = t_p_value(found, 1.05 * expected) < sidak(1e-3, len(CASES))
    assert wrong or found.std() / found.mean() > 0.5


def test_a_mirror_shows_a_mesh():
    """A mirror that looks into a sheet of many faces has its radiance, nearly in each sample."""
    center, ones = (0.6, 0.0, 0.8), np.array([[0.0] * 3, [1.0] * 3], np.float32)
    lamps = with_emitters([], sheet(9, center, 0.6, 0.6), ones)
    total = sampled([], glossy(1e-3, (1.0, 1.0, 1.0)), 500, 1, lamps=lamps)[:, 3]
    assert abs(total.mean() - 1.0) < 0.02 and np.median(np.abs(total - 1.0)) < 0.02


BOXES = [((0.5, -0.2, 0.15), (0.9, 0.2, 0.55)), ((-0.2, -0.2, 0.3), (0.2, 0.2, 0.7))]


NEAR = {"diffuse": MATERIALS["diffuse"], "paint": MATERIALS["paint"], "rough": glossy(0.8)}


@pytest.mark.parametrize("name", NEAR)
def test_beside_a_shining_wall_no_sample_is_most_of_the_light(name):
    """A centimetre from the foot of a wall of 1 m: half of the hemisphere is wall. Samples that are
    even over its area bring up to thousands of times the mean, and seldom; the BSDF's bring it."""
    wall = quad((0.01, -0.5, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    lamps = with_emitters([], mesh_of(*join_parts([wall])[:2]), RADIANCE)
    light = sampled([], NEAR[name], pixels=2000, numbers=8, lamps=lamps).sum(axis=1)
    assert light.std() < 0.5 * light.mean() and light.max() < 4.0 * light.mean()
    if name == "diffuse":  # of the wall as seen from its foot: half of all, but .6 % over its edges
        expected = 0.5 * (RADIANCE[1] @ (0.8, 0.5, 0.3))
        assert light.mean() == pytest.approx(expected, rel=0.02)


def _box_share(low, high, steps=1500):
    """The part of a cosine-weighted hemisphere about z that a box covers, seen from the origin."""
    u, v = np.meshgrid(*[(np.arange(steps) + 0.5) / steps] * 2)
    radius, phi = np.sqrt(u).ravel(), 2.0 * np.pi * v.ravel()
    wi = np.stack([radius * np.cos(phi), radius * np.sin(phi), np.sqrt(1.0 - u.ravel())], 1)
    ends = np.stack([np.divide(corner, wi) for corner in (low, high)])
    return float((ends.min(0).max(1) <= ends.max(0).min(1)).mean())


FAR = quad((20.0, 20.0, -9.0), (0.1, 0.0, 0.0), (0.0, 0.1, 0.0))  # makes a scene's size 20 m


@pytest.mark.parametrize("name", ["diffuse", "gloss"])
def test_both_sides_of_what_is_clear_light(name):
    """Of a box that stops no ray near and far sides light alike, beside it and in gloss: twice as
    much as of one that does; to 2 %, of 4000 points with 8 samples (error .3 %)."""
    low, high = BOXES[0]
    vertices, triangles = box(low, high)[:2]
    ones = np.array([[0.0] * 3, [1.0] * 3], np.float32)
    lamps = with_emitters([], mesh_of(vertices, triangles), ones)
    blocker = join_parts([box(low, high), FAR])
    solid = sampled([], MATERIALS[name], 4000, 8, blocker=blocker, lamps=lamps)
    through = lamps._replace(layers=np.full_like(lamps.layers, 8))
    found = sampled([], MATERIALS[name], 4000, 8, blocker=FAR, lamps=through)
    assert found.sum() == pytest.approx(2.0 * solid.sum(), rel=0.02)


@pytest.mark.parametrize(("low", "high"), BOXES)
def test_a_box_lights_by_all_that_is_seen_of_it(low, high):
    """Its far sides are in the shadow of the near ones, which are seen flat; to 1 % of the truth.

    4000 points with 32 samples each have a standard error of .2 %. A face 20 m away has rays start
    and end farther from surfaces, as in a scene of that size.
    """
    vertices, triangles = box(low, high)[:2]
    blocker = join_parts([box(low, high), FAR])
    ones = np.array([[0.0] * 3, [1.0] * 3], np.float32)
    lamps = with_emitters([], mesh_of(vertices, triangles), ones)
    found = sampled([], diffuse((0.8,) * 3), 4000, 32, blocker=blocker, lamps=lamps)
    assert found[:, :3].mean() == pytest.approx(0.8 * _box_share(low, high), rel=0.01)
