"""Shadow catchers and holdouts: what the picture shows in place of the surface."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.asked_passes import AskedPasses
from iwis.core.data.lamps import NO_LAMPS, SPHERE, make_lamps
from iwis.core.lamplight.emitters import with_emitters
from iwis.core.scene import CAMERA_RAYS, HOLDOUT, SHADOW_CATCHER, SHADOW_RAYS
from support.scenes import (
    box,
    camera_at,
    constant_world,
    diffuse,
    floor,
    gradient_world,
    make_picture,
    make_scene,
)

_PLAIN = CAMERA_RAYS | SHADOW_RAYS
FILTERS = pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])


def _scene(flags, world=None, transparent=False, with_box=True):
    """A vast floor with flags, a box on it, and the camera looking down at both."""
    parts, kinds = [floor(200.0)], [_PLAIN | flags]
    if with_box:
        parts, kinds = [*parts, box((-0.3, -0.3, 0.0), (0.3, 0.3, 0.8))], [*kinds, _PLAIN]
    camera = camera_at((1.5, -2.0, 2.5), (0.0, 0.0, 0.2), 24, 16, 0.5)
    materials = [diffuse((0.5, 0.6, 0.7))] * len(parts)
    scene = make_scene(parts, materials, world or constant_world(), camera)
    return dataclasses.replace(scene, object_flags=np.uint8(kinds), transparent_film=transparent)


def _render(scene, pixel_filter="BOX", samples=256):
    return make_picture(scene, max_samples=samples, stop_rule="FIXED", pixel_filter=pixel_filter)[0]


@FILTERS
def test_empty_catcher_is_the_world_behind_it(pixel_filter):
    """Nothing stands on it: the picture is the one without a floor, the opacity 0."""
    scene = _scene(SHADOW_CATCHER, gradient_world(), with_box=False)
    bare = dataclasses.replace(scene, object_flags=np.uint8([0]))  # no ray sees the floor
    ours, theirs = _render(scene, pixel_filter), _render(bare, pixel_filter)
    np.testing.assert_allclose(ours["combined"], theirs["combined"], rtol=1e-4)
    np.testing.assert_allclose(ours["shadow_catcher"], 1.0, rtol=1e-5)
    film = _render(dataclasses.replace(scene, transparent_film=True), pixel_filter)
    assert np.abs(film["combined"]).max() < 1e-4


@FILTERS
def test_catcher_shows_the_part_of_the_light_that_arrives(pixel_filter):
    """Of an even sky: as dark as the floor gets itself, on the world's colour; less alpha."""
    plain = _render(_scene(0), pixel_filter, 1024)
    caught = _render(_scene(SHADOW_CATCHER), pixel_filter, 1024)
    film = _render(_scene(SHADOW_CATCHER, transparent=True), pixel_filter, 1024)
    # Pixels that show the floor alone; both pictures are sampled by themselves: 3 % of noise each.
    on_floor = (film["combined"][..., :3] == 0.0).all(axis=2)
    assert 30 < on_floor.sum() < on_floor.size
    share = plain["combined"][on_floor, :3] / np.float32([0.5, 0.6, 0.7])
    assert share.min() < 0.8  # there is a shadow
    np.testing.assert_allclose(caught["shadow_catcher"][on_floor], share, atol=0.06)
    np.testing.assert_allclose(caught["combined"][on_floor, :3], share, atol=0.06)
    alpha = film["combined"][on_floor, 3]
    np.testing.assert_allclose(alpha, 1.0 - share.mean(axis=1), atol=0.06)
    assert abs(alpha.mean() - (1.0 - share).mean()) < 0.005
    assert film["combined"][~on_floor, 3].max() == 1.0


@FILTERS
@pytest.mark.parametrize("lamp", ["ball", "mesh"])
def test_catcher_shows_the_shadow_of_a_lamp(pixel_filter, lamp):
    """Beside a dim sky: as dark as the floor gets itself beside one without a box; elsewhere 1.

    A mesh is one of the objects, as in Cycles: its light is compared with none of it, and adds to
    what else arrives. The picture has the mean of the colours, up to 1: red that is more than all
    makes up for blue that is less.
    """
    world, rows = constant_world((0.1, 0.1, 0.1)), []
    ball = {"kind": SPHERE, "position": (-3.0, 1.0, 4.0), "size": (0.3, 0.0), "radiance": 20.0}
    lamps = make_lamps([ball])
    if lamp == "mesh":
        part = make_scene([box((-3.2, 0.8, 4.0), (-2.8, 1.2, 4.2))], [diffuse()], world, None).mesh
        lamps = with_emitters(rows, part, np.float32([[40.0, 20.0, 0.0]]))

    def picture(flags, with_box=True):
        scene = _scene(flags, world, with_box=with_box)
        shining = lamps if with_box or lamp == "ball" else NO_LAMPS
        return _render(dataclasses.replace(scene, lamps=shining), pixel_filter, 1024)

    plain, bare = picture(0)["combined"][..., :3], picture(0, False)["combined"][..., :3]
    caught = picture(SHADOW_CATCHER)
    on_floor = picture(HOLDOUT)["combined"][..., :3].sum(axis=2) == 0.0
    assert 30 < on_floor.sum() < on_floor.size
    share = plain[on_floor] / bare[on_floor]
    assert share.min() < 0.7 and share.max() > 0.95  # there is a shadow, and there is none
    # Three pictures with their own noise, of 1 to 3 % each at these counts; the mesh has 6, where
    # it is the brighter light.
    found = caught["shadow_catcher"][on_floor]
    np.testing.assert_allclose(np.minimum(found, 1.0), np.minimum(share, 1.0), atol=0.08)
    assert abs(found.mean() / share.mean() - 1.0) < 0.01
    gray = found.mean(axis=1, keepdims=True)
    if lamp == "mesh":
        assert ((gray[:, 0] > 1.0) & (share.min(axis=1) < 0.95)).sum() > 3
    gray = np.minimum(gray, 1.0)
    seen = caught["combined"][on_floor, :3]
    np.testing.assert_allclose(seen, np.repeat(0.1 * gray, 3, axis=1), rtol=1e-5)


@FILTERS
def test_passes_have_a_catcher_as_any_other_surface(pixel_filter):
    """What it is made of, what is around it, and the world that it shows, as in Cycles."""
    asked = AskedPasses(occlusion_distance=1.0)
    plain = _render(dataclasses.replace(_scene(0, gradient_world()), asked=asked), pixel_filter)
    scene = dataclasses.replace(_scene(SHADOW_CATCHER, gradient_world()), asked=asked)
    caught = _render(scene, pixel_filter)
    film = _render(dataclasses.replace(scene, transparent_film=True), pixel_filter)
    for name in ("normal", "diffuse_color", "glossy_color", "ambient_occlusion"):
        # Sums of the same passes in another order; FIXED has as many in both.
        np.testing.assert_allclose(caught[name], plain[name], atol=1e-5, err_msg=name)
        np.testing.assert_allclose(film[name], plain[name], atol=1e-5, err_msg=name)
    assert caught["ambient_occlusion"].min() < 0.7 and caught["ambient_occlusion"].max() == 1.0
    on_floor = (film["combined"][..., :3] == 0.0).all(axis=2)
    bare = dataclasses.replace(scene, object_flags=np.uint8([0, 0]), asked=AskedPasses())
    behind = _render(bare, pixel_filter)["environment"]
    np.testing.assert_allclose(caught["environment"][on_floor], behind[on_floor], rtol=1e-4)
    assert behind[on_floor].min() > 0.0 and not film["environment"].any()
    assert not caught["diffuse_direct"][on_floor].any()


def test_direct_light_is_divided_by_all_of_a_pixels_color():
    """At the edge of what stands on a catcher too: light times color is what the picture has."""
    film = _render(_scene(SHADOW_CATCHER, transparent=True))
    light = film["diffuse_direct"] * film["diffuse_color"]
    np.testing.assert_allclose(light, film["combined"][..., :3], atol=1e-5)
    assert len(np.unique(np.round(film["diffuse_direct"][..., 0], 2))) > 5


@FILTERS
@pytest.mark.parametrize("transparent", [False, True])
def test_with_the_pass_the_picture_has_a_hole_for_the_catcher(pixel_filter, transparent):
    """As in Cycles, in either film; the pass, and what stands on the catcher, stay as they were."""
    scene = _scene(SHADOW_CATCHER, transparent=transparent)
    usual = _render(scene, pixel_filter)
    asked = _render(dataclasses.replace(scene, asked=AskedPasses(catcher=True)), pixel_filter)
    np.testing.assert_array_equal(asked["shadow_catcher"], usual["shadow_catcher"])
    film = _render(_scene(SHADOW_CATCHER, transparent=True), pixel_filter)["combined"]
    on_floor = (film[..., :3] == 0.0).all(axis=2)
    assert 30 < on_floor.sum() < on_floor.size and usual["combined"][on_floor, 3].max() > 0.2
    assert not asked["combined"][on_floor].any()
    whole = film[..., 3] == 1.0
    np.testing.assert_array_equal(asked["combined"][whole], usual["combined"][whole])


@FILTERS
def test_picture_over_the_world_times_the_pass_is_the_usual_one(pixel_filter):
    """At edges too: there the pass is the share of the catcher alone, as in Cycles."""
    usual = _render(_scene(SHADOW_CATCHER), pixel_filter)["combined"]
    asked = dataclasses.replace(_scene(SHADOW_CATCHER), asked=AskedPasses(catcher=True))
    layers = _render(asked, pixel_filter)
    hole = 1.0 - layers["combined"][..., 3:]
    assert pixel_filter == "CENTER" or ((hole > 0.1) & (hole < 0.9)).sum() > 10
    behind = layers["shadow_catcher"].mean(axis=2, keepdims=True)  # the world is 1 all round
    whole = layers["combined"][..., :3] + hole * behind
    np.testing.assert_allclose(whole, usual[..., :3], atol=1e-5)


def test_catchers_throw_no_shadow_on_each_other():
    """A wall on a floor, both catchers: nothing is to be seen of them."""
    scene = _scene(SHADOW_CATCHER)
    both = dataclasses.replace(scene, object_flags=scene.object_flags | SHADOW_CATCHER)
    np.testing.assert_allclose(_render(both)["shadow_catcher"], 1.0, rtol=1e-5)


@FILTERS
@pytest.mark.parametrize("transparent", [False, True])
def test_holdout_is_a_hole(pixel_filter, transparent):
    """The floor is black and clear, in either film; the box before it and the world stay."""
    hole = _render(_scene(HOLDOUT, transparent=transparent), pixel_filter)["combined"]
    plain = _render(_scene(0, transparent=transparent), pixel_filter)["combined"]
    gone = (hole[..., :3] == 0.0).all(axis=2)
    assert 30 < gone.sum() < gone.size
    assert (hole[gone, 3] == 0.0).all()
    assert transparent or (plain[..., 3] == 1.0).all()
    whole = (plain[..., 3] == 1.0) & (hole[..., 3] == 1.0) & ~gone
    if pixel_filter == "CENTER":
        np.testing.assert_allclose(hole[whole], plain[whole], rtol=1e-5)


@FILTERS
def test_passes_have_nothing_of_a_hole(pixel_filter):
    """As in Cycles: holdouts have no depth, place, number, normal and color."""
    scene = dataclasses.replace(_scene(HOLDOUT), object_pass_index=np.float32([3.0, 4.0]))
    layers = _render(scene, pixel_filter)
    hole = (layers["combined"] == 0.0).all(axis=2)
    assert 30 < hole.sum() < hole.size
    for name in ("position", "object_index", "normal", "diffuse_color", "ambient_occlusion"):
        assert not layers[name][hole].any(), name
    assert (layers["depth"][hole] >= 1e9).all()
    box = layers["combined"][..., 3] == 1.0
    assert (layers["object_index"][box] == 4.0).all() and (layers["depth"][box] < 9.0).all()


@FILTERS
def test_what_is_a_catcher_and_a_holdout_is_a_hole(pixel_filter):
    """In a transparent film clear, in an opaque one black and, as beside any catcher, opaque."""
    film = _render(_scene(HOLDOUT | SHADOW_CATCHER, transparent=True), pixel_filter, 16)
    hole = _render(_scene(HOLDOUT, transparent=True), pixel_filter, 16)
    for name in ("combined", "shadow_catcher"):
        np.testing.assert_array_equal(film[name], hole[name])
    opaque = _render(_scene(HOLDOUT | SHADOW_CATCHER), pixel_filter, 16)["combined"]
    black = (hole["combined"][..., :3] == 0.0).all(axis=2)
    assert 30 < black.sum() < black.size
    assert (opaque[black, :3] == 0.0).all() and (opaque[..., 3] == 1.0).all()


@FILTERS
def test_beside_a_catcher_in_an_opaque_film_all_is_opaque(pixel_filter):
    """As in Cycles: holdouts are black there, without a catcher holes in alpha as well."""
    scene = _scene(SHADOW_CATCHER)
    hole = np.uint8([_PLAIN | SHADOW_CATCHER, _PLAIN | HOLDOUT])
    beside = _render(dataclasses.replace(scene, object_flags=hole), pixel_filter, 16)["combined"]
    hole = np.uint8([_PLAIN, _PLAIN | HOLDOUT])
    alone = _render(dataclasses.replace(scene, object_flags=hole), pixel_filter, 16)["combined"]
    black = (beside[..., :3] == 0.0).all(axis=2)
    assert 10 < black.sum() < black.size
    np.testing.assert_allclose(beside[..., 3], 1.0, atol=1e-6)
    assert not alone[black, 3].any()
