"""Tests inside the bpy module: left out where there is none; the add-on is registered once."""

import importlib.util

import pytest

if importlib.util.find_spec("bpy") is None:
    collect_ignore_glob = ["*"]
else:
    import bpy

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
