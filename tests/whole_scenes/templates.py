"""The scene of a new file: Blender's own, and those of its application templates."""

from __future__ import annotations

from pathlib import Path

import bpy

from .stage import Whole


def _factory():
    bpy.ops.wm.read_homefile(use_factory_startup=True)


def _of_file(path: Path):
    def build():
        bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
        scene = bpy.context.scene
        # Templates for other work than rendering have no camera: look at the middle.
        if scene.camera is None:
            scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
            scene.camera.location, scene.camera.rotation_euler = (0.0, -8.0, 2.0), (1.33, 0.0, 0.0)
            scene.collection.objects.link(scene.camera)
            return "no camera in the template: one looks at the middle"
        return ""

    return build


def scenes() -> list[Whole]:
    folders = [Path(folder) for folder in bpy.utils.app_template_paths()]
    paths = sorted(path for folder in folders for path in folder.glob("*/startup.blend"))
    found = [Whole("template", "General (factory startup)", _factory)]
    return found + [Whole("template", path.parent.name, _of_file(path)) for path in paths]
