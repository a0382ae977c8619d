"""Tests inside the bpy module: left out where there is none; the add-on is registered once."""

import importlib.util

import pytest

if importlib.util.find_spec("bpy") is None:
    collect_ignore_glob = ["*"]
else:
    import bpy

    import iwis


@pytest.fixture(scope="session", autouse=True)
def registered():
    """The add-on as Blender enables it. tests/conftest.py unregisters when all is over."""
    iwis.register()


@pytest.fixture
def scene():
    """An empty file: its scene, set to IWIS, 32x24 pixels and one thread."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "IWIS"
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    scene.render.resolution_percentage = 100
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    return scene


@pytest.fixture
def cube_scene(scene):
    """A grey cube on a plane under a white world of strength 1, seen by a camera from above."""
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=(0.0, 0.0, 0.5))
    bpy.ops.mesh.primitive_plane_add(size=8.0)
    bpy.ops.object.camera_add(location=(3.0, -3.0, 3.0), rotation=(0.95, 0.0, 0.785))
    scene.camera = bpy.context.object
    scene.world = bpy.data.worlds.new("White")
    if bpy.app.version < (5, 0, 0):
        scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    scene.iwis.max_samples = 8
    return scene
