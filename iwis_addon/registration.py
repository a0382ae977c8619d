"""What is registered with Blender, in this order; unregistered in the reverse."""

from __future__ import annotations

import atexit

import bpy

from .. import operators
from . import (
    ADDON_ID,
    bake,
    dependencies,
    engine,
    job,
    measured,
    panels,
    panels_bake,
    panels_camera,
    panels_lamp,
    panels_object,
    panels_passes,
    panels_simplify,
    panels_status,
    panels_view,
    panels_world,
    preferences,
    properties,
    sampling_presets,
    view_overlay,
    view_shading,
    viewport,
)

MODULES = (
    preferences,
    properties,
    view_shading,
    operators,
    job,
    bake,
    viewport,
    view_overlay,
    engine,
    sampling_presets,
    panels,
    panels_simplify,
    panels_bake,
    panels_camera,
    panels_lamp,
    panels_object,
    panels_passes,
    panels_status,
    panels_view,
    panels_world,
    measured,
)


def register() -> None:
    """Register everything. Without a needed package too: the panel then says what is missing.

    Raises RuntimeError where another copy of the add-on is enabled: Blender would let the second
    take the first one's classes, and whichever is disabled would leave none that works.
    """
    other = _other_copy()
    if other:
        raise RuntimeError(
            f"IWIS is already enabled, as the add-on {other!r}: disable that one in the "
            "preferences first, for Blender can hold one IWIS only"
        )
    done = []
    try:
        for module in MODULES:
            module.register()
            done.append(module)
    except Exception:
        for module in reversed(done):
            module.unregister()
        raise
    if bpy.app.module and bpy.app.version < (5, 0):
        atexit.register(_let_process_end)
    dependencies.warn()


def unregister() -> None:
    """Take everything back."""
    atexit.unregister(_let_process_end)
    for module in reversed(MODULES):
        module.unregister()


def _let_process_end() -> None:
    """Bpy 4.5 hangs at its process' end while an engine written in Python, anybody's, is registered
    or a scene names it: so a script need not take IWIS back, nor catch its errors to do so."""
    for scene in bpy.data.scenes:
        if scene.render.engine == job.ENGINE:
            scene.render.engine = "BLENDER_WORKBENCH"
    unregister()


def _other_copy() -> str:
    """The package of an IWIS that is registered now and is not this one; "" where there is none."""
    for engine_class in bpy.types.RenderEngine.__subclasses__():
        package = engine_class.__module__.rpartition(".iwis_addon.")[0]
        same_name = getattr(engine_class, "bl_idname", "") == engine.IWISRenderEngine.bl_idname
        if same_name and engine_class.is_registered and package != ADDON_ID:
            return package
    return ""
