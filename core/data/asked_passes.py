"""Passes that take something of a scene beside its light, and are made where they are asked for."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Mist(NamedTuple):
    """start, depth: metres from the camera to where it begins, and on to where it is complete;
    power: its rise."""

    start: float
    depth: float
    power: float


class UvMaps(NamedTuple):
    """The active UV map of every mesh.

    row: int32 (m,), for each triangle of the scene its row in corners, -1 = it has none
    corners: float32 (rows, 3, 2), places on the map; mirrored: bool (n_objects,), whose winding was
        turned round, so that the second corner is the triangle's third
    """

    row: np.ndarray
    corners: np.ndarray
    mirrored: np.ndarray


class Matte(NamedTuple):
    """One kind of Cryptomatte.

    layer: its name in the film; levels: how many mattes of a pixel are shown
    by_material: whether rows are those of materials, else of objects
    number: int32 (rows,), which matte each row of the scene belongs to
    names: of the mattes; ids: float32 (m,), matte_ids of them
    """

    layer: str
    levels: int
    by_material: bool
    number: np.ndarray
    names: tuple[str, ...]
    ids: np.ndarray


class LightGroups(NamedTuple):
    """Lights whose share of the picture is wanted, group by group; of lamps see Lamps.group.

    layers: their names in the film; world: the group of the environment, -1 = none
    shows_world: whether what the camera sees of it is in the group, too
    objects: int32 (n_objects,), the group of what shines on each object, -1 = none
    """

    layers: tuple[str, ...] = ()
    world: int = -1
    shows_world: bool = True
    objects: np.ndarray | None = None


class AskedPasses(NamedTuple):
    """occlusion_distance: metres that rays of the ambient-occlusion pass go, 0 = it is not wanted;
    mist, uv: None = they are not wanted either; mattes: the kinds of Cryptomatte
    that are wanted; groups: of lights, none = they are not wanted; roughness, catcher: whether they
    are, Combined then has no shadow catchers; solid: the opacity from which on a surface is in data
    passes whole (Blender's Alpha Threshold), None = it is as the picture shows it; shown: the layer
    that a window shows in place of Combined, "" = none."""

    occlusion_distance: float = 0.0
    mist: Mist | None = None
    uv: UvMaps | None = None
    mattes: tuple[Matte, ...] = ()
    groups: LightGroups = LightGroups()
    roughness: bool = False
    catcher: bool = False
    solid: float | None = None
    shown: str = ""


NO_PASSES = AskedPasses()


def channels_of(levels: int) -> int:
    """Of a layer that shows so many mattes of a pixel: four for every two."""
    return 4 * (-(-levels // 2))


def name_hash(name: str) -> int:
    """MurmurHash3_32 of a name's UTF-8 bytes, with seed 0 [Appleby11]."""
    data, mask = name.encode(), 0xFFFFFFFF
    h = 0
    whole = len(data) // 4 * 4
    for i in range(0, len(data), 4):
        k = int.from_bytes(data[i : i + 4], "little")
        k = (k * 0xCC9E2D51) & mask
        k = (k << 15 | k >> 17) & mask
        h ^= (k * 0x1B873593) & mask
        if i < whole:
            h = (h << 13 | h >> 19) & mask
            h = (h * 5 + 0xE6546B64) & mask
    h ^= len(data)
    h = ((h ^ h >> 16) * 0x85EBCA6B) & mask
    h = ((h ^ h >> 13) * 0xC2B2AE35) & mask
    return h ^ h >> 16


def matte_ids(names) -> np.ndarray:
    """float32 (n,): the names' hashes as numbers, their exponents kept from 0 and infinity."""
    bits = np.array([name_hash(name) for name in names], np.uint32)
    exponent = np.clip(bits >> 23 & 0xFF, 1, 254).astype(np.uint32)
    return (bits & np.uint32(0x807FFFFF) | exponent << np.uint32(23)).view(np.float32)
