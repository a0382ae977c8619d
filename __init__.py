"""IWIS, a render engine for scenes lit by an HDRI. Blender calls the two functions below.

Nothing is imported here at top level: pytest, and Blender's scan for extensions, import this file
for its name alone (docs/architecture.md).
"""

__version__ = "0.1.0"


def register():
    """Make the engine, its settings, panels and operators known to Blender."""
    from .iwis_addon import registration

    registration.register()


def unregister():
    """Take back all that register() made known."""
    from .iwis_addon import registration

    registration.unregister()
