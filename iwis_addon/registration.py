"""What is registered with Blender, in this order; unregistered in the reverse."""

from __future__ import annotations

from .. import operators
from . import (
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
    panels_world,
    preferences,
    properties,
    sampling_presets,
    view_overlay,
    viewport,
)

MODULES = (
    preferences,
    properties,
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
    panels_world,
    measured,
)


def register() -> None:
    """Register everything. Without a needed package too: the panel then says what is missing."""
    done = []
    try:
        for module in MODULES:
            module.register()
            done.append(module)
    except Exception:
        for module in reversed(done):
            module.unregister()
        raise
    dependencies.warn()


def unregister() -> None:
    """Take everything back."""
    for module in reversed(MODULES):
        module.unregister()
