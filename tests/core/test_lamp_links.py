"""Light linking: lamps that light some objects, and whose shadows some objects throw."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.lamps import RECTANGLE, SPHERE, LampLink, make_lamps
from iwis.core.data.object_motion import ObjectMotion
from iwis.core.lamplight.emitters import with_emitters
from iwis.core.render_cache import RenderCache
from iwis.core.scene import CAMERA_RAYS, SHADOW_CATCHER, SHADOW_RAYS
from support.lamp_rows import area
from support.scenes import (
    black,
    box,
    camera_above,
    constant_world,
    diffuse,
    floor,
    make_picture,
    make_scene,
    principled,
    quad,
)

DARK = constant_world((0.0, 0.0, 0.0))
FLAT = np.eye(3)
FILTERED = {"pixel_filter": "BOX", "max_samples": 64, "stop_rule": "FIXED"}
FILTERS = pytest.mark.parametrize(
    "settings", [{"max_samples": 64}, FILTERED], ids=["center", "filtered"]
)
POINT = {"kind": SPHERE, "position": (0.4, 0.3, 3.0), "radiance": (6.0, 5.0, 4.0)}
# From the left: both shelf and box throw shadows to the right of them.
SIDE = POINT | {"position": (-2.0, 0.3, 2.0), "link": 0}
PANEL = area(RECTANGLE, (-0.5, 0.2, 2.0), 0.6, 0.3, FLAT) | {"radiance": (3.0, 2.0, 1.0)}


def mask(*rows):
    """bool (3,), of floor, box and shelf: those named."""
    return np.isin(np.arange(3), rows)


def scene_of(rows, links=(), material=None, **fields):
    """A floor (0), a box that stands on it (1), a shelf over its left (2)."""
    parts = [
        floor(1.0),
        box((-0.2, -0.3, 0.0), (0.3, 0.2, 0.4)),
        quad((-0.9, -0.5, 0.6), (0.4, 0.0, 0.0), (0.0, 1.0, 0.0)),
    ]
    own = material or diffuse((0.8, 0.5, 0.3))
    scene = make_scene(parts, [own] * 3, DARK, camera_above(24, 24), lamps=make_lamps(rows))
    return dataclasses.replace(scene, lamp_links=tuple(links), **fields)


def picture(*args, settings, **fields):
    layers, _ = make_picture(scene_of(*args, **fields), **settings)
    return layers["combined"][..., :3], layers["object_index"][..., 0] - 20.0


@FILTERS
def test_a_lamp_lights_its_receivers_alone(settings):
    """They are as bright as under a lamp for all; the others are black."""
    whole, objects = picture([POINT], settings=settings)
    linked, _ = picture([POINT | {"link": 0}], [LampLink(mask(1), None)], settings=settings)
    if settings is FILTERED:  # pixels that show the box and nothing else
        rest, _ = picture([POINT | {"link": 0}], [LampLink(mask(0, 2), None)], settings=settings)
        np.testing.assert_allclose(linked + rest, whole, atol=1e-5)
        assert (linked[rest == 0.0] > 0.0).any() and (rest[linked == 0.0] > 0.0).any()
        return
    np.testing.assert_allclose(linked[objects == 1.0], whole[objects == 1.0], rtol=1e-5)
    assert (whole[objects != 1.0] > 0.0).any()
    assert (linked[objects != 1.0] == 0.0).all()


@FILTERS
def test_links_add_up(settings):
    """Two lamps of two links and one of none: the sum of the pictures of each alone."""
    links = [LampLink(mask(0, 1), mask(1)), LampLink(mask(1, 2), None)]
    rows = [POINT | {"link": 0}, PANEL | {"link": 1}, POINT | {"position": (-2.0, 1.0, 1.0)}]
    both, _ = picture(rows, links, settings=settings)
    alone = sum(picture([row], links, settings=settings)[0] for row in rows)
    # Of a lamp among others other numbers are drawn: the panel's 64 samples differ.
    assert np.abs(both - alone).mean() < 0.02 * alone.mean()
    np.testing.assert_allclose(both.mean(), alone.mean(), rtol=2e-3)


@FILTERS
@pytest.mark.parametrize("row", [SIDE, PANEL], ids=["point", "panel"])
def test_blockers_throw_the_shadows(settings, row):
    """Of no object, of the box, of all: free, the box's shadow, as without a link."""
    row = row | {"link": 0}
    none, box_alone, every = (
        picture([row], [LampLink(None, own)], settings=settings)[0]
        for own in (mask(), mask(1), mask(0, 1, 2))
    )
    free, _ = picture([row | {"shadow": False, "link": -1}], settings=settings)
    usual, _ = picture([row | {"link": -1}], settings=settings)
    np.testing.assert_allclose(none, free, atol=1e-6)
    np.testing.assert_allclose(every, usual, atol=1e-6)
    assert (usual.sum() < box_alone.sum()) and (box_alone.sum() < none.sum())
    assert (box_alone >= usual - 1e-6).all() and (box_alone <= none + 1e-6).all()


def test_a_mirror_shows_a_lamp_on_receivers_alone():
    """Narrow lobes find lamps by themselves (MIS): linked ones too."""
    panel = area(RECTANGLE, (0.0, 0.0, 2.0), 2.0, 2.0, FLAT) | {"radiance": 1.0, "shadow": False}
    shiny = principled(base_color=(0.9,) * 3, metallic=1.0, roughness=0.1)
    settings = {"max_samples": 64}
    whole, objects = picture([panel], material=shiny, settings=settings)
    link = LampLink(mask(0), None)
    linked, _ = picture([panel | {"link": 0}], [link], material=shiny, settings=settings)
    on_floor = objects == 0.0
    np.testing.assert_allclose(linked[on_floor], whole[on_floor], rtol=1e-5)
    assert (linked[~on_floor] == 0.0).all() and (whole[objects == 1.0] > 0.1).any()


def test_catchers_follow_links():
    """The lamp of a link darkens a catcher by its blockers alone; unlinked catchers not at all."""
    flags = np.full(3, CAMERA_RAYS | SHADOW_RAYS, np.uint8)
    flags[0] |= SHADOW_CATCHER
    fields = {"object_flags": flags, "transparent_film": True}
    alphas = {}
    for name, link in (
        ("all", LampLink(None, None)),
        ("box", LampLink(None, mask(1))),
        ("none", LampLink(None, mask())),
        ("unlit", LampLink(mask(1, 2), None)),
    ):
        layers, _ = make_picture(scene_of([SIDE], [link], **fields), **FILTERED)
        seen = layers["combined"][..., 3].copy()
        seen[layers["combined"][..., :3].sum(axis=2) > 0.0] = 0.0  # box and shelf
        alphas[name] = seen.sum()
    assert alphas["all"] > alphas["box"] > alphas["none"]
    assert alphas["none"] == pytest.approx(alphas["unlit"], abs=1e-4)


def test_shining_faces_have_the_links_of_their_objects():
    """Two squares of one material: each is a lamp of its own, about its own objects."""
    parts = [
        floor(1.0),
        quad((-0.8, -0.3, 1.0), (0.5, 0.0, 0.0), (0.0, 0.5, 0.0)),
        quad((0.3, -0.3, 1.0), (0.5, 0.0, 0.0), (0.0, 0.5, 0.0)),
    ]
    materials = [diffuse()] + [black(emission=(3.0, 2.0, 1.0))] * 2
    scene = make_scene(parts, materials, DARK, camera_above(24, 24, z=0.9))
    own = scene.mesh, scene.materials.emission
    plain = with_emitters([], *own)
    lamps = with_emitters([], *own, link=np.int32([-1, -1, 0]))
    assert plain.link.tolist() == [-1] and sorted(lamps.link.tolist()) == [-1, 0]
    assert lamps.faces.power.sum() == pytest.approx(plain.faces.power.sum())
    dark = (LampLink(np.zeros(3, np.bool_), None),)
    one = dataclasses.replace(scene, lamps=lamps, lamp_links=dark)
    two = dataclasses.replace(scene, lamps=plain)
    alone = with_emitters([], *own, link=np.int32([-1, 0, 0]))
    none = dataclasses.replace(scene, lamps=alone, lamp_links=dark)
    sums = [make_picture(s, **FILTERED)[0]["combined"][..., 0].sum() for s in (two, one, none)]
    assert sums[1] == pytest.approx(0.5 * sums[0], rel=0.05)  # seen from below they are alike
    assert sums[2] == 0.0


def test_blockers_move_with_the_shutter():
    """Slices of time have hierarchies of their own: the box that blocks goes away sideways."""
    times = (np.arange(16) + 0.5) / 16
    matrices = np.tile(np.eye(4), (16, 1, 1, 1))
    matrices[:, 0, 0, 3] = 4.0 * times
    motion = ObjectMotion(np.int32([1]), times, matrices)
    links = [LampLink(mask(0), mask(1))]
    still, _ = picture([SIDE], links, settings=FILTERED)
    moving, _ = picture([SIDE], links, settings=FILTERED, motion=motion)
    free, _ = picture([SIDE], [LampLink(mask(0), mask())], settings=FILTERED)
    in_shadow = (slice(10, 12), slice(18, 20))  # .5 m to the right of the box
    under = free[in_shadow].sum()
    assert under > 0.0 and still[in_shadow].sum() == 0.0
    assert 0.5 * under < moving[in_shadow].sum() < 0.99 * under


def test_a_change_of_links_is_seen_by_what_is_kept():
    """One cache for pictures with other blockers: each is that of a fresh cache."""
    cache = RenderCache()
    base = scene_of([SIDE])
    for own in (mask(1), mask(2), mask(), None):
        scene = dataclasses.replace(base, lamp_links=(LampLink(None, own),))
        kept, _ = make_picture(scene, cache, **FILTERED)
        fresh, _ = make_picture(scene, **FILTERED)
        np.testing.assert_array_equal(kept["combined"], fresh["combined"])


def test_links_that_are_equal_build_nothing_anew():
    """An export of the same scene has new arrays with the same numbers."""
    cache = RenderCache()
    base = scene_of([SIDE])
    found = []
    for _ in range(2):
        scene = dataclasses.replace(base, lamp_links=(LampLink(None, mask(1)),))
        found.append(cache.rays(scene))
    assert found[0]._parts is found[1]._parts
    assert found[0].linked(0)._solid is found[1].linked(0)._solid
