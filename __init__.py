"""IWIS, a render engine for scenes lit by an HDRI. Blender calls register() and unregister().

A script that imports bpy may call the others as well:

    import iwis
    iwis.register()
    iwis.settings(scene, max_samples=64, stop_rule="FIXED")
    radiance = iwis.render(scene)["combined"]  # float32 (h, w, 4), row 0 at the bottom

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


def settings(scene, **values):
    """Set ``scene.iwis`` from keywords, all or none; return the core's RenderSettings.

    Raises ValueError for a name that is no setting and for a value out of range.
    """
    from .iwis_addon import scripting

    return scripting.change_settings(scene, **values)


def render(scene=None, layer="", view=""):
    """Render a scene's current frame: name -> float32 (h, w, channels), row 0 at the bottom.

    The names are those of core.film.LAYERS: combined, depth, samples ... No file is written, and
    no setting of the scene stays changed. Raises RuntimeError with what to do where it fails.
    """
    from .iwis_addon import scripting

    return scripting.render_arrays(scene, layer, view)
