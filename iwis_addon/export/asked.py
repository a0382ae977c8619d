"""The passes that a view layer asks for and that take something of the scene beside its light."""

from __future__ import annotations

import numpy as np

from ...core.data.asked_passes import NO_PASSES, AskedPasses, Matte, Mist, UvMaps, matte_ids
from ..passes import MATTES, matte_layer, wanted_mattes
from .objects.light_groups import read_groups
from .placed.mesh import MeshExport
from .placed.surface_data import parts_with, surface_data
from .worlds.world import world_of

# Cycles' own, of a scene without a world.
_OCCLUSION_DISTANCE = 10.0
_MIST = Mist(0.0, 100.0, 1.0)
_POWERS = {"QUADRATIC": 2.0, "LINEAR": 1.0, "INVERSE_QUADRATIC": 0.5}
_OF_WHOLE_SURFACES = ("normal", "uv", "vector", "z", "position", "object_index", "material_index")
_UV = "uv:"  # the active map
_LEVELS_SEEN = 6  # mattes of a pixel that a window shows, mixed
_SOLID_SEEN = 0.5  # Alpha Threshold of Cycles' window, whatever a view layer's
# What Cycles calls what has no material.
_NO_MATERIAL = "default_surface"


def read_asked(depsgraph, geometry: MeshExport) -> AskedPasses:
    """Of the graph's view layer; the names of mattes are those of Blender's data."""
    layer, world = depsgraph.view_layer_eval, world_of(depsgraph)
    occlusion, mist, uv = 0.0, None, None
    if layer.use_pass_ambient_occlusion:
        occlusion = occlusion_distance(depsgraph)
    if layer.use_pass_mist:
        mist = _mist_seen(world)
    if layer.use_pass_uv:
        uv = uv_maps(geometry)
    levels = layer.pass_cryptomatte_depth
    mattes = tuple(_matte(kind, levels, geometry) for kind in wanted_mattes(layer))
    every = [look.asked for look in geometry.inventory.looks]
    groups = read_groups(every, world, geometry.inventory.layer, geometry.inventory.groups)
    own = getattr(layer, "iwis", None)  # none where scripts export without the engine
    catcher = own is not None and own.use_pass_shadow_catcher
    solid = float(layer.pass_alpha_threshold) if _asks_data(layer) else None
    return AskedPasses(occlusion, mist, uv, mattes, groups, catcher=catcher, solid=solid)


def asked_in_view(depsgraph, geometry: MeshExport, shown: str) -> AskedPasses:
    """Of a window that shows a layer in place of Combined, whatever the view layer asks for.

    shown: of AskedPasses
    The view layer's Alpha Threshold does not count, as in Cycles' window, which has its own.
    """
    if not shown:
        return NO_PASSES
    world = world_of(depsgraph)
    kinds = [kind for kind in MATTES if matte_layer(kind) == shown]
    return AskedPasses(
        occlusion_distance=occlusion_distance(depsgraph) if shown == "ambient_occlusion" else 0.0,
        mist=_mist_seen(world) if shown == "mist" else None,
        uv=uv_maps(geometry) if shown == "uv" else None,
        mattes=tuple(_matte(kind, _LEVELS_SEEN, geometry) for kind in kinds),
        catcher=shown == "shadow_catcher",
        solid=_SOLID_SEEN if shown in _OF_WHOLE_SURFACES else None,
        shown=shown,
    )


def _asks_data(layer) -> bool:
    """Whether a view layer has a pass that shows what is as opaque as its Alpha Threshold says."""
    return any(getattr(layer, f"use_pass_{name}") for name in _OF_WHOLE_SURFACES)


def occlusion_distance(depsgraph) -> float:
    """Metres that rays of ambient occlusion go: of the world."""
    world = world_of(depsgraph)
    return _OCCLUSION_DISTANCE if world is None else float(world.light_settings.distance)


def uv_maps(geometry: MeshExport) -> UvMaps:
    """The active map of every mesh."""
    requests = (frozenset({_UV}),) * len(geometry.materials)
    found = surface_data(geometry.inventory, geometry.mesh, geometry.kept, requests)
    corners = found.tables.get(_UV)
    if corners is None:
        none = np.full_like(found.row, -1)
        return UvMaps(none, np.zeros((0, 3, 2), np.float32), found.mirrored)
    of_parts = parts_with(geometry.inventory, _UV)
    mapped = np.array([of_parts[one.part] for one in geometry.inventory.instances], np.bool_)
    row = np.where(mapped[geometry.mesh.object_index], found.row, np.int32(-1))
    return UvMaps(row, corners, found.mirrored)


def _mist_seen(world) -> Mist:
    if world is None:
        return _MIST
    settings = world.mist_settings
    return Mist(float(settings.start), float(settings.depth), _POWERS[settings.falloff])


def _matte(kind: str, levels: int, geometry: MeshExport) -> Matte:
    """One of passes.MATTES."""
    inventory = geometry.inventory
    if kind == "Material":
        rows = [_NO_MATERIAL if one is None else one.name for one in geometry.materials]
    elif kind == "Asset":
        rows = [_topmost(look.asked.own).name for look in inventory.looks]
    else:
        rows = [instance.name for instance in inventory.instances]
    names = {name: number for number, name in enumerate(dict.fromkeys(rows))}
    number = np.array([names[name] for name in rows], np.int32)
    own = matte_layer(kind), levels, kind == "Material"
    return Matte(*own, number, tuple(names), matte_ids(names))


def _topmost(obj):
    """The object that is parent to all: it and what hangs from it are one asset, as in Cycles."""
    while obj.parent is not None:
        obj = obj.parent
    return obj
