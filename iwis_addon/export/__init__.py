"""Blender's evaluated scene to core.scene.Scene: after this nothing of bpy is needed.

errors, same, radiance       what can stop an export, equal parts, light that can be rendered
free_memory, libraries, left_out  what there is room for, and what is told
cameras                      cameras and panoramas
images                       texels, as many as are wanted; skies, black bodies, IES files
meshes                       what an object shows, in its own space: evaluated meshes, diced ones,
                             points and strands as spheres and tubes, what nodes ask of them
objects                      what objects say of themselves: rays, links, groups, properties; what
                             is culled
shaders                      trees of nodes to rows of materials, closures and programs
worlds                       a world's tree to a map, or a program over directions
lamps                        lights to rows, with their nodes and pictures
placed                       instances and copies, one table of triangles, what programs ask of it
motion                       camera, objects and shapes at other times; the Vector pass
asked, aovs                  passes on request: mist, mattes, ambient occlusion, what nodes write
view_shading                 what a window shows otherwise than a render: its world, one pass
bake                         triangles of an object for the texels that Blender wants baked
"""

from __future__ import annotations

import dataclasses

import bpy
import numpy as np

from ...core.data.asked_passes import AskedPasses
from ...core.data.program import Shaders, SurfaceData
from ...core.lamplight.emitters import Told, with_emitters
from ...core.scene import NO_MEASURED, MeasuredBrdfs, Scene
from .aovs import AovExport, export_aovs, no_aovs
from .asked import asked_in_view, occlusion_distance, read_asked
from .cameras.camera import export_camera
from .errors import ExportCancelled, ExportError
from .images.texel_cache import TexelCache
from .images.texture_size import texture_size
from .lamps.lamp_pictures import with_pictures
from .libraries import warn_of_missing_libraries
from .meshes.adaptive import Dicing
from .meshes.live import LiveExport
from .objects.culling import culling_of
from .objects.light_groups import rows_of
from .placed.copied import Copying
from .placed.displaced_mesh import displaced_geometry
from .placed.mesh import ExportCache, MeshExport, export_mesh
from .placed.surface_data import surface_data
from .shaders.material import MaterialExport, export_shaders
from .shaders.measured import add_measured, without_measured
from .shaders.node_values import NodeReader
from .view_shading import AS_RENDERED, ViewShading
from .worlds.studio_light import read_studio_light
from .worlds.world import NO_LIGHT, NO_WORLD, is_in_layer, read_world, world_of
from .worlds.world_picture import LEAST_IN_WINDOW

__all__ = [
    "ExportCache",
    "ExportCancelled",
    "ExportError",
    "LiveExport",
    "export_scene",
    "film_exposure",
]

_UNEVEN = (
    "its emission changes with the distance otherwise in one place than in another: it lights "
    "other surfaces as its brightest places do"
)
_NEAR = (
    "its emission depends on what is near it: as such it is seen, but it lights other surfaces as "
    "if nothing were near, as Cycles' light samples do"
)
_TURNED = (
    "its emission depends on where it is seen from: as such it is seen, but it lights other "
    "surfaces in all directions as it does straight ahead"
)


def export_scene(
    depsgraph,
    *,
    region=None,
    warnings: list[str],
    cache: ExportCache | None = None,
    cancelled=lambda: False,
    camera=None,
    own_camera=None,
    live: LiveExport | None = None,
    view: ViewShading = AS_RENDERED,
    geometry: list[MeshExport] | None = None,
    written_out: bool = False,
    diced: bool = True,
) -> Scene:
    """All that one picture of the graph's scene and view layer needs.

    region: as for export_camera; cache: as for export_mesh and read_world
    camera: a core.scene.Camera in place of the scene's; own_camera: own of export_camera
    live: what of a window need not be read; view: what it shows otherwise than a render
    warnings: gets one line for all that is rendered otherwise than Cycles would
    geometry: gets what the mesh table was made of
    written_out: whether all triangles of all instances are to be in the mesh table
    diced: whether adaptive subdivision and culling count, which baking does not know
    Raises ExportError with what to do about it, ExportCancelled soon after cancelled() says so.
    """
    warn_of_missing_libraries(warnings)
    camera = camera or export_camera(depsgraph, warnings, region=region, own=own_camera)
    read, texels = geometry, TexelCache() if cache is None else cache.texels
    texels.size, texels.frame = texture_size(depsgraph), depsgraph.scene.frame_current
    if live is not None:
        live.use(texels.size)
    shading = _Shading(depsgraph, live, view, texels, cancelled, warnings)
    copying = None if written_out else Copying(shading.materials_of, _pixels(camera, live))
    dicing = Dicing(depsgraph, camera) if diced else None
    own = copying, dicing, culling_of(depsgraph, camera) if diced else None
    geometry = export_mesh(depsgraph, warnings, cache, cancelled, *own)
    materials, measured = shading.of(geometry.materials, geometry.material_users)
    world = shading.world()
    if cancelled():
        raise ExportCancelled
    own = geometry.materials, geometry.material_users, warnings, texels
    aovs = export_aovs(depsgraph, *own) if live is None else no_aovs(geometry.materials)
    surface = _surface(geometry, materials, aovs)
    own = materials, surface, camera, cache, cancelled
    geometry = displaced_geometry(geometry, *own)
    if read is not None:
        read.append(geometry)
    shaders = _shaders(geometry, materials, aovs, surface, occlusion_distance(depsgraph))
    own = depsgraph, geometry
    asked = read_asked(*own) if live is None else asked_in_view(*own, view.shown)
    own = geometry, materials, measured, shaders, world, camera, asked
    unlit = _without_lamps(depsgraph, *own, in_window=live is not None)
    return _with_lamps(unlit, geometry, texels, warnings)


def _without_lamps(
    depsgraph,
    geometry: MeshExport,
    materials: MaterialExport,
    measured: MeasuredBrdfs | None,
    shaders: Shaders | None,
    world,
    camera,
    asked: AskedPasses,
    in_window: bool,
) -> Scene:
    """A Scene of its parts. world: of read_world; in_window: its objects may be moved there."""
    scene = depsgraph.scene_eval
    placed = in_window and geometry.rest is None
    return Scene(
        mesh=geometry.mesh,
        materials=materials.params,
        shaders=shaders,
        environment=world.light,
        backdrop=world.backdrop,
        camera=camera,
        material_pass_index=materials.pass_index,
        object_pass_index=geometry.object_pass_index,
        terminator_offset=geometry.terminator_offset,
        object_flags=geometry.object_flags,
        transparent_film=scene.render.film_transparent,
        measured=measured or NO_MEASURED,
        exposure=film_exposure(scene),
        asked=asked,
        object_to_world=_places(geometry) if placed else None,
        copies=geometry.copies,
    )


def _pixels(camera, live) -> int:
    """Of Copying."""
    x0, y0, x1, y1 = camera.region
    return (x1 - x0) * (y1 - y0) if live is None else 0


class _Shading:
    """The materials and the world of a graph; of a window what has changed alone is read."""

    def __init__(self, depsgraph, live, view: ViewShading, texels, cancelled, warnings: list[str]):
        self._view, self._depsgraph = view, depsgraph
        self._cancelled, self._warnings = cancelled, warnings
        self._keep = (live or LiveExport()).keep
        self._texels, self._in_window = texels, live is not None
        self._found = None

    def of(self, materials: list, users: list[list[str]]):
        """What _export gives; once, whoever asks again."""
        if self._found is None:
            self._found = self._keep(
                "materials",
                materials,
                self._warnings,
                lambda lines: self._export(materials, users, lines),
            )
        return self._found

    def _export(self, materials: list, users: list[list[str]], lines: list[str]):
        """(MaterialExport, MeasuredBrdfs or None) of the materials of a mesh table."""
        own = users, self._texels, self._depsgraph
        found = export_shaders(without_measured(materials), lines, *own)
        params, index, measured = add_measured(materials, found.params, found.pass_index, users)
        return found._replace(params=params, pass_index=index), measured

    def materials_of(self, materials: list, users: list[list[str]]) -> MaterialExport:
        """Of export_mesh."""
        return self.of(materials, users)[0]

    def world(self):
        """What read_world gives, or what stands for it."""
        if self._view.studio is not None:
            own = self._view.studio, self._warnings, self._texels
            return read_studio_light(self._depsgraph, *own)
        own = self._texels, self._cancelled, LEAST_IN_WINDOW if self._in_window else None
        return self._keep(
            "world",
            [world_of(self._depsgraph) if is_in_layer(self._depsgraph) else None],
            self._warnings,
            lambda lines: read_world(self._depsgraph, lines, *own),
        )


def _places(geometry: MeshExport) -> np.ndarray:
    places = [instance.object_to_world for instance in geometry.inventory.instances]
    return np.array(places, np.float64).reshape(-1, 4, 4)


def _with_lamps(scene: Scene, geometry: MeshExport, cache, warnings: list[str]) -> Scene:
    """The scene with its lamps, and its faces that shine. cache: a TexelCache, or None"""
    told = Told([], [], [])
    inventory, emission = geometry.inventory, scene.materials.emission
    every = [look.asked for look in inventory.looks]
    own = inventory.links.rows_of(every), rows_of(every, inventory.groups)
    rows, texels = with_pictures(inventory.lamps, scene.camera, cache, warnings)
    lamps = with_emitters(rows, scene.mesh, emission, scene, told, *own)
    if len(texels):
        lamps = lamps._replace(texels=texels)
    _tell(geometry, told.turned, _TURNED, warnings)
    _tell(geometry, told.uneven, _UNEVEN, warnings)
    _tell(geometry, told.near, _NEAR, warnings)
    if len(lamps.kind):
        warnings[:] = [line for line in warnings if not line.endswith((NO_LIGHT, NO_WORLD))]
    lamps, links = inventory.links.of_lamps(lamps, every)
    return dataclasses.replace(scene, lamps=lamps, lamp_links=links)


def _tell(geometry: MeshExport, rows: list[int], text: str, warnings: list[str]) -> None:
    """Warn of materials."""
    for k in rows:
        if k < len(geometry.materials) and geometry.materials[k] is not None:
            reader = NodeReader(geometry.materials[k].name, geometry.material_users[k], warnings)
            reader.warn(None, text)


def film_exposure(scene) -> float:
    """It belongs to Cycles' settings, there as long as its add-on is enabled."""
    return scene.cycles.film_exposure if hasattr(scene, "cycles") else 1.0


def _surface(
    geometry: MeshExport, materials: MaterialExport, aovs: AovExport
) -> SurfaceData | None:
    """What the programs of the scene's materials ask for; None where no material needs one."""
    if not any((*materials.programs, *materials.displacements)) and not aovs.aovs:
        return None
    requests = tuple(a | b for a, b in zip(materials.requests, aovs.requests, strict=True))
    return surface_data(geometry.inventory, geometry.mesh, geometry.kept, requests)


def _shaders(
    geometry: MeshExport,
    materials: MaterialExport,
    aovs: AovExport,
    surface: SurfaceData | None,
    near_distance: float,
) -> Shaders | None:
    """The programs of the scene's materials; None where no material needs one."""
    if not any(materials.programs) and not aovs.aovs:
        return None
    return Shaders(
        programs=materials.programs,
        surface=surface,
        material_pass_index=materials.pass_index,
        aovs=aovs.aovs,
        one_more=bpy.app.version < (5, 0),
        near_distance=near_distance,
        rest=geometry.rest,
    )
