"""What Blender wants baked -> core.bake_points: a triangle and a place on it for each texel."""

from __future__ import annotations

import dataclasses

import numpy as np

from ...core.data.bake_points import BakePoints
from ...core.scene import ORTHOGRAPHIC, Camera, Scene
from .asked import occlusion_distance, uv_maps
from .cameras.camera import export_camera
from .errors import ExportError
from .placed.mesh import MeshExport

_NOWHERE = Camera(
    kind=ORTHOGRAPHIC,
    camera_to_world=np.eye(4),
    window=(-1.0, 1.0, -1.0, 1.0),
    width=1,
    height=1,
    region=(0, 0, 1, 1),
    clip_start=0.1,
    clip_end=100.0,
)


def camera_of_bake(depsgraph, warnings: list[str]) -> Camera:
    """The scene's camera, which nodes and ``view_from`` may ask for; else one at the origin."""
    if depsgraph.scene_eval.camera is None:
        return _NOWHERE
    return export_camera(depsgraph, warnings)


def with_asked(scene: Scene, depsgraph, geometry: MeshExport) -> Scene:
    """The scene with what AO and UV ask for, whatever passes the view layer has."""
    distance = occlusion_distance(depsgraph)
    asked = scene.asked._replace(occlusion_distance=distance, uv=uv_maps(geometry))
    return dataclasses.replace(scene, asked=asked)


def bake_points(passes, obj, scene: Scene, geometry: MeshExport, from_camera: bool) -> BakePoints:
    """The texels that show an object.

    passes: of Blender's bake result: name -> float32 (h, w, channels)
    obj: the evaluated object, as long as the graph of ``geometry`` lives
    Raises ExportError where the object is not rendered, or its mesh is another.
    """
    primitive = passes["BakePrimitive"]
    number = primitive.view(np.int32)[..., 2]
    there = (primitive.view(np.int32)[..., 0] != -1) & (number >= 0)
    row = _instance_of(obj, geometry)
    return BakePoints(
        mesh=scene.mesh,
        triangle=_rows(np.where(there, number, -1), row, geometry, obj.name),
        weights=np.where(there[..., None], primitive[..., :2], np.float32(0.0)),
        steps=np.where(there[..., None], passes["BakeDifferential"], np.float32(0.0)),
        mirrored=bool(np.linalg.det(geometry.inventory.instances[row].object_to_world[:3, :3]) < 0),
        from_camera=from_camera,
    )


def _instance_of(obj, geometry: MeshExport) -> int:
    """The row of the object itself among the instances, which may be copies of it as well."""
    inventory = geometry.inventory
    for row, (instance, look) in enumerate(zip(inventory.instances, inventory.looks, strict=True)):
        own = look.asked.own.original == obj.original and look.asked.instancer is None
        if own and instance.number < 0 and not instance.hair:
            return row
    raise ExportError(
        f"Object {obj.name} has no face that is rendered: show it in renders, and its collection "
        "in the view layer, then bake again"
    )


def _rows(triangle, row: int, geometry: MeshExport, name: str) -> np.ndarray:
    """int32 (h, w): rows of the scene's mesh, of those of one instance; -1 stays."""
    size = len(geometry.inventory.parts[geometry.inventory.instances[row].part].triangles)
    if triangle.max(initial=-1) >= size:
        raise ExportError(
            f"Object {name}: it is baked as {triangle.max() + 1} triangles or more, but rendered "
            f"as {size}: apply its modifiers, or give the viewport the same ones as the render"
        )
    objects = geometry.mesh.object_index if geometry.kept is None else geometry.kept[1]
    found = np.argmax(objects == row) + np.maximum(triangle, 0)
    if geometry.kept is not None:  # what has no area shows nothing
        kept = geometry.kept[0]
        found = np.where(kept[found], np.cumsum(kept)[found] - 1, -1)
    return np.where(triangle >= 0, found, -1).astype(np.int32)
