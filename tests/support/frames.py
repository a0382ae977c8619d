"""Exports that look at other frames, with a stand-in for the render engine."""

import functools
from types import SimpleNamespace

import bpy

from iwis.iwis_addon.export import export_scene
from iwis.iwis_addon.export.motion.motion import export_in_motion


def engine_of(scene):
    """What exports that look at other frames want of an engine."""
    return SimpleNamespace(frame_set=lambda frame, part: scene.frame_set(frame, subframe=part))


def exported_in_motion(cache=None):
    """(scene, warnings) of an export with motion."""
    scene = bpy.context.scene
    for obj in scene.objects:  # Cycles' own settings of an object tell nobody that they change
        obj.update_tag()
    graph, lines = bpy.context.evaluated_depsgraph_get(), []
    export = functools.partial(export_scene, graph, warnings=lines, cache=cache)
    return export_in_motion(engine_of(scene), graph, lines, export), lines


def objects_of(scene, shapes):
    """Rows of the objects that some core.data.object_motion.Shapes are of."""
    return set(scene.mesh.object_index[shapes.triangle].tolist())
