"""What every make_NAME.py needs: an empty scene under an HDRI, materials, a camera, the saved file.

The files are saved by Blender 4.5 so that 4.5 and 5.2 open them, with the HDRI packed and nothing
in them that names the machine they were made on.
"""

import gzip
import math
import re
import tempfile
from pathlib import Path

import bpy
from mathutils import Vector

import iwis

FOLDER = Path(__file__).resolve().parent


def new_scene(*, size, exposure=0.0, look="AgX - Base Contrast"):
    """The scene of a new, empty file: IWIS, `size` pixels, in Cycles direct light only."""
    if bpy.app.version[:2] != (4, 5):
        raise RuntimeError("samples are made with Blender 4.5: 5.x writes files it cannot open")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    iwis.register()  # save() takes it back
    scene = bpy.context.scene
    render = scene.render
    render.engine = "IWIS"
    render.resolution_x, render.resolution_y = size
    render.resolution_percentage = 100
    render.filepath = "//"
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = look
    scene.view_settings.exposure = exposure
    _direct_light_only(scene.cycles)
    return scene


def _direct_light_only(cycles):
    """A comparison is fair when Cycles, too, traces one light path and no filter hides noise."""
    cycles.max_bounces = 0
    cycles.samples = 128
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.light_sampling_threshold = 0.0


def light_by_hdri(scene, name, *, azimuth_deg=0.0, strength=1.0):
    """The world shows hdri/NAME.exr, packed, turned by azimuth_deg about z."""
    image = bpy.data.images.load(str(FOLDER / "hdri" / f"{name}.exr"))
    image.pack()
    world = scene.world = bpy.data.worlds.new(f"{name} sky")
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    background = nodes["Background"]
    background.inputs["Strength"].default_value = strength
    coordinates = nodes.new("ShaderNodeTexCoord")
    mapping = nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, math.radians(azimuth_deg))
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    links.new(texture.outputs["Color"], background.inputs["Color"])
    for column, node in enumerate((coordinates, mapping, texture, background)):
        node.location = (240 * column - 900, 300)


def add_camera(scene, *, location, target, lens_mm, name="Camera"):
    """The scene's camera, at `location`, looking at `target`, z up."""
    data = bpy.data.cameras.new(name)
    data.lens = lens_mm
    camera = bpy.data.objects.new(name, data)
    camera.location = location
    direction = Vector(target) - Vector(location)
    camera.rotation_euler = direction.to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera
    return camera


def diffuse(name, color):
    """A material of one Diffuse BSDF, roughness 0 (Lambert). color: linear Rec.709"""
    return _material(name, "ShaderNodeBsdfDiffuse", {"Color": color})


def glossy(name, color, roughness):
    """A material of one Glossy BSDF."""
    return _material(name, "ShaderNodeBsdfAnisotropic", {"Color": color, "Roughness": roughness})


def principled(name, color, roughness, *, metallic=0.0, ior=1.5):
    """A material of one Principled BSDF."""
    inputs = {"Base Color": color, "Roughness": roughness, "Metallic": metallic, "IOR": ior}
    return _material(name, "ShaderNodeBsdfPrincipled", inputs)


def _material(name, node_type, inputs):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new(node_type)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    output.location = (280, 0)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    for socket, value in inputs.items():
        is_color = not isinstance(value, (int, float))
        shader.inputs[socket].default_value = (*value, 1.0) if is_color else value
    color = next(iter(inputs.values()))
    material.diffuse_color = (*color, 1.0)  # for the Solid view
    return material


def save(name, folder=FOLDER):
    """Write folder/NAME.blend, gzip compressed and free of this machine's paths.

    gzip: Blender reads it, Python can write it, and its bytes can be edited first.
    """
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch) / f"{name}.blend"
        bpy.ops.wm.save_as_mainfile(
            filepath=str(path), compress=False, copy=True, relative_remap=False
        )
        data = path.read_bytes()
        data = _replace_paths(data, Path(scratch), b"//")
    data = _replace_paths(data, FOLDER, b"//")
    data = _replace_paths(data, Path.home(), b"")
    out = Path(folder) / f"{name}.blend"
    out.write_bytes(gzip.compress(data, compresslevel=9, mtime=0))
    bpy.context.scene.render.engine = "CYCLES"
    iwis.unregister()  # bpy 4.5 does not end well with an engine registered
    print(f"{out}: {out.stat().st_size / 2**20:.2f} MiB")


def _replace_paths(data, folder, prefix):
    """`data` with each zero-ended text that starts with `folder` made relative, lengths kept."""

    def relative(match):
        tail = match.group(1).lstrip(b"/")
        return (prefix + tail).ljust(len(match.group(0)), b"\0")

    # The home folder may be "/": nothing to hide then, and everything would match.
    if len(folder.parts) < 2:
        return data
    return re.sub(re.escape(str(folder).encode()) + rb"((?:/[^\0]*)?)(?=\0)", relative, data)
