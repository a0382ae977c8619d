"""Light linking: which objects a lamp, or an object that shines, lights, and which block its light.

A light's or object's own collections name them, each object or child collection included or
excluded: where anything is included, that is all there is but for what is excluded; else all others
are. An object that makes instances, and that links know of, stands for all of them.
"""

from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np

from ....core.data.lamps import LampLink, Lamps
from .object_properties import Asked


class _Members(NamedTuple):
    """Addresses of the original objects that a collection includes and excludes."""

    included: frozenset[int]
    excluded: frozenset[int]

    def has(self, address: int) -> bool:
        """Whether a link with this collection is about an object."""
        if address in self.excluded:
            return False
        return not self.included or address in self.included


class LampLinks:
    """The links that a scene's lamps and objects have, each pair of collections once."""

    def __init__(self, depsgraph):
        self._rows: dict[tuple[int, int], int] = {}
        self._collections: list[tuple] = []
        self._members: dict[int, _Members] = {}
        self._linked: set[int] = set()  # addresses of objects that a link is of, or names
        # Of objects that are only shown as instances, ``depsgraph.objects`` knows nothing.
        for obj in (data for data in depsgraph.ids if isinstance(data, bpy.types.Object)):
            pair = _collections_of(obj.original)
            if pair == (None, None):
                continue
            self._linked.add(obj.original.as_pointer())
            for collection in filter(None, pair):
                members = _members(collection)
                self._members[collection.as_pointer()] = members
                self._linked |= members.included | members.excluded

    @property
    def there(self) -> bool:
        """Whether any object has a link."""
        return bool(self._linked)

    def _who(self, asked: Asked):
        """The original object that stands for one in links: its instancer, if links know that."""
        made_by = asked.instancer
        if made_by is not None and made_by.original.as_pointer() in self._linked:
            return made_by.original
        return asked.own.original

    def row_of(self, obj) -> int:
        """Lamps.link of what an evaluated object shines; its instancer has no say, as in Cycles."""
        if not self._linked:
            return -1
        pair = _collections_of(obj.original)
        key = tuple(0 if one is None else one.as_pointer() for one in pair)
        if key == (0, 0):
            return -1
        if key not in self._rows:
            self._rows[key] = len(self._collections)
            self._collections.append(pair)
        return self._rows[key]

    def rows_of(self, every: list[Asked]) -> np.ndarray | None:
        """The same of all objects of a scene, int32 (n,); None: none has a link."""
        if not self._linked:
            return None
        known: dict[int, int] = {}  # instances of an object share what is asked
        rows = [
            known[id(asked)]
            if id(asked) in known
            else known.setdefault(id(asked), self.row_of(asked.own))
            for asked in every
        ]
        rows = np.array(rows, np.int32)
        return rows if (rows >= 0).any() else None

    def of_lamps(self, lamps: Lamps, every: list[Asked]) -> tuple[Lamps, tuple[LampLink, ...]]:
        """The lamps, and Scene.lamp_links of no more than theirs. every: of all objects, by row"""
        used, link = np.unique(np.append(lamps.link, -1), return_inverse=True)
        links = [
            LampLink(*(self._mask(collection, every) for collection in self._collections[row]))
            for row in used[1:]
        ]
        return lamps._replace(link=link[:-1].astype(np.int32) - np.int32(1)), tuple(links)

    def _mask(self, collection, every: list[Asked]) -> np.ndarray | None:
        """bool (n_objects,); None: all."""
        if collection is None:
            return None
        members, known = self._members[collection.as_pointer()], {}
        mask = np.zeros(len(every), np.bool_)
        for row, asked in enumerate(every):
            if id(asked) not in known:
                known[id(asked)] = members.has(self._who(asked).as_pointer())
            mask[row] = known[id(asked)]
        return None if mask.all() else mask


def _collections_of(obj) -> tuple:
    """(receivers, blockers) of an original object, None each where there is none."""
    linking = getattr(obj, "light_linking", None)
    if linking is None:
        return None, None
    return linking.receiver_collection, linking.blocker_collection


def _members(collection) -> _Members:
    found: dict[str, set[int]] = {"INCLUDE": set(), "EXCLUDE": set()}
    for item, obj in zip(collection.collection_objects, collection.objects, strict=True):
        found[item.light_linking.link_state].add(obj.as_pointer())
    for item, child in zip(collection.collection_children, collection.children, strict=True):
        found[item.light_linking.link_state].update(o.as_pointer() for o in child.all_objects)
    return _Members(*(frozenset(found[state]) for state in ("INCLUDE", "EXCLUDE")))
