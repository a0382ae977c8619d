"""What an object shows, as a part of the scene: its mesh, points, curves, or the hair on it."""

from __future__ import annotations

from .adaptive import Dicing
from .diced_mesh import DicedSource, read_diced
from .hair_curves import CurveValues, are_polylines, curve_slots, curve_strands
from .local_mesh import LiveMeshes, LocalMesh, read_mesh
from .particle_hair import ParticleHair
from .point_cloud import PointSource, read_point_cloud
from .strands import StrandSource, make_part, strand_settings

# Types of objects that are parts.
WITH_SURFACE = ("MESH", "CURVES", "POINTCLOUD")


class PartReader:
    """Reads parts while the graph lives.

    known: as for read_mesh; live: parts that need not be read, in a window
    dicing: None: meshes are taken as their modifiers leave them
    """

    def __init__(
        self, depsgraph, known, cancelled, live: LiveMeshes | None, dicing: Dicing | None = None
    ):
        self._known, self._cancelled, self._live = known, cancelled, live
        self._dicing, self.warnings = dicing, []
        self._layer = depsgraph.view_layer_eval
        self._strand_settings = strand_settings(depsgraph.scene_eval)
        self.in_window = depsgraph.mode == "VIEWPORT"

    def read(
        self, obj, owner, modifier=None, lasting=None
    ) -> tuple[LocalMesh | None, object, list]:
        """The part, None if it has no face or the view layer leaves its kind out; its
        source: what surface_data.py reads (a bpy mesh, something with rows() of names, or None);
        the materials of its data.

        owner: the object, or what instances it; modifier: a particle system's, for its hair
        lasting: the object, where obj is what Blender's iterator has in place of it
        """
        if not self._is_wanted(obj, modifier):
            return None, None, []
        if obj.type == "MESH" and modifier is None and obj.data.is_editmode:
            return self._edited(obj)
        if modifier is not None:
            local, source = self._hair(obj, owner, modifier)
        elif obj.type == "CURVES":
            local, source = self._curves(obj, owner)
        elif obj.type == "POINTCLOUD":
            local, source = self._points(obj, owner)
        else:
            local, source = self._mesh(obj, owner, lasting or obj)
        return local, source, list(obj.data.materials)

    def _is_wanted(self, obj, modifier) -> bool:
        """Surfaces and Hair of the view layer's filter; points are neither, as in Cycles."""
        if modifier is not None or obj.type == "CURVES":
            return self._layer.use_strand
        return self._layer.use_solid or obj.type != "MESH"

    def _kept(self, owner, obj, make, *settings):
        if self._live is None:
            return make()
        return self._live.read(owner, obj, obj.data, make, *settings)

    def _edited(self, obj):
        mesh = obj.to_mesh()
        local = read_mesh(mesh, self._known, self._cancelled)
        materials = list(mesh.materials)
        obj.to_mesh_clear()
        return local, None, materials

    def _mesh(self, obj, owner, lasting):
        fineness = None
        if self._dicing is not None and lasting.data.as_pointer() == obj.data.as_pointer():
            fineness = self._dicing.fineness_of(lasting)
        if fineness is None:
            local = self._kept(
                owner, obj, lambda: read_mesh(obj.data, self._known, self._cancelled)
            )
            return local, obj.data
        source, own = DicedSource(lasting), (self._dicing, self._known, self._cancelled)
        local = self._kept(
            owner,
            obj,
            lambda: read_diced(lasting, source, fineness, *own, self.warnings),
            fineness,
        )
        return local, source

    def _points(self, obj, owner):
        local = self._kept(owner, obj, lambda: read_point_cloud(obj.name, obj.data, self._known))
        return local, PointSource(obj.data)

    def _curves(self, obj, owner):
        data, settings = obj.data, self._strand_settings
        if are_polylines(data):
            settings = settings._replace(straight=True)
        strands = curve_strands(data)
        part = self._kept(
            owner,
            obj,
            lambda: make_part(obj.name, strands, settings, curve_slots(data), self._known),
            settings,
        )
        return part.local, StrandSource(strands, part.shape, CurveValues(data, strands))

    def _hair(self, obj, owner, modifier):
        hair, settings = ParticleHair(obj, modifier, self.in_window), self._strand_settings
        part = self._kept(
            owner,
            obj,
            lambda: make_part(obj.name, hair.read(), settings, None, self._known),
            settings,
            hair.key(),
        )
        hair.take(part.strands)
        return part.local, StrandSource(part.strands, part.shape, hair.values)
