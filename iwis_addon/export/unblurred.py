"""What moves while the shutter is open and stays sharp: shapes that change, and lamps.

Looked at from step to step of the motion of camera and objects; only objects with modifiers or
shape keys are, for nothing else changes a shape without a second look at every mesh.
"""

from __future__ import annotations

import numpy as np

# Of an object's size: what modifiers that follow other objects round to is below.
_CHANGED = 1e-5


class Unblurred:
    """Call look() at each time, then lines()."""

    def __init__(self):
        self._shapes: dict[str, np.ndarray] = {}
        self._lamps: dict[tuple, np.ndarray] = {}
        self._changed: dict[str, None] = {}
        self._moved: dict[str, None] = {}

    def look(self, depsgraph) -> None:
        """See where the graph's lamps and vertices are now."""
        looked = set()
        for item in depsgraph.object_instances:
            obj = item.object
            if obj.type == "LIGHT":
                self._look_at_lamp(item, obj)
            elif item.show_self and _may_deform(obj) and obj.name_full not in looked:
                looked.add(obj.name_full)
                self._look_at_shape(obj)

    def _look_at_lamp(self, item, obj) -> None:
        matrix = np.array(item.matrix_world, np.float64)
        key = (obj.name_full, item.random_id if item.is_instance else -1)
        if not np.allclose(self._lamps.setdefault(key, matrix), matrix, atol=1e-6):
            self._moved[obj.name] = None

    def _look_at_shape(self, obj) -> None:
        vertices = obj.data.vertices
        places = np.empty(3 * len(vertices), np.float32)
        vertices.foreach_get("co", places)
        first = self._shapes.setdefault(obj.name_full, places)
        size = float(np.abs(first).max(initial=0.0))
        if len(first) != len(places) or not np.allclose(
            first, places, rtol=0, atol=_CHANGED * size
        ):
            self._changed[obj.name] = None

    def lines(self, scene_name: str) -> list[str]:
        """A warning for each kind, with the objects' names."""
        found = []
        for names, what in (
            (self._changed, "objects change their shape, which is"),
            (self._moved, "moving lamps are"),
        ):
            if names:
                shown = ", ".join(list(names)[:3]) + (", ..." if len(names) > 3 else "")
                found.append(
                    f"Scene {scene_name}: {len(names)} {what} not blurred but as in the middle of "
                    f"the time that the shutter is open: {shown}"
                )
        return found


def _may_deform(obj) -> bool:
    if obj.type != "MESH" or obj.data is None:
        return False
    cycles = getattr(obj.original, "cycles", None)
    if cycles is not None and not (cycles.use_motion_blur and cycles.use_deform_motion):
        return False
    return bool(obj.modifiers) or obj.original.data.shape_keys is not None
