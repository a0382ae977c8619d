"""What stands where: the objects of a dependency graph and all their instances.

As in Cycles, an instance is what ``depsgraph.object_instances`` lists with ``show_self``; the graph
of a final render leaves out what is hidden from renders, and lists each copy made by collections,
particles and geometry nodes. Of a text, curve, surface or metaball it lists the object and, as an
instance of type MESH, the mesh that it evaluates to: only the latter is taken.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ....core.nodes.hashing import hash_words
from ....core.scene import CAMERA_RAYS, ROUND, SHADOW_RAYS
from ..errors import ExportCancelled
from ..lamps.lamps import read_lamp
from ..left_out import UNSUPPORTED_TYPES, LeftOut
from ..meshes.adaptive import Dicing
from ..meshes.local_mesh import LiveMeshes, LocalMesh
from ..meshes.particle_hair import hair_modifiers
from ..meshes.parts import WITH_SURFACE, PartReader
from ..objects.lamp_links import LampLinks
from ..objects.light_groups import group_numbers, group_of
from ..objects.object_flags import flags_of
from ..objects.object_properties import Asked
from ..objects.origins import Origin, Origins
from ..shaders.program_images import ImageStore

_WORD = 0xFFFFFFFF
_NO_SHADING_OFFSET = (
    "Shadow Terminator, Shading Offset is not supported and left out (Geometry Offset is)"
)


class Instance(NamedTuple):
    """One mesh at one place.

    part: row of Inventory.parts; object_to_world: float64 (4, 4)
    slots: rows of Inventory.materials, one a material slot, at least one
    terminator_offset: the object's shadow terminator geometry offset, a cosine
    flags: of Scene.object_flags
    number: Blender's for an instance, -1 for an object that is none
    hair: the name of the modifier that it is the hair of
    """

    name: str
    part: int
    object_to_world: np.ndarray
    slots: tuple[int, ...]
    pass_index: int
    terminator_offset: float
    flags: int
    number: int
    hair: str = ""


class Look(NamedTuple):
    """What an instance's materials may ask of its object.

    color: rgba, of what made it; random: 0 ... 1, other for each instance; asked: whose properties
    origin: what a material asks of how it was made
    """

    color: tuple
    random: float
    asked: Asked
    origin: Origin


class Inventory(NamedTuple):
    """All instances, the meshes that they share and the materials that they name.

    materials: evaluated bpy materials, None where a slot is empty or an object has no slot
    sources: of PartReader, one a part, while the graph lives
    looks: one an instance
    lamps: rows for core.lamps.make_lamps; links: what these, and objects that shine, are about
    groups: group_numbers of the layer; none in a window
    layer: the evaluated view layer, scene and world
    """

    parts: list[LocalMesh]
    instances: list[Instance]
    materials: list
    sources: list
    looks: list[Look]
    lamps: list[dict]
    links: LampLinks
    groups: dict[str, int]
    layer: tuple


def random_of_names(names: list[str]) -> np.ndarray:
    """What Cycles takes for the random numbers of objects that are no instances: uint32 (n,)."""
    words = np.zeros(len(names), np.uint32)
    for row, name in enumerate(names):
        word = 0
        for byte in name.encode():
            word = (word * 37 + byte) & 0xFFFFFFFF
        words[row] = word
    return hash_words(words, np.zeros_like(words))


class _Item(NamedTuple):
    """What all instances of one object with one mesh have in common; part: None = no face."""

    part: int | None
    name: str
    slots: tuple[int, ...]
    pass_index: int
    terminator_offset: float
    flags: int
    color: tuple
    asked: Asked


class _Collector:
    """Turns depsgraph items into an Inventory while they are alive."""

    def __init__(self, depsgraph, known, cancelled, live, texels, dicing):
        self._depsgraph, self._cancelled = depsgraph, cancelled
        self._reader = PartReader(depsgraph, known, cancelled, live, dicing)
        self._override = depsgraph.view_layer_eval.material_override
        self._material_rows: dict[int, int] = {}
        self._parts: dict[tuple, tuple[int | None, list[int]]] = {}
        self._items: dict[tuple, _Item] = {}
        self._named: list[int] = []  # rows whose random number comes from their name
        scene, self._origins = depsgraph.scene_eval, Origins(depsgraph.scene_eval)
        layer = depsgraph.view_layer_eval, scene, scene.world
        groups = group_numbers(layer[0]) if live is None else {}
        self.inventory = Inventory([], [], [], [], [], [], LampLinks(depsgraph), groups, layer)
        self.ignored, self.warnings = LeftOut(), self._reader.warnings
        self._images = ImageStore(texels)  # that lights show

    def _material_row(self, material) -> int:
        key = 0 if material is None else material.original.as_pointer()
        if key not in self._material_rows:
            self._material_rows[key] = len(self.inventory.materials)
            if material is not None:
                material = material.evaluated_get(self._depsgraph)
            self.inventory.materials.append(material)
        return self._material_rows[key]

    def _slots(self, obj, data_rows) -> tuple[int, ...]:
        """Rows of the materials of an object's slots, as Cycles counts them."""
        if self._override is not None:
            return (self._material_row(self._override),)
        if not data_rows:
            return (self._material_row(None),)
        slots = obj.material_slots
        rows = data_rows + data_rows[-1:] * (len(slots) - len(data_rows))
        for i, slot in enumerate(slots):
            if slot.link == "OBJECT":
                rows[i] = self._material_row(slot.material)
        return tuple(rows)

    def _part(self, obj, owner, modifier, lasting):
        """Row of the object's part (None if it has no face) and the materials of its data."""
        data = obj.data
        # In edit mode objects share a mesh in spite of their modifiers: they are part of the key.
        own = modifier is not None or getattr(data, "is_editmode", False)
        hair = "" if modifier is None else modifier.name
        key = obj.original.as_pointer() if own else 0, data.as_pointer(), hair
        if key not in self._parts:
            if self._cancelled():
                raise ExportCancelled
            local, source, materials = self._reader.read(obj, owner, modifier, lasting)
            row, rows = None, []
            if local is not None:
                row = len(self.inventory.parts)
                self.inventory.parts.append(local)
                self.inventory.sources.append(source)
                if self._override is None:
                    rows = list(map(self._material_row, materials))
            self._parts[key] = row, rows
        return self._parts[key]

    def _item(self, obj, owner, modifier, asked: Asked, flags: int) -> _Item:
        """Of hundreds of thousands of instances each property of Blender's is asked once."""
        part, data_rows = self._part(obj, owner, modifier, asked.own)
        slots = () if part is None else self._slots(obj, data_rows)
        if modifier is not None and slots:
            chosen = modifier.particle_system.settings.material - 1
            slots = (slots[min(max(chosen, 0), len(slots) - 1)],)
        is_round = part is not None and self.inventory.parts[part].round
        if part is not None and obj.shadow_terminator_shading_offset > 0.0:
            self.ignored.add(_NO_SHADING_OFFSET, obj.name)
        return _Item(
            part,
            obj.name,
            slots,
            obj.pass_index,
            ROUND if is_round else obj.shadow_terminator_geometry_offset,
            flags,
            tuple((asked.instancer or obj).color),
            asked,
        )

    def _add(self, item, obj, modifier=None):
        """The part that an object shows, or the hair that a modifier grows on it."""
        owner = item.parent if item.is_instance and item.parent else obj
        hair = "" if modifier is None else modifier.name
        things = obj.original, owner.original, obj.data
        key = *(thing.as_pointer() for thing in things), hair
        own = self._items.get(key)
        if own is None:
            flags = flags_of(obj, owner, self.inventory.layer[0])
            if not flags & (CAMERA_RAYS | SHADOW_RAYS):
                return  # neither a camera ray nor a shadow ray, the only two kinds that there are
            # Of an instance Blender's iterator has a copy, which does not outlive it.
            lasting = item.instance_object if item.is_instance else obj
            asked = Asked(lasting, None if owner.original == obj.original else owner)
            own = self._items[key] = self._item(obj, owner, modifier, asked, flags)
        if own.part is None:
            return
        matrix = np.array(item.matrix_world, np.float64)
        if not math.isfinite(matrix.sum()):
            self.ignored.add("Not rendered, the object's transform is not finite", own.name)
            return
        if not item.is_instance:
            self._named.append(len(self.inventory.looks))
        number = item.random_id & _WORD if item.is_instance else -1
        origin = self._origins.of(item)
        self.inventory.looks.append(Look(own.color, max(number, 0) / _WORD, own.asked, origin))
        self.inventory.instances.append(
            Instance(
                own.name,
                own.part,
                matrix,
                own.slots,
                own.pass_index,
                own.terminator_offset,
                own.flags,
                number,
                hair,
            )
        )

    def finish(self) -> Inventory:
        """All that was taken, with the random numbers that come from names."""
        instances, looks = self.inventory.instances, self.inventory.looks
        numbers = random_of_names([instances[row].name for row in self._named])
        for row, number in zip(self._named, numbers.tolist(), strict=True):
            looks[row] = looks[row]._replace(random=number / _WORD)
        return self.inventory

    def add(self, item):
        """Take one of depsgraph.object_instances."""
        obj = item.object
        if item.show_particles and len(obj.particle_systems):
            emitter = item.instance_object if item.is_instance else obj
            for modifier in hair_modifiers(emitter, self._reader.in_window):
                self._add(item, emitter, modifier)
        if not item.show_self:
            return
        kind = obj.type
        if kind in WITH_SURFACE:
            self._add(item, obj)
        elif kind == "LIGHT":
            asked = Asked(obj, item.parent if item.is_instance else None)
            own = self.warnings, self._images, self.inventory.layer
            lamp = read_lamp(asked, item.matrix_world, *own)
            if lamp is not None:
                lamp["link"] = self.inventory.links.row_of(obj)
                lamp["group"] = group_of(asked, self.inventory.groups)
                self.inventory.lamps.append(lamp)
        elif kind in UNSUPPORTED_TYPES:
            reason = f"Not rendered, {UNSUPPORTED_TYPES[kind]} are not supported"
            self.ignored.add(reason, obj.name)


def collect_instances(
    depsgraph,
    warnings: list[str],
    known: dict[bytes, LocalMesh] | None = None,
    cancelled=lambda: False,
    live: LiveMeshes | None = None,
    shown=None,
    texels=None,
    dicing: Dicing | None = None,
) -> Inventory:
    """All that a render of the graph shows, copied out of Blender.

    warnings: gets one line for each reason to leave objects out, with their names
    known: as for read_mesh; live: meshes that need not be read, in a window
    shown(item): whether a window shows one of depsgraph.object_instances; None: all
    texels: the TexelCache of the job; dicing: of PartReader
    Raises ExportCancelled as soon as cancelled() says so.
    """
    collector = _Collector(depsgraph, known, cancelled, live, texels, dicing)
    for number, item in enumerate(depsgraph.object_instances):
        if number % 256 == 0 and cancelled():
            raise ExportCancelled
        if shown is None or shown(item):
            collector.add(item)
    warnings.extend(collector.ignored.messages())
    warnings.extend(collector.warnings)
    return collector.finish()
