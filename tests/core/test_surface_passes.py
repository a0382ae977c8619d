"""Mist, UV and mattes: averages over a pixel's rays, whatever tiles and filters a picture has."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.asked_passes import (
    AskedPasses,
    Matte,
    Mist,
    UvMaps,
    channels_of,
    matte_ids,
    name_hash,
)
from iwis.core.scene import CAMERA_RAYS, HOLDOUT, SHADOW_RAYS
from support.scenes import (
    camera_above,
    constant_world,
    diffuse,
    floor,
    make_picture,
    make_scene,
    varied_scene,
)

NAMES = ("floor", "box", "ball", "card", "shelf")
FILTERED = {"pixel_filter": "BLACKMAN_HARRIS", "stop_rule": "FIXED", "max_samples": 128}


def with_passes(scene, levels=6, **asked):
    rows = np.arange(len(scene.object_pass_index), dtype=np.int32)
    names = NAMES[: len(rows)]
    matte = Matte("crypto_object", levels, False, rows, names, matte_ids(names))
    return dataclasses.replace(scene, asked=AskedPasses(mattes=(matte,), **asked))


def coverage(layer, name):
    """What a matte covers of each pixel of a Cryptomatte layer."""
    pairs = layer.reshape(*layer.shape[:2], -1, 2)
    return np.where(pairs[..., 0] == matte_ids([name])[0], pairs[..., 1], 0.0).sum(axis=-1)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", 0),
        ("hello", 0x248BFA47),
        ("hello, world", 0x149BBB7F),
        ("The quick brown fox jumps over the lazy dog", 0x2E4FF723),
    ],
)
def test_hash_is_murmurs(text, expected):
    """Test vectors of MurmurHash3_32, seed 0: tails of 0, 1, 3 and 4 bytes."""
    assert name_hash(text) == expected


def test_ids_are_numbers():
    """Exponents of 0 and 255 would be denormals, infinity or NaN, which programs do not keep."""
    ids = matte_ids([f"name {k}" for k in range(3000)])
    assert np.isfinite(ids).all()
    assert (np.abs(ids) >= np.finfo(np.float32).tiny).all()
    assert len(set(ids.tolist())) == 3000


def test_mattes_cover_what_is_opaque():
    """All mattes of a pixel make up its alpha; the first covers most; a level more is two."""
    scene = dataclasses.replace(with_passes(varied_scene(), levels=5), transparent_film=True)
    layers, _ = make_picture(scene, **FILTERED)
    layer = layers["crypto_object"]
    assert layer.shape[2] == channels_of(5) == 12
    whole = sum(coverage(layer, name) for name in NAMES)
    np.testing.assert_allclose(whole, layers["combined"][..., 3], atol=1e-5)
    ranks = layer[..., 1::2]
    assert (np.diff(ranks, axis=-1) <= 0.0).all()
    assert (layer[..., 10:] == 0.0).all()  # the sixth is not asked for
    edges = (ranks[..., 1] > 0.0).mean()
    assert 0.05 < edges < 0.6
    assert ((coverage(layer, "ball") > 0.0) & (coverage(layer, "floor") > 0.0)).any()


def test_too_many_mattes_keep_the_first():
    """A level of one: the matte that covers most, as it is among all of them."""
    scene = varied_scene()
    all_of, one = (
        make_picture(with_passes(scene, levels=levels), **FILTERED)[0]["crypto_object"]
        for levels in (6, 1)
    )
    assert one.shape[2] == 4
    np.testing.assert_array_equal(one[..., :2], all_of[..., :2])
    assert (one[..., 2:] == 0.0).all()


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BLACKMAN_HARRIS"])
def test_no_pass_depends_on_tiles(pixel_filter):
    """Tiles of 16 and 64 pixels, one and two threads."""
    mist = Mist(1.0, 4.0, 2.0)
    scene = with_passes(varied_scene(width=70, height=44), mist=mist)
    own = FILTERED | {"pixel_filter": pixel_filter, "max_samples": 32}
    first, _ = make_picture(scene, **own, tile_px=64)
    second, _ = make_picture(scene, **own, tile_px=16, threads=2)
    for name in ("crypto_object", "mist"):
        np.testing.assert_array_equal(first[name], second[name])


def test_a_center_has_one_matte():
    """Pixel filter CENTER: a pixel is its object's, or nobody's."""
    layers, _ = make_picture(with_passes(varied_scene()), max_samples=8)
    hit = layers["depth"][..., 0] < 1e9
    layer = layers["crypto_object"]
    assert (layer[..., 1] == hit).all()
    assert (layer[..., 2:] == 0.0).all()
    objects = layers["object_index"][..., 0][hit].astype(int) - 20
    np.testing.assert_array_equal(layer[..., 0][hit], matte_ids(NAMES)[objects])


def test_a_holdout_shows_nothing():
    """No matte, no mist, no place: as where the world is."""
    scene = varied_scene()
    flags = np.full(5, CAMERA_RAYS | SHADOW_RAYS, np.uint8)
    flags[2] |= HOLDOUT
    hole = make_picture(scene, max_samples=8)[0]["object_index"][..., 0] == 22.0
    scene = dataclasses.replace(with_passes(scene, mist=Mist(0.0, 100.0, 1.0)), object_flags=flags)
    layers, _ = make_picture(scene, max_samples=8)
    assert hole.sum() > 20 and not layers["object_index"][hole].any()
    assert (layers["crypto_object"][hole] == 0.0).all()
    assert (layers["mist"][hole] == 1.0).all()
    assert (coverage(layers["crypto_object"], "ball") == 0.0).all()


@pytest.mark.parametrize(
    ("mist", "expected"),
    [
        (Mist(8.0, 4.0, 1.0), 0.5),
        (Mist(8.0, 4.0, 2.0), 0.25),
        (Mist(8.0, 4.0, 0.5), np.sqrt(0.5)),
        (Mist(11.0, 4.0, 1.0), 0.0),
        (Mist(2.0, 4.0, 1.0), 1.0),
        (Mist(2.0, 0.0, 1.0), 0.0),
    ],
)
def test_mist_rises_with_the_distance(mist, expected):
    """A floor 10 m under an orthographic camera; where the world is seen, 1; of no depth none."""
    scene = make_scene([floor(0.5)], [diffuse()], constant_world(), camera_above(z=10.0))
    scene = dataclasses.replace(scene, asked=AskedPasses(mist=mist))
    layers, _ = make_picture(scene, max_samples=1)
    hit = layers["depth"][..., 0] < 1e9
    assert hit.any() and not hit.all()
    np.testing.assert_allclose(layers["mist"][hit], expected, atol=1e-5)
    assert (layers["mist"][~hit] == 1.0).all()


def test_a_perspective_mist_is_round():
    """Metres to the camera, not along its axis: more at the picture's rim."""
    scene = dataclasses.replace(varied_scene(), asked=AskedPasses(mist=Mist(0.0, 100.0, 1.0)))
    layers, _ = make_picture(scene, max_samples=1)
    hit = layers["depth"][..., 0] < 1e9
    away = np.linalg.norm(layers["position"] - scene.camera.camera_to_world[:3, 3], axis=-1)
    np.testing.assert_allclose(layers["mist"][hit][:, 0], away[hit] / 100.0, rtol=1e-4)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("pixel_filter", ["CENTER", "BLACKMAN_HARRIS"])
def test_uv_is_the_place_on_the_map(pixel_filter, mirrored):
    """A floor whose map is its own x and y, 0 to 1; the third number is what is hit of a pixel."""
    scene = make_scene([floor(0.5)], [diffuse()], constant_world(), camera_above(48, 48))
    mesh = scene.mesh
    corners = (mesh.vertices[mesh.triangles][..., :2] + 0.5).astype(np.float32)
    if mirrored:
        corners = np.ascontiguousarray(corners[:, [0, 2, 1]])
    row = np.arange(len(corners), dtype=np.int32)
    maps = UvMaps(row, corners, np.array([mirrored]))
    scene = dataclasses.replace(scene, asked=AskedPasses(uv=maps), transparent_film=True)
    own = FILTERED | {"pixel_filter": pixel_filter}
    layers, _ = make_picture(scene, **own)
    share, uv = layers["combined"][..., 3], layers["uv"]
    np.testing.assert_allclose(uv[..., 2], share, atol=1e-6)
    inside = share == 1.0
    place = layers["position"][inside][:, :2] + 0.5
    # Of 16 rays the mean place is off the centre by less than a tenth of a pixel.
    off = 1e-5 if pixel_filter == "CENTER" else 0.1 * 1.8 / 48
    np.testing.assert_allclose(uv[inside][:, :2], place, atol=off)


def test_what_has_no_map_is_at_0():
    """Rows of -1, and a scene without any map: all three numbers, as in Cycles."""
    scene = make_scene([floor(0.5)], [diffuse()], constant_world(), camera_above())
    none = np.full(len(scene.mesh.triangles), -1, np.int32)
    maps = UvMaps(none, np.zeros((0, 3, 2), np.float32), np.array([False]))
    scene = dataclasses.replace(scene, asked=AskedPasses(uv=maps))
    layers, _ = make_picture(scene, max_samples=1)
    assert (layers["depth"] < 1e9).any() and not layers["uv"].any()


def test_light_is_the_same_with_them():
    """Passes on request change nothing else."""
    plain = varied_scene()
    scene = with_passes(plain, mist=Mist(0.0, 9.0, 1.0))
    own = FILTERED | {"max_samples": 16}
    first, second = (make_picture(one, **own)[0]["combined"] for one in (plain, scene))
    np.testing.assert_array_equal(first, second)
