"""Small scenes seen from above, to compare the exporter's view with that of Cycles."""

import bpy

# Two quads that are not planar: faces, triangles and vertices all have normals of their own.
BENT = [(-1, -1, 0), (0, -1, 0), (1, -1, 0.6), (-1, 1, 0.5), (0, 1, 0), (1, 1, 0)]
QUADS = [(0, 1, 4, 3), (1, 2, 5, 4)]


def look_from_above(scene):
    """An orthographic camera that sees 4 m of the xy plane from z = 5, 48 x 48 pixels."""
    bpy.ops.object.camera_add(location=(0.0, 0.0, 5.0))
    scene.camera = bpy.context.object
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 4.0
    scene.render.resolution_x = scene.render.resolution_y = 48


def add_mesh(scene, vertices=BENT, faces=QUADS, name="Thing"):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    obj = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(obj)
    return obj


def add_monkey(**place):
    bpy.ops.mesh.primitive_monkey_add(size=1.6, **place)
    obj = bpy.context.object
    obj.data.shade_smooth()
    return obj


def add_materials(mesh, count):
    """Append materials M1, M2, ... with pass indices 1, 2, ..."""
    for i in range(1, count + 1):
        material = bpy.data.materials.new(f"M{i}")
        material.pass_index = i
        mesh.materials.append(material)
