"""Slow, obvious camera rays and their first hits: what an exported scene looks like."""

import bpy
import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from iwis.iwis_addon.export.cameras.camera import export_camera
from iwis.iwis_addon.export.placed.mesh import export_mesh
from support.cycles_render import render_cycles


class Exported:
    """What a final render of the open file exports."""

    def __init__(self, depsgraph, cache, region):
        self.warnings = []
        self.geometry = export_mesh(depsgraph, self.warnings, cache)
        self.mesh = self.geometry.mesh
        self.materials = [(m.name, m.pass_index) if m else None for m in self.geometry.materials]
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
    """Origins on the camera's near plane and directions of depth 1, float64 (h, w, 3)."""
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


def render_diffuse(scene, tmp_path):
    """Cycles' layers with every surface diffuse: specular closures bend the normal of the pass."""
    layer = scene.view_layers[0]
    before = layer.material_override
    layer.material_override = material = bpy.data.materials.new("Diffuse")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    nodes = material.node_tree.nodes
    output = nodes["Material Output"].inputs["Surface"]
    material.node_tree.links.new(nodes.new("ShaderNodeBsdfDiffuse").outputs[0], output)
    try:
        return render_cycles(scene, tmp_path)
    finally:
        layer.material_override = before
        bpy.data.materials.remove(material)


def assert_seen_as_in_cycles(scene, tmp_path, region=None):
    """Render with Cycles, export, trace: the same first hits. Returns what was exported.

    A ray that grazes an edge may fall on either side of it: 0.3 % of the pixels may differ.
    """
    seen = render_diffuse(scene, tmp_path)
    exported = export_as_render(scene, region=region)
    mine = trace(exported)
    x0, y0, x1, y1 = exported.camera.region
    if seen["Depth"].shape[:2] != (y1 - y0, x1 - x0):  # a border that is not cropped
        seen = {name: pixels[y0:y1, x0:x1] for name, pixels in seen.items()}
    depth = seen["Depth"][..., 0]
    hit = depth < 1e9  # Cycles writes 1e10 where it sees the world
    assert hit.shape == mine["hit"].shape
    assert hit.mean() > 0.05, "the picture shows next to nothing"
    scale = np.abs(seen["Position"][hit]).max()
    # 1e-4: float32 through Cycles' own matrices; a pixel's width is 100 times that
    same = np.abs(seen["Position"] - mine["position"]).max(axis=-1) <= 1e-4 * scale
    same &= np.abs(depth - mine["depth"]) <= 1e-4 * depth
    # 1e-3: Cycles 5.2 packs a normal into 32 bits, and interpolates near the edge of a triangle
    same &= np.abs(seen["Normal"] - mine["normal"]).max(axis=-1) <= 1e-3
    index = seen.get("Object Index", seen.get("IndexOB"))[..., 0]
    same &= index == mine["object_index"]
    different = np.where(hit | mine["hit"], ~(same & hit & mine["hit"]), False)
    assert different.mean() <= 0.003, f"{different.sum()} of {different.size} pixels differ"
    assert np.abs(depth[~hit] - 1e10).max(initial=0.0) == 0.0
    return exported
