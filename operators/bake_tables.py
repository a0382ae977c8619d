"""Build the wavelet tables ahead of a farm job, so that its frames only read them."""

import bpy

from ..core.film import Film, Progress
from ..iwis_addon import dependencies
from ..iwis_addon.export import ExportError, export_scene
from ..iwis_addon.preferences import share_cache_dir
from ..iwis_addon.settings import render_settings


class IWIS_OT_bake_tables(bpy.types.Operator):
    """Build the wavelet tables of world and materials, and keep them in the cache folder"""

    bl_idname = "iwis.bake_tables"
    bl_label = "Bake Wavelet Tables"

    def execute(self, context):
        manager = context.window_manager
        manager.progress_begin(0.0, 1.0)
        try:
            warnings = bake_tables(context.evaluated_depsgraph_get(), manager.progress_update)
        except (dependencies.MissingPackage, ExportError, OSError, ValueError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            manager.progress_end()
        for line in warnings:
            self.report({"WARNING"}, line)
        self.report({"INFO"}, "Tables are built and kept")
        return {"FINISHED"}


class _ProgressOnly(Film):
    """A sink that passes on how far the tables are; tiles never come."""

    def __init__(self, tell):
        super().__init__((0, 0, 1, 1))
        self._tell = tell

    def progress(self, progress: Progress) -> None:
        self._tell(progress.fraction)


def bake_tables(depsgraph, tell) -> list[str]:
    """Build and keep the tables that a render in mode Paper would; return warnings.

    tell: called with the fraction that is done
    """
    dependencies.require()
    share_cache_dir()
    from ..core.render import prepare_tables

    warnings: list[str] = []
    scene = export_scene(depsgraph, warnings=warnings)
    settings = render_settings(depsgraph.scene_eval)
    stats = prepare_tables(scene, settings, _ProgressOnly(tell))
    return warnings + stats.warnings


CLASSES = (IWIS_OT_bake_tables,)
