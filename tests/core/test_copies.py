"""Copies: Embree's instances show what the same triangles would, written out."""

import dataclasses
import threading

import numpy as np
import pytest

from iwis.core.data.copies import Copies
from iwis.core.data.object_motion import ObjectMotion
from iwis.core.embree.copied_accel import CopiedAccel
from iwis.core.embree.copied_rows import CopiedRows, written_out
from iwis.core.embree.embree_instances import can_copy
from iwis.core.embree.moving_copies import MovingCopies
from iwis.core.machine.watch import StopFlag
from iwis.core.render_cache import RenderCache
from iwis.core.scene import CAMERA_RAYS, SHADOW_RAYS
from iwis.core.settings import RenderSettings
from iwis.core.windows.coarse_pictures import Pace
from iwis.core.windows.pixel_view import look_at_pixel
from iwis.core.windows.progressive import render_progressive
from support.scenes import (
    box,
    camera_at,
    diffuse,
    floor,
    gradient_world,
    make_picture,
    make_scene,
    principled,
    sphere,
)

pytestmark = pytest.mark.skipif(not can_copy(), reason="Embree older than 4.3")


def _turned(angle, scale, place):
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.concatenate([turn * np.asarray(scale, float), np.reshape(place, (3, 1))], axis=1)


def _normals_of(matrices):
    """Inverse transposes, (n, 3, 4)."""
    inverse = np.linalg.inv(matrices[:, :, :3]).transpose(0, 2, 1)
    return np.pad(inverse, ((0, 0), (0, 0), (0, 1)))


def copied_scene(n=40, rings=10, pixel=(56, 40)):
    """A floor, and a smooth sphere and a box that stand in many places: turned, stretched, some
    mirrored."""
    rng = np.random.default_rng(3)
    parts = [floor(3.0), sphere((0.0, 0.0, 0.3), 0.25, rings, smooth=True)]
    parts.append(box((0.5, 0.5, 0.0), (0.7, 0.8, 0.5)))
    scene = make_scene(
        parts,
        [
            diffuse((0.6, 0.5, 0.4)),
            principled(base_color=(0.2, 0.5, 0.8), roughness=0.4),
            principled(base_color=(0.9, 0.8, 0.3), metallic=1.0, roughness=0.3),
        ],
        gradient_world(),
        camera_at((2.6, -4.2, 2.7), (0.0, 0.0, 0.2), *pixel, 0.5),
    )
    sizes = [0.4 + 0.8 * rng.random(3) for _ in range(n)]
    for k in range(0, n, 4):
        sizes[k][0] *= -1.0
    places = [(*rng.uniform(-2.0, 2.0, 2), 0.0) for _ in range(n)]
    turns = rng.uniform(0.0, 6.0, n)
    matrices = np.array([_turned(*each) for each in zip(turns, sizes, places, strict=True)])
    first, end = np.array(
        [np.flatnonzero(scene.mesh.object_index == k)[[0, -1]] + (0, 1) for k in (1, 2)]
    ).T
    copies = Copies(
        first.astype(np.int64),
        end.astype(np.int64),
        rng.integers(0, 2, n).astype(np.int32),
        np.arange(3, 3 + n, dtype=np.int32),
        matrices.astype(np.float32),
        _normals_of(matrices).astype(np.float32),
        np.linalg.det(matrices[:, :, :3]) < 0.0,
    )
    return dataclasses.replace(
        scene, copies=copies, object_pass_index=np.arange(3.0 + n, dtype=np.float32)
    )


def test_a_copy_is_written_out_as_numpy_has_it():
    scene = copied_scene()
    copies, whole = scene.copies, written_out(scene)
    assert len(whole.mesh.triangles) == len(scene.mesh.triangles) + copies.triangles
    row = len(scene.mesh.triangles)
    for original, matrix, normals, turned, number in zip(
        copies.original, copies.matrices, copies.normals, copies.turned, copies.objects, strict=True
    ):
        own = slice(copies.first[original], copies.end[original])
        order = [0, 2, 1] if turned else [0, 1, 2]
        corners = scene.mesh.vertices[scene.mesh.triangles[own]][:, order]
        expected = corners @ matrix[:, :3].T + matrix[:, 3]
        n = own.stop - own.start
        found = whole.mesh.vertices[whole.mesh.triangles[row : row + n]]
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-6)  # float32, metres
        smooth = scene.mesh.corner_normals[own][:, order] @ normals[:, :3].T
        smooth /= np.linalg.norm(smooth, axis=2, keepdims=True)
        given = whole.mesh.corner_normals[row : row + n]
        given = given / np.linalg.norm(given, axis=2, keepdims=True)
        np.testing.assert_allclose(given, smooth, rtol=0.0, atol=2e-6)
        across = np.cross(found[:, 1] - found[:, 0], found[:, 2] - found[:, 0])
        assert (np.einsum("ij,ij->i", across, given[:, 0]) > 0.0).all()
        assert (whole.mesh.object_index[row : row + n] == number).all()
        row += n
    assert whole.copies is None


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BLACKMAN_HARRIS"])
def test_the_picture_is_that_of_the_triangles_written_out(pixel_filter):
    scene = copied_scene()
    own = {"max_samples": 16, "stop_rule": "FIXED", "pixel_filter": pixel_filter, "threads": 2}
    found, stats = make_picture(scene, **own)
    expected, written = make_picture(written_out(scene), **own)
    assert stats.triangles == written.triangles
    for name in ("object_index", "material_index", "depth", "normal", "combined"):
        # Rays that graze an edge meet another face: instances round otherwise. Of the others what
        # they meet is the same but for float32's steps, and so are nearly all shadow rays.
        off = np.abs(found[name] - expected[name]) > 1e-3 * np.abs(expected[name]) + 1e-4
        assert off.any(axis=2).mean() < 0.005, name
    assert found["combined"].mean() == pytest.approx(expected["combined"].mean(), rel=2e-4)
    assert len(np.unique(found["object_index"])) > 20


def test_hits_of_two_questions_lie_on_other_rows():
    scene, cache = copied_scene(), RenderCache()
    accel = cache.rays(scene)
    assert isinstance(accel, CopiedAccel)
    table = CopiedRows(scene, RenderSettings(), 1)
    rays = accel.with_rows(table)
    origins = np.tile(np.float32([[0.0, 0.0, 5.0]]), (200, 1))
    origins[:, :2] = np.random.default_rng(1).uniform(-1.5, 1.5, (200, 2))
    down = np.tile(np.float32([[0.0, 0.0, -1.0]]), (200, 1))
    first, second = (rays.intersect(origins, down, rays.slots(200))[0] for _ in range(2))
    copied = first >= len(scene.mesh.triangles)
    assert copied.sum() > 20 and not np.isin(first[copied], second).any()
    before = table.scene.mesh.vertices[table.scene.mesh.triangles[first]].copy()
    passing = [rays.intersect(origins, down)[0] for _ in range(2)]
    np.testing.assert_array_equal(*passing)
    rays.intersect(origins, down, rays.slots(200))
    np.testing.assert_array_equal(
        before, table.scene.mesh.vertices[table.scene.mesh.triangles[first]]
    )


def test_rows_of_a_tile_stay_apart_from_those_that_pass():
    """However often a tile asks: its last rows, and those of nodes' rays, are not written over."""
    table = CopiedRows(copied_scene(4), RenderSettings(), 1)
    passing, before = table._passing(64), np.zeros(0, np.int32)
    for _ in range(7):
        rows = table.slots(table._most * 3 // 4)
        assert not np.isin(rows, passing).any() and not np.isin(rows, before).any()
        before = rows


def test_threads_that_have_ended_give_their_rows_back():
    table = CopiedRows(copied_scene(4), RenderSettings(), 1)
    found = []
    for _ in range(6):
        thread = threading.Thread(target=lambda: found.append(table.slots(8)[0]))
        thread.start()
        thread.join()
    assert len(found) == 6
    table.slots(8)
    late, held = [], threading.Event()
    first = threading.Thread(target=lambda: (late.append(table.slots(8)), held.wait()))
    first.start()
    second = threading.Thread(target=lambda: late.append(table.slots(8)))
    second.start()  # finds no share until the first one has ended
    held.set()
    first.join()
    second.join()
    assert len(late) == 2
    with pytest.raises(ValueError, match="rays look at once"):
        table.slots(1 << 30)


def test_hierarchies_are_kept_where_copies_alone_have_moved():
    scene, cache = copied_scene(), RenderCache()
    first = cache.rays(scene)
    assert cache.rays(dataclasses.replace(scene)) is first
    up = scene.copies.matrices + np.float32([[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0.1]])
    moved = dataclasses.replace(scene, copies=scene.copies._replace(matrices=up))
    second = cache.rays(moved)
    assert second is not first and second._parts is first._parts
    own = {"max_samples": 8, "stop_rule": "FIXED"}
    ours, expected = (make_picture(moved, c, **own)[0] for c in (cache, RenderCache()))
    for name, layer in expected.items():
        np.testing.assert_array_equal(ours[name], layer, err_msg=name)
    others = moved.copies._replace(end=moved.copies.end - np.int64([2, 0]))
    third = cache.rays(dataclasses.replace(scene, copies=others))
    assert third._parts is not first._parts


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BLACKMAN_HARRIS"])
def test_a_window_shows_copies_at_last_as_a_render_does(pixel_filter):
    scene, shown = copied_scene(), []
    own = {"max_samples": 16, "stop_rule": "FIXED", "pixel_filter": pixel_filter}
    settings = RenderSettings(**own, threads=2)
    asked = shown.append, RenderCache(), Pace(), StopFlag(), StopFlag()
    render_progressive(scene, settings, *asked)
    expected, _ = make_picture(scene, **own)
    last = shown[-1].layers["combined"]
    # Products are made anew after each pause: samples move by float32's last bits.
    np.testing.assert_allclose(last.mean(), expected["combined"].mean(), rtol=2e-3)


def test_a_pixel_of_a_copy_can_be_looked_at():
    scene = copied_scene()
    layers, _ = make_picture(scene, max_samples=4, stop_rule="FIXED")
    y, x = np.argwhere(layers["object_index"][..., 0] >= 3)[0]
    view = look_at_pixel(scene, RenderSettings(max_samples=16), int(x), int(y), 16)
    np.testing.assert_allclose(view.position, layers["position"][y, x], atol=1e-5)


@pytest.mark.parametrize("stop_rule", ["BUDGET", "PERCEPTUAL", "PAPER"])
@pytest.mark.parametrize("pixel_filter", ["CENTER", "BLACKMAN_HARRIS"])
def test_every_rule_finds_copies_where_they_are(stop_rule, pixel_filter):
    """A budget goes from tile to tile and back: what it has seen is looked at anew."""
    scene = copied_scene(pixel=(70, 50))
    own = {"stop_rule": stop_rule, "pixel_filter": pixel_filter, "tile_px": 16, "threads": 2}
    if stop_rule == "BUDGET":
        own |= {"target_samples": 12, "max_samples": 64}
    else:
        own |= {"max_samples": 32, "error_threshold": 0.1}
    ours, expected = (make_picture(one, **own)[0] for one in (scene, written_out(scene)))
    for name in ("object_index", "material_index", "depth", "normal"):
        np.testing.assert_allclose(ours[name], expected[name], rtol=1e-4, atol=2e-3)
    mean = expected["combined"].mean()
    np.testing.assert_allclose(ours["combined"].mean(), mean, rtol=3e-3)  # counts differ a little


def test_a_part_without_copies_is_no_trouble():
    """Nor is one without anything."""
    scene = copied_scene()
    motion = ObjectMotion(np.zeros(1, np.int32), np.array([0.5]), np.eye(4)[None, None])
    for mask in (scene.mesh.object_index == 0, scene.mesh.object_index > 5):
        for accel in (
            CopiedAccel(scene.mesh, scene.copies, mask),
            MovingCopies(scene.mesh, motion, scene.copies, mask),
        ):
            rays = accel.with_rows(CopiedRows(scene, RenderSettings(), 1))
            down = np.float32([[0.0, 0.0, -1.0]])
            hit, _, _ = rays.intersect(np.float32([[0.6, 0.6, 5.0]]), down, rays.slots(1))
            assert (hit[0] >= 0) == mask.any()
            assert rays.occluded(np.float32([[0.6, 0.6, 5.0]]), down)[0] == mask.any()


@pytest.mark.parametrize(("moves", "links"), [(0, False), (0, True), (7, False)])
def test_the_shutter_may_be_open(moves, links):
    """While the floor moves (0), also where rays see different hierarchies, or a copy does (7)."""
    scene = copied_scene()
    times = (np.arange(8) + 0.5) / 8
    matrices = np.tile(np.eye(4), (8, 1, 1, 1))
    matrices[:, 0, 2, 3] = 0.2 * times
    motion = ObjectMotion(np.array([moves], np.int32), times, matrices)
    scene = dataclasses.replace(scene, motion=motion)
    if links:
        flags = np.full(len(scene.object_pass_index), CAMERA_RAYS | SHADOW_RAYS, np.uint8)
        flags[0] = CAMERA_RAYS
        scene = dataclasses.replace(scene, object_flags=flags)
    assert scene.copies.move(motion, scene.mesh.object_index) == (moves == 7)
    own = {"max_samples": 32, "stop_rule": "FIXED", "pixel_filter": "BLACKMAN_HARRIS"}
    ours, expected = (make_picture(one, **own)[0] for one in (scene, written_out(scene)))
    for name in ("object_index", "depth", "normal", "combined"):
        off = np.abs(ours[name] - expected[name]) > 1e-3 * np.abs(expected[name]) + 1e-4
        assert off.any(axis=2).mean() < 0.01, name
