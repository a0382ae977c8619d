"""Light groups: what each light brings to a picture, in layers of their own."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.asked_passes import AskedPasses, LightGroups
from iwis.core.data.lamps import (
    BY_CAMERA,
    BY_DIFFUSE,
    BY_GLOSSY,
    MESH,
    SPHERE,
    SUN,
    Lamps,
    make_lamps,
)
from iwis.core.lamplight.emitters import with_emitters
from iwis.core.scene import CAMERA_RAYS, HOLDOUT, SHADOW_CATCHER, SHADOW_RAYS
from support.scenes import (
    black,
    box,
    camera_above,
    diffuse,
    floor,
    glossy,
    gradient_world,
    make_picture,
    make_scene,
    quad,
)

FILTERS = pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
LAYERS = WORLD, SUNS, BALLS, SHINING = "world", "suns", "balls", "shining"
SEEN = BY_DIFFUSE | BY_GLOSSY | BY_CAMERA
SHEET, NO_ONE = 2, -1
ROWS = [
    {"kind": SUN, "forward": (0.6, 0.0, -0.8), "radiance": (0.4, 0.5, 0.1), "group": 1},
    {"kind": SPHERE, "position": (-0.4, 0.2, 0.9), "size": (0.2, 0.0), "radiance": (3.0, 2.0, 1.0)}
    | {"group": 2, "seen_by": SEEN},
    {"kind": SPHERE, "position": (0.5, -0.3, 0.4), "radiance": (0.1, 0.1, 0.3), "shadow": False}
    | {"group": 2},
    {"kind": SUN, "forward": (0.0, 0.6, -0.8), "radiance": (0.1, 0.1, 0.1)},
]


def lit_scene(rows=ROWS, asked=True, world=0, shown=True, **fields):
    """A box and a glossy plate on a floor, a sheet over them that shines, lamps and a sky."""
    parts = [
        floor(0.6),
        box((0.1, -0.3, 0.0), (0.4, 0.3, 0.3)),
        quad((-0.2, -0.5, 0.5), (0.3, 0.0, 0.0), (0.0, 0.2, 0.1)),
        quad((-0.5, -0.2, 0.05), (0.4, 0.0, 0.1), (0.0, 0.5, 0.0)),
    ]
    shines = black(emission=(0.5, 1.5, 2.5))
    materials = [diffuse(), diffuse((0.8, 0.2, 0.1)), shines, glossy(0.2)]
    scene = make_scene(parts, materials, gradient_world(), camera_above(24, 24), **fields)
    of = np.full(4, NO_ONE, np.int32)
    of[SHEET] = 3
    group = of if asked else None
    lamps = with_emitters(rows, scene.mesh, scene.materials.emission, group=group)
    groups = LightGroups(LAYERS, world, shown, of) if asked else LightGroups()
    return dataclasses.replace(scene, lamps=lamps, asked=AskedPasses(groups=groups))


def picture(scene, pixel_filter="CENTER"):
    """Its layers; of a lamp no pixel takes more samples than another."""
    settings = {"stop_rule": "FIXED", "max_samples": 16, "pixel_filter": pixel_filter}
    return make_picture(scene, **settings)[0]


def without(scene, which):
    """The scene with all but some of its lamps, which are dark, so that numbers stay theirs."""
    radiance = scene.lamps.radiance.copy()
    radiance[which] = 0.0
    faces = scene.lamps.faces
    if MESH in scene.lamps.kind[which]:
        faces = faces._replace(radiance=np.zeros_like(faces.radiance))
    return dataclasses.replace(scene, lamps=scene.lamps._replace(radiance=radiance, faces=faces))


@FILTERS
def test_groups_and_the_rest_are_the_picture(pixel_filter):
    """In the rest is one sun alone: what a picture without it has not."""
    scene = lit_scene(exposure=1.5)
    layers = picture(scene, pixel_filter)
    groups = sum(layers[name] for name in LAYERS)
    rest = layers["combined"][..., :3] - groups
    dark = picture(without(scene, scene.lamps.group == NO_ONE), pixel_filter)
    np.testing.assert_allclose(dark["combined"][..., :3], groups, rtol=1e-5, atol=1e-5)
    assert rest.mean() > 0.005 and rest.min() > -1e-5


@FILTERS
@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_group_is_what_the_picture_lacks_without_it(pixel_filter, number):
    """Light that falls on things, and that the camera sees: a ball, the sheet."""
    scene = lit_scene()
    whole = picture(scene, pixel_filter)
    dark = without(scene, scene.lamps.group == number)
    if number == 3:
        emission = np.zeros_like(scene.materials.emission)
        materials = dark.materials._replace(emission=emission)
        dark = dataclasses.replace(dark, materials=materials)
    lacks = whole["combined"] - picture(dark, pixel_filter)["combined"]
    np.testing.assert_allclose(whole[LAYERS[number]], lacks[..., :3], rtol=1e-4, atol=2e-5)
    assert whole[LAYERS[number]].max() > 0.1


@FILTERS
def test_the_worlds_group_is_the_picture_without_lamps(pixel_filter):
    """The sky behind the floor too, in a film that shows it."""
    scene = lit_scene()
    bare = dataclasses.replace(lit_scene([], False), lamps=make_lamps([]))
    emission = np.zeros_like(scene.materials.emission)
    bare = dataclasses.replace(bare, materials=bare.materials._replace(emission=emission))
    world = picture(scene, pixel_filter)[WORLD]
    bare = picture(bare, pixel_filter)["combined"][..., :3]
    np.testing.assert_allclose(world, bare, rtol=1e-5, atol=1e-6)
    assert world[0, 0].max() > 0.1 and scene.lamps.kind.max() == MESH
    light = picture(lit_scene(shown=False), pixel_filter)[WORLD]
    assert not light[0, 0].any()
    np.testing.assert_array_equal(light[12, 12], world[12, 12])


@FILTERS
def test_asking_changes_no_pixel(pixel_filter):
    """Of lamps whose numbers do not depend on groups, to the last bit; no layer is left over."""
    asked, plain = (picture(lit_scene(asked=a), pixel_filter) for a in (True, False))
    np.testing.assert_array_equal(asked["combined"], plain["combined"])
    assert set(asked) - set(plain) == set(LAYERS)


def test_no_group_is_black():
    """A world of none, and lamps that are of no group."""
    rows = [row | {"group": NO_ONE} for row in ROWS]
    layers = picture(lit_scene(rows, world=NO_ONE))
    for name in (WORLD, SUNS, BALLS):
        assert not layers[name].any()
    assert layers[SHINING].any()


@FILTERS
@pytest.mark.parametrize("role", [HOLDOUT, SHADOW_CATCHER])
def test_holdouts_and_catchers_show_no_group(pixel_filter, role):
    """As in Cycles: what a catcher shows is in Combined alone."""
    flags = np.array([role, 0, 0, 0], np.int32) | CAMERA_RAYS | SHADOW_RAYS
    layers = picture(lit_scene(object_flags=flags), pixel_filter)
    for name in (WORLD, SUNS, SHINING):
        assert not layers[name][5, 5].any()  # a pixel of the floor alone
        assert layers[name].any()


def test_faces_of_groups_are_lamps_of_their_own():
    """Two sheets of two groups and one of none: three lamps, each with its faces."""
    parts = [quad((k, 0.0, 0.0), (0.5, 0.0, 0.0), (0.0, 0.5, 0.0)) for k in range(3)]
    emission = np.float32([[1.0, 1.0, 1.0], [2.0, 2.0, 2.0], [3.0, 3.0, 3.0]])
    scene = make_scene(parts, [diffuse()] * 3, gradient_world(), camera_above())
    group = np.int32([1, NO_ONE, 0])
    lamps: Lamps = with_emitters([], scene.mesh, emission, group=group)
    assert sorted(lamps.group.tolist()) == [NO_ONE, 0, 1]
    for row, own in enumerate(lamps.group):
        first, end, _ = lamps.span[row]
        brightest = lamps.faces.radiance[2 * first : 2 * end].max()
        assert brightest == emission[list(group).index(own), 0]
