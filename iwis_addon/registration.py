"""What is registered with Blender, in this order; unregistered in the reverse."""

from __future__ import annotations

from .. import operators
from . import dependencies, engine, job, measured, panels, preferences, properties

MODULES = (preferences, properties, operators, job, engine, panels, measured)


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
