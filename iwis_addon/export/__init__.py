"""Blender's evaluated scene to core.scene.Scene: after this nothing of bpy is needed.

errors                       what can stop an export
local_mesh, instances, mesh  evaluated meshes, where they stand, one table of triangles
camera, world                the other parts of a Scene
material, shader_reader      shader nodes to rows of materials, and to closures of programs
program_builder, ..._nodes, ..._images, surface_data
                             value nodes to operations, with all that these look up
"""

from __future__ import annotations

from ...core.program import Shaders
from ...core.scene import Scene
from .camera import export_camera
from .errors import ExportCancelled, ExportError
from .material import MaterialExport, export_shaders
from .mesh import ExportCache, MeshExport, export_mesh
from .surface_data import surface_data
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
    texels = None if cache is None else cache.texels
    environment = export_world(depsgraph, warnings, texels)
    materials = export_shaders(geometry.materials, warnings, geometry.material_users, texels)
    if cancelled():
        raise ExportCancelled
    scene = depsgraph.scene_eval
    return Scene(
        mesh=geometry.mesh,
        materials=materials.params,
        shaders=_shaders(geometry, materials, warnings),
        environment=environment,
        camera=camera,
        material_pass_index=materials.pass_index,
        object_pass_index=geometry.object_pass_index,
        terminator_offset=geometry.terminator_offset,
        transparent_film=scene.render.film_transparent,
        # The film exposure belongs to Cycles' settings, there as long as its add-on is enabled.
        exposure=scene.cycles.film_exposure if hasattr(scene, "cycles") else 1.0,
    )


def _shaders(
    geometry: MeshExport, materials: MaterialExport, warnings: list[str]
) -> Shaders | None:
    """The programs of the scene's materials; None where no material needs one."""
    if not any(materials.programs):
        return None
    surface = surface_data(
        geometry.inventory, geometry.mesh, geometry.kept, materials.requests, warnings
    )
    return Shaders(
        programs=materials.programs,
        surface=surface,
        material_pass_index=materials.pass_index,
    )
