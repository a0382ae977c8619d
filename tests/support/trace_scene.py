"""Slow, obvious camera rays and their first hits: what an exported scene looks like."""

import bpy
import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from iwis.iwis_addon.export.camera import export_camera
from iwis.iwis_addon.export.mesh import export_mesh


class Exported:
    """What a final render of the open file exports."""

    def __init__(self, depsgraph, cache, region):
        self.warnings = []
        self.geometry = export_mesh(depsgraph, self.warnings, cache)
        self.mesh = self.geometry.mesh
        self.material_names = [m.name if m else None for m in self.geometry.materials]
        self.camera = export_camera(depsgraph, self.warnings, region=region)


def export_as_render(scene, cache=None, region=None):
    """Export from inside a RenderEngine: only there is the graph that of a final render."""
    found = []

    class Engine(bpy.types.RenderEngine):
        bl_idname = "IWIS_EXPORT_TEST"
        bl_label = "IWIS export test"

        def render(self, depsgraph):
            try:
                found.append(Exported(depsgraph, cache, region))
            except Exception as error:
                found.append(error)
            render = scene.render
            scale = render.resolution_percentage / 100
            result = self.begin_result(
                0, 0, int(render.resolution_x * scale), int(render.resolution_y * scale)
            )
            self.end_result(result)

    before = scene.render.engine
    bpy.utils.register_class(Engine)
    try:
        scene.render.engine = Engine.bl_idname
        bpy.ops.render.render()
    finally:
        scene.render.engine = before
        bpy.utils.unregister_class(Engine)
    if isinstance(found[0], Exception):
        raise found[0]
    return found[0]


def camera_rays(camera):
    """Origins on the camera's near plane, directions and the length to the far plane, (h, w, ...)."""
    x0, y0, x1, y1 = camera.region
    x, y = np.meshgrid(np.arange(x0, x1) + 0.5, np.arange(y0, y1) + 0.5)
    left, right, bottom, top = camera.window
    x = left + (right - left) * x / camera.width
    y = bottom + (top - bottom) * y / camera.height
    zero, one = np.zeros_like(x), np.ones_like(x)
    if camera.kind == "ORTHOGRAPHIC":
        origin = np.stack([x, y, zero], -1)
        direction = np.stack([zero, zero, -one], -1)
    else:
        origin = np.stack([zero, zero, zero], -1)
        direction = np.stack([x, y, -one], -1)
    origin = origin + camera.clip_start * direction
    rotation, place = camera.camera_to_world[:3, :3], camera.camera_to_world[:3, 3]
    return origin @ rotation.T + place, direction @ rotation.T


def trace(exported):
    """First hits of pixel centres: dict of position, normal, depth, object_index, material, hit.

    Depth is measured along the camera's axis from the camera. Arrays are (h, w, ...), row 0 at the
    bottom. normal is the shading normal, turned to the viewer as Cycles' pass is.
    """
    camera, mesh = exported.camera, exported.mesh
    origins, directions = camera_rays(camera)
    shape = origins.shape[:2]
    o = origins.reshape(-1, 3).astype(np.float32)
    d = directions.reshape(-1, 3).astype(np.float32)
    scene = EmbreeScene()
    TriangleMesh(scene, mesh.vertices, mesh.triangles)
    found = scene.run(o, d, query="INTERSECT", output=True)
    hit = (found["primID"] >= 0) & (found["tfar"] < camera.clip_end - camera.clip_start)
    triangle = np.where(hit, found["primID"], 0)
    weights = np.stack([1 - found["u"] - found["v"], found["u"], found["v"]], -1)
    corners = mesh.vertices[mesh.triangles[triangle]].astype(np.float64)
    position = np.einsum("nc,nca->na", weights, corners)
    normal = np.einsum("nc,nca->na", weights, mesh.corner_normals[triangle])
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    geometric = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal[np.einsum("na,na->n", geometric, d) > 0.0] *= -1.0
    row = np.where(hit, mesh.object_index[triangle], 0)
    to_camera = np.linalg.inv(camera.camera_to_world)
    depth = -(position @ to_camera[2, :3] + to_camera[2, 3])
    layers = {
        "position": position,
        "normal": normal,
        "depth": depth,
        "object_index": exported.geometry.object_pass_index[row],
        "material": mesh.material_index[triangle],
        "hit": hit,
    }
    return {name: values.reshape(shape + values.shape[1:]) for name, values in layers.items()}
