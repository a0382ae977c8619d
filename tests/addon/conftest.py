"""Tests inside the bpy module: left out where there is none; the add-on is registered once."""

import importlib.util

import pytest

if importlib.util.find_spec("bpy") is None:
    collect_ignore_glob = ["*"]
else:
    import bpy
    from parity.scene import empty_scene

    import iwis
    from support.bad_scenes import build_cube_scene


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
    build_cube_scene(scene)
    scene.iwis.max_samples = 8
    return scene


@pytest.fixture
def parts(scene):
    """(scene, a sphere, a cube, a floor), blurred over a whole frame at frame 1."""
    scene, tree = empty_scene(lit=True)
    tree.surface(tree.made("ShaderNodeBsdfDiffuse", 0))
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.frame_set(1)
    meshes = [obj for obj in scene.objects if obj.type == "MESH"]
    sphere, cube, floor = (next(o for o in meshes if w in o.name) for w in ("here", "ube", "lane"))
    return scene, sphere, cube, floor
