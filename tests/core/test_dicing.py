"""Patches to micropolygons: how many, how large, and that there are no cracks."""

import dataclasses

import numpy as np
import pytest

from iwis.core.fine_meshes.bezier_patches import flat_patches, smooth_patches
from iwis.core.fine_meshes.dicing import Patches, split_patches
from iwis.core.fine_meshes.dicing_view import camera_view, own_space
from iwis.core.fine_meshes.micropolygons import make_micropolygons
from iwis.core.fine_meshes.patch_values import at_corners, at_vertices, evaluate
from iwis.core.fine_meshes.subdivision import refined, with_sharp_corners
from iwis.core.scene import Camera
from support.control_meshes import cube, grid, quads_of

_MANY = 10**8
_CAMERA = Camera(
    kind="PERSPECTIVE",
    camera_to_world=np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 6], [0, 0, 0, 1.0]]),
    window=(-0.5, 0.5, -0.5, 0.5),
    width=256,
    height=256,
    region=(0, 0, 256, 256),
    clip_start=0.1,
    clip_end=100.0,
)


def _patches(control, linear=True, level=0):
    quads = quads_of(control)
    points = flat_patches(control.points[quads]) if linear else smooth_patches(control)
    edges = control.edge_of.reshape(-1, 4)
    return Patches(points, quads, edges, control.ends, len(control.points), level)


def _diced(patches, view, max_level=12):
    made = make_micropolygons(*split_patches(patches, view, max_level, _MANY))
    return made, evaluate(patches.points, patches.steps, made)


def _seen(rate=1.0, offscreen=4.0, place=(0.0, 0.0, 0.0), **camera):
    matrix = np.eye(4)
    matrix[:3, 3] = place
    return camera_view(dataclasses.replace(_CAMERA, **camera), matrix, rate, offscreen)


def _area_vectors(places, triangles):
    a, b, c = (places[corner].astype(np.float64) for corner in triangles.T)
    return np.cross(b - a, c - a) / 2.0


def _edges(triangles):
    """How often each edge is there, and how often in its direction."""
    ends = np.concatenate([triangles, np.roll(triangles, -1, 1)]).reshape(2, -1).T
    _, directed = np.unique(ends, axis=0, return_counts=True)
    _, plain = np.unique(np.sort(ends, axis=1), axis=0, return_counts=True)
    return plain, directed


@pytest.mark.parametrize("linear", [True, False])
@pytest.mark.parametrize("place", [(0, 0, 0), (0.3, 0.1, 4.5), (0.2, -0.3, 5.6), (5.0, 1.0, 3.0)])
def test_closed_meshes_stay_closed(linear, place):
    """Near or far, before the camera or around it: each edge is shared by two triangles that run
    along it in opposite directions, no triangle is empty, all face outwards."""
    control = refined(cube((1.0, 0.6, 1.4)), linear)
    patches = _patches(control, linear, 1)
    made, (places, _) = _diced(patches, _seen(4.0, place=place), 9)
    plain, directed = _edges(made.triangles)
    assert (plain == 2).all() and (directed == 1).all()
    assert (made.vertex_patch >= 0).all() and len(made.triangles) > 500
    vectors = _area_vectors(places, made.triangles)
    assert np.linalg.norm(vectors, axis=1).min() > 0.0
    volume = np.einsum("ij,ij->", vectors, places[made.triangles[:, 0]].astype(np.float64)) / 3.0
    if linear:
        assert volume == pytest.approx(6.72, rel=2e-6)  # float32
    else:  # a round one: facets of some degrees cut a little off
        finest, (fine, _) = _diced(patches, own_space(0.02))
        whole = np.einsum(
            "ij,ij->", _area_vectors(fine, finest.triangles), fine[finest.triangles[:, 0]]
        )
        assert 0.95 * whole / 3.0 < volume < 1.0001 * whole / 3.0
    outward = np.einsum("ij,ij->i", vectors, places[made.triangles[:, 0]])
    assert (outward > 0.0).all()


def test_edges_have_the_size_that_is_asked_for():
    """In pixels of what is straight ahead, wherever on a face: at most 1, most of them more than a
    half, diagonals by root two longer."""
    made, (places, _) = _diced(_patches(grid(2, lambda x, y: 0 * x)), _seen(2.0, 1.0))
    corners = places[made.triangles]
    lengths = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)
    middle = (corners + np.roll(corners, 1, axis=1)) / 2.0
    pixels = lengths / np.linalg.norm(middle - [0.0, 0.0, 6.0], axis=-1) * 256
    # Edges are as uneven as a leaf's ends: by less than one in eight.
    assert pixels.max() < 2.0 * np.sqrt(2.0) * 1.125 and np.median(pixels) > 1.5


def test_what_is_outside_of_the_frame_is_coarser():
    """By the offscreen scale; a scale of 1 changes nothing."""
    patches = _patches(grid(1, lambda x, y: 0 * x))
    counts = [
        [len(_diced(patches, _seen(1.0, scale, place=(x, 0, 0)))[0].triangles) for scale in (1, 4)]
        for x in (0.0, 20.0)
    ]
    (same, also), (fine, coarse) = counts
    assert same == also and coarse < fine / 9
    panes = [_seen(1.0, 4.0, place=(0, 0, z)) for z in (0.0, 12.0)]  # before, behind
    before, behind = (len(_diced(patches, view)[0].triangles) for view in panes)
    assert behind < before / 9


def test_no_edge_has_more_parts_than_allowed():
    """2**max_level of an edge of the mesh, whatever its level."""
    whole = grid(1, lambda x, y: 0 * x)
    for level, control in enumerate((whole, refined(whole, linear=True))):
        made, _ = _diced(_patches(control, True, level), own_space(1e-3), max_level=3)
        assert len(made.triangles) == 2 * 8**2


def test_too_many_are_not_made():
    """More than the limit: None, and soon."""
    patches = _patches(grid(1, lambda x, y: 0 * x))
    assert split_patches(patches, own_space(1e-4), 12, 10_000) is None
    assert split_patches(patches, own_space(0.1), 12, 10_000) is not None


@pytest.mark.parametrize("kind", ["ORTHOGRAPHIC", "PERSPECTIVE"])
def test_long_faces_have_square_micropolygons(kind):
    """A strip of 8 x 1 has about eight times as many along as across."""
    control = grid(1, lambda x, y: 0 * x)
    strip = control._replace(points=control.points * [1.0, 0.125, 1.0])
    window = (-3.0, 3.0, -3.0, 3.0) if kind == "ORTHOGRAPHIC" else _CAMERA.window
    made, _ = _diced(_patches(strip), _seen(1.0, 1.0, kind=kind, window=window))
    uv = at_vertices(np.float32([[[0, 0], [1, 0], [1, 1], [0, 1]]]), made)
    along, across = (len(np.unique(np.round(column, 5))) - 1 for column in uv.T)
    assert 6.0 < along / across < 10.5


def test_parts_of_patches_are_found():
    """Of a regular mesh the parts after two steps have the very same surface: each place, normal
    and value is where it was without them."""
    control = with_sharp_corners(grid(3, lambda x, y: np.sin(x) * np.cos(0.7 * y)))
    whole = _patches(control, False)
    parts = refined(refined(control))
    finer = whole._replace(points=smooth_patches(parts), steps=2)
    made, (places, normals) = _diced(whole, own_space(0.2))
    others, turned = evaluate(finer.points, 2, made)
    np.testing.assert_allclose(others, places, atol=3e-6)
    np.testing.assert_allclose(turned, normals, atol=2e-5)
    corners = ((0, 0), (0, 3), (3, 3), (3, 0))
    values = np.stack([finer.points[:, j, i] for j, i in corners], 1)
    straight = at_corners(values, made, 2)
    # Linear between corners of parts: off by what a quarter of a patch bends.
    np.testing.assert_allclose(straight, places[made.triangles], atol=0.05)
    assert np.abs(straight - at_corners(values[::16], made)).max() > 0.1


def test_values_and_places_follow_their_patch():
    """Corner values are bilinear, as places of flat patches are; normals those of the plane."""
    control = grid(2, lambda x, y: 0.3 * x - 0.2 * y)
    patches = _patches(control)
    made, (places, normals) = _diced(patches, _seen(16.0))
    values = control.points[quads_of(control)].astype(np.float32)
    np.testing.assert_allclose(at_vertices(values, made), places, atol=2e-6)
    np.testing.assert_allclose(at_corners(values, made), places[made.triangles], atol=2e-6)
    expected = np.array([-0.3, 0.2, 1.0]) / np.sqrt(1.13)
    np.testing.assert_allclose(normals, np.broadcast_to(expected, normals.shape), atol=1e-5)
