"""Scenes that are wrong in one way each: change(scene, folder) of the cube scene."""

import math

import bpy
import numpy as np

from support.world_render import new_image

NAN, INF = math.nan, math.inf


def use_hdri(scene, image):
    tree = scene.world.node_tree
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.name, node.image = "Sky", image
    tree.links.new(node.outputs[0], tree.nodes["Background"].inputs["Color"])


def use_file(scene, path):
    image = bpy.data.images.new("map", 4, 4)
    image.source, image.filepath = "FILE", str(path)
    use_hdri(scene, image)


def use_texels(scene, *texels, size=(8, 16)):
    """A map of 0.5, its first texels others."""
    radiance = np.full((*size, 3), 0.5, np.float32)
    for texel, value in enumerate(texels):
        radiance[0, texel] = value
    image = new_image(radiance)
    image.file_format = "OPEN_EXR"
    image.pack()
    use_hdri(scene, image)


def new_material(name):
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    return material, material.node_tree.nodes["Principled BSDF"]


def hdri_missing(scene, folder):
    use_file(scene, folder / "gone.hdr")


def hdri_of_a_broken_name(scene, folder):
    use_file(scene, folder / "gone" / "new\nline.hdr")


def hdri_empty(scene, folder):
    (folder / "empty.exr").touch()
    use_file(scene, folder / "empty.exr")


def hdri_damaged(scene, folder):
    (folder / "bad.exr").write_bytes(b"\x76\x2f\x31\x01\x02\0\0\0channels")
    use_file(scene, folder / "bad.exr")


def hdri_cut(scene, folder):
    (folder / "cut.hdr").write_bytes(
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 64 +X 128\n\2\2\0\x80" + bytes(200)
    )
    use_file(scene, folder / "cut.hdr")


def hdri_is_a_folder(scene, folder):
    use_file(scene, folder)


def hdri_not_chosen(scene, _folder):
    use_hdri(scene, None)


def hdri_with_nan(scene, _folder):
    use_texels(scene, NAN)


def hdri_with_infinity(scene, _folder):
    use_texels(scene, INF)


def hdri_with_overflow(scene, _folder):
    use_texels(scene, 3e38)


def hdri_with_negatives(scene, _folder):
    use_texels(scene, -3e38)


def hdri_of_one_texel(scene, _folder):
    use_texels(scene, size=(1, 1))


def hdri_of_two_texels(scene, _folder):
    use_texels(scene, size=(1, 2))


def hdri_of_one_column(scene, _folder):
    use_texels(scene, size=(9, 1))


def strength_infinite(scene, _folder):
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = INF


def colour_nan(scene, _folder):
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (NAN, 1, 1, 1)


def broken_triangles(scene, _folder):
    mesh = bpy.data.meshes.new("Broken")
    corners = [(0, 0, 2), (1, 0, 2), (2, 0, 2), (0, 1, 2), (NAN, 0, 0), (INF, 0, 0)]
    mesh.from_pydata(corners, [], [(0, 1, 3), (0, 1, 2), (0, 1, 4), (0, 1, 5)])
    scene.collection.objects.link(bpy.data.objects.new("Broken", mesh))


def transform_nan(_scene, _folder):
    bpy.data.objects["Cube"].location.x = NAN


def flat_scale(_scene, _folder):
    bpy.data.objects["Cube"].scale = (1.0, 1.0, 0.0)


def scale_0(_scene, _folder):
    bpy.data.objects["Cube"].scale = (0.0, 0.0, 0.0)


def slot_left_empty(_scene, _folder):
    bpy.data.objects["Cube"].data.materials.append(None)


def slot_beyond_the_last(_scene, _folder):
    mesh = bpy.data.objects["Cube"].data
    mesh.materials.append(new_material("Only")[0])
    mesh.polygons.foreach_set("material_index", [7] * len(mesh.polygons))


def material_nan(_scene, _folder):
    material, node = new_material("Skin")
    node.inputs["Base Color"].default_value = (NAN, 0.5, 0.5, 1.0)
    bpy.data.objects["Cube"].data.materials.append(material)


def far_from_the_origin(scene, _folder):
    for obj in scene.objects:
        obj.location.x += 1e7


def scene_of_1e7_metres(scene, _folder):
    for obj in scene.objects:
        obj.location *= 1e7
        if obj.type == "MESH":
            obj.scale = (1e7, 1e7, 1e7)
    scene.camera.data.clip_end = 1e9


def scene_of_a_hundredth_of_a_millimetre(scene, _folder):
    for obj in scene.objects:
        obj.location *= 1e-5
        if obj.type == "MESH":
            obj.scale = (1e-5, 1e-5, 1e-5)
    scene.camera.data.clip_start = 1e-7


def error_threshold_0(scene, _folder):
    scene.iwis.error_threshold = 0.0


def fewer_samples_than_a_batch(scene, _folder):
    scene.iwis.max_samples, scene.iwis.batch_size = 3, 8


def a_million_threads(scene, _folder):
    scene.iwis.threads = 1_000_000


def no_world(scene, _folder):
    scene.world = None


def world_without_shader(scene, _folder):
    scene.world.node_tree.nodes.clear()


def world_black(scene, _folder):
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0


def hdri_all_nan(scene, _folder):
    use_hdri(scene, new_image(np.full((2, 4, 3), NAN, np.float32)))


def no_objects(scene, _folder):
    for obj in [obj for obj in scene.objects if obj.type == "MESH"]:
        bpy.data.objects.remove(obj)


def only_broken_triangles(scene, folder):
    no_objects(scene, folder)
    broken_triangles(scene, folder)
    bpy.data.meshes["Broken"].vertices[3].co.z = NAN


def clip_end_before_everything(scene, _folder):
    scene.camera.data.clip_start, scene.camera.data.clip_end = 1e-6, 1e-5


def clip_end_before_clip_start(scene, _folder):
    scene.camera.data.clip_start, scene.camera.data.clip_end = 100.0, 1.0


def no_camera(scene, _folder):
    bpy.data.objects.remove(scene.camera)


def flat_camera(scene, _folder):
    scene.camera.scale = (0.0, 1.0, 1.0)


def camera_nowhere(scene, _folder):
    scene.camera.location = (NAN, 0.0, 0.0)


def damaged_mesh(scene, _folder):
    mesh = bpy.data.meshes.new("Damaged")
    mesh.from_pydata([(0, 0, 2), (1, 0, 2), (0, 1, 2)], [], [(0, 1, 2)])
    mesh.attributes[".corner_vert"].data.foreach_set("value", [0, 1, 77])
    scene.collection.objects.link(bpy.data.objects.new("Damaged", mesh))


def empty_border(scene, _folder):
    scene.render.use_border = True
    scene.render.border_min_x = scene.render.border_max_x = 0.5


def no_view_layer(scene, _folder):
    scene.view_layers[0].use = False


def save_cube_scene(path, change):
    """A .blend of the cube on a plane, 32 x 24 pixels, changed if a function is given; its path."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    build_cube_scene(scene)
    if change is not None:
        change(scene, path.parent)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def build_cube_scene(scene):
    """A grey cube on a plane under a white world of strength 1, seen by a camera from above."""
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=(0.0, 0.0, 0.5))
    bpy.ops.mesh.primitive_plane_add(size=8.0)
    bpy.ops.object.camera_add(location=(3.0, -3.0, 3.0), rotation=(0.95, 0.0, 0.785))
    scene.camera = bpy.context.object
    scene.world = bpy.data.worlds.new("White")
    if bpy.app.version < (5, 0, 0):
        scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
