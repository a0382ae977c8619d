"""Blender's evaluated scene to core.scene.Scene: after this nothing of bpy is needed.

errors                       what can stop an export
local_mesh, instances, mesh  evaluated meshes, where they stand, one table of triangles
camera, material, world      the other parts of a Scene
measured                     materials with a measured BRDF in place of nodes
"""

from __future__ import annotations

from ...core.scene import NO_MEASURED, Scene
from .camera import export_camera
from .errors import ExportCancelled, ExportError
from .material import export_materials
from .measured import add_measured, without_measured
from .mesh import ExportCache, export_mesh
from .world import export_world

__all__ = ["ExportCache", "ExportCancelled", "ExportError", "export_scene"]


def export_scene(
    depsgraph,
    *,
    region=None,
    warnings: list[str],
    cache: ExportCache | None = None,
    cancelled=lambda: False,
) -> Scene:
    """All that one picture of the graph's scene and view layer needs.

    region: as for export_camera; cache: as for export_mesh and export_world
    warnings: gets one line for all that is rendered otherwise than Cycles would
    Raises ExportError with what to do about it, ExportCancelled soon after cancelled() says so.
    """
    camera = export_camera(depsgraph, warnings, region=region)
    geometry = export_mesh(depsgraph, warnings, cache, cancelled)
    materials, material_pass_index = export_materials(
        without_measured(geometry.materials), warnings, geometry.material_users
    )
    materials, material_pass_index, measured = add_measured(
        geometry.materials, materials, material_pass_index, geometry.material_users
    )
    environment = export_world(depsgraph, warnings, None if cache is None else cache.texels)
    if cancelled():
        raise ExportCancelled
    scene = depsgraph.scene_eval
    return Scene(
        mesh=geometry.mesh,
        materials=materials,
        environment=environment,
        camera=camera,
        material_pass_index=material_pass_index,
        object_pass_index=geometry.object_pass_index,
        terminator_offset=geometry.terminator_offset,
        transparent_film=scene.render.film_transparent,
        # The film exposure belongs to Cycles' settings, there as long as its add-on is enabled.
        measured=measured or NO_MEASURED,
        exposure=scene.cycles.film_exposure if hasattr(scene, "cycles") else 1.0,
    )
