"""Exports as a rendered view makes them, of what has changed alone."""

import bpy

from iwis.iwis_addon.export import ExportCache, LiveExport, export_scene
from iwis.iwis_addon.export.meshes import parts as parts_module


class Window:
    """Exports as a rendered view does, and counts the meshes that are read."""

    def __init__(self, monkeypatch):
        self.live, self.cache, self.read = LiveExport(), ExportCache(), []
        self.cache.live = self.live.meshes
        original = parts_module.read_mesh

        def read_mesh(mesh, *rest):
            self.read.append(mesh.name)
            return original(mesh, *rest)

        monkeypatch.setattr(parts_module, "read_mesh", read_mesh)

    def export(self, change=lambda: None):
        """The scene after a change, and the names of the meshes that were read for it."""
        result = []

        def take(_scene, depsgraph):
            self.read.clear()
            self.live.begin(depsgraph.updates, depsgraph.scene.frame_current_final)
            lines = []
            scene = export_scene(depsgraph, warnings=lines, cache=self.cache, live=self.live)
            result.append((scene, list(self.read), lines))

        handlers = bpy.app.handlers.depsgraph_update_post, bpy.app.handlers.frame_change_post
        for each in handlers:
            each.append(take)
        try:
            change()
            bpy.context.view_layer.update()
        finally:
            for each in handlers:
                each.remove(take)
        return result[-1]
