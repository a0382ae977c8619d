"""What of a window's scene need not be read again, by what its dependency graph says has changed.

Whoever asks for a new export after every update (a click on an object is one) gets the very same
Scene as long as nothing differs that a picture shows.
"""

from __future__ import annotations

import bpy

from ..images.texture_size import WHOLE, TextureSize
from .local_mesh import LiveMeshes, session_uid

# Kinds of data that materials and world are made of. What an object is, is looked at every time.
_SHADING = (
    bpy.types.Material,
    bpy.types.World,
    bpy.types.NodeTree,
    bpy.types.Image,
    bpy.types.Texture,
)
# Sources of images that show something else in another frame.
_MOVING = ("SEQUENCE", "MOVIE")


class LiveExport:
    """Keeps the parts of the last export, each with what it was made of."""

    def __init__(self):
        self.meshes = LiveMeshes()
        self._kept: dict[str, tuple] = {}
        self._size = WHOLE
        self._all_anew = True
        self._frame: float | None = None
        # Whether shading asks for the frame, or for other properties of the scene; None: not known.
        self._asks: tuple[bool, bool] | None = None

    def forget(self) -> None:
        """Read everything at the next export: after undo, or where another file was loaded."""
        self._all_anew = True

    def forget_world(self) -> None:
        """Read the world at the next export: it has got what it was waiting for."""
        self._kept.pop("world", None)

    def use(self, size: TextureSize) -> None:
        """Read all that shows images anew where they are to have another size."""
        if size != self._size:
            self._kept, self._size = {}, size

    def begin(self, updates, frame: float = 0.0) -> None:
        """Before an export. updates: of the dependency graph since the last one; frame: of time."""
        geometry, shading = set(), self._all_anew or self._is_outdated(updates, frame)
        for update in updates:
            if update.is_updated_geometry:
                geometry.add(session_uid(update.id))
            shading |= _may_change_shading(update)
        self.meshes.begin(None if self._all_anew else geometry)
        if shading:
            self._kept, self._asks = {}, None
        self._all_anew, self._frame = False, frame

    def _is_outdated(self, updates, frame: float) -> bool:
        """Whether shading differs though no material, world or image is among the updates."""
        later = frame != self._frame
        if not later and not any(isinstance(update.id, bpy.types.Scene) for update in updates):
            return False
        if self._asks is None:
            images = any(image.source in _MOVING for image in bpy.data.images)
            self._asks = images, _scene_is_asked()
        return self._asks[1] or (later and self._asks[0])

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


def _scene_is_asked() -> bool:
    """Whether a node reads from the scene, such as its frame."""
    owners = [*bpy.data.materials, *bpy.data.worlds]
    trees = [*bpy.data.node_groups, *(each.node_tree for each in owners if each.node_tree)]
    return any(
        node.bl_idname == "GeometryNodeInputSceneTime"
        or (node.bl_idname == "ShaderNodeAttribute" and node.attribute_type == "VIEW_LAYER")
        for tree in trees
        for node in tree.nodes
    )
