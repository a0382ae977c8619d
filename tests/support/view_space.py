"""A 3D view, which background mode has without a window."""

import bpy


def view_space():
    """The first SpaceView3D of the file, in shading Rendered."""
    areas = (area for screen in bpy.data.screens for area in screen.areas)
    space = next(area.spaces[0] for area in areas if area.type == "VIEW_3D")
    space.shading.type = "RENDERED"
    return space
