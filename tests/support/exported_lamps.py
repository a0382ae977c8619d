"""The lamp that the open file is exported with."""

import bpy

from iwis.iwis_addon.export import export_scene


def exported():
    """(the one lamp's row as a dict, warnings)."""
    lines = []
    scene = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=lines)
    if not len(scene.lamps.kind):
        return None, lines
    assert len(scene.lamps.kind) == 1
    shared = "faces", "texels", "falloffs"
    own = {n: value for n, value in scene.lamps._asdict().items() if n not in shared}
    return {name: value[0] for name, value in own.items()}, lines
