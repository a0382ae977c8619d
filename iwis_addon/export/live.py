"""What of a window's scene need not be read again, by what its dependency graph says has changed.

Whoever asks for a new export after every update (a click on an object is one) gets the very same
Scene as long as nothing differs that a picture shows.
"""

from __future__ import annotations

import bpy

from .local_mesh import LiveMeshes, session_uid

# Kinds of data that materials and world are made of. What an object is, is looked at every time.
_SHADING = (
    bpy.types.Material,
    bpy.types.World,
    bpy.types.NodeTree,
    bpy.types.Image,
    bpy.types.Texture,
)


class LiveExport:
    """Keeps the parts of the last export, each with what it was made of."""

    def __init__(self):
        self.meshes = LiveMeshes()
        self._kept: dict[str, tuple] = {}
        self._all_anew = True

    def forget(self) -> None:
        """Read everything at the next export: after undo, or where another file was loaded."""
        self._all_anew = True

    def forget_world(self) -> None:
        """Read the world at the next export: it has got what it was waiting for."""
        self._kept.pop("world", None)

    def begin(self, updates) -> None:
        """Before an export. updates: of the dependency graph since the last one."""
        geometry, shading = set(), self._all_anew
        for update in updates:
            if update.is_updated_geometry:
                geometry.add(session_uid(update.id))
            shading |= _may_change_shading(update)
        self.meshes.begin(None if self._all_anew else geometry)
        if shading:
            self._kept = {}
        self._all_anew = False

    def keep(self, kind: str, made_of: list, warnings: list[str], make):
        """make(lines), or the last one's result with its warnings where nothing has changed.

        made_of: bpy data or None, whose identity decides along with the graph's updates
        """
        key = [None if data is None else session_uid(data) for data in made_of]
        if kind not in self._kept or self._kept[kind][0] != key:
            lines: list[str] = []
            self._kept[kind] = key, make(lines), lines
        warnings.extend(self._kept[kind][2])
        return self._kept[kind][1]


def _may_change_shading(update) -> bool:
    if isinstance(update.id, _SHADING):
        return True
    # A world may be turned by an empty, or follow the camera.
    moved = isinstance(update.id, bpy.types.Object) and update.is_updated_transform
    return moved and update.id.type != "MESH"
