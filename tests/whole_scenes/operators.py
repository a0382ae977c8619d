"""Every operator that adds geometry or another kind of object, with its own defaults."""

from __future__ import annotations

import bpy

from .stage import Missing, Whole, add_surface, stage

# Operators by what they add; with the values of the property that chooses a kind.
_PLAIN = {
    "mesh": [
        f"mesh.primitive_{kind}_add"
        for kind in "plane cube circle uv_sphere ico_sphere cylinder cone torus grid monkey".split()
    ],
    "curve": [
        f"curve.primitive_{kind}_add"
        for kind in "bezier_curve bezier_circle nurbs_curve nurbs_circle nurbs_path".split()
    ],
    "surface": [
        f"surface.primitive_nurbs_surface_{kind}_add"
        for kind in "curve circle surface cylinder sphere torus".split()
    ],
    "object": [
        f"object.{kind}_add"
        for kind in "text armature camera speaker volume curves_random pointcloud_random".split()
    ],
}
_KINDS = {
    "object.metaball_add": "BALL CAPSULE PLANE ELLIPSOID CUBE",
    "object.grease_pencil_add": "EMPTY STROKE MONKEY",
    "object.light_add": "POINT SUN SPOT AREA",
    "object.lightprobe_add": "SPHERE PLANE VOLUME",
    "object.empty_add": "PLAIN_AXES ARROWS SINGLE_ARROW CIRCLE CUBE SPHERE CONE IMAGE",
    "object.effector_add": "FORCE WIND VORTEX MAGNET HARMONIC CHARGE LENNARDJ TEXTURE GUIDE BOID "
    "TURBULENCE DRAG FLUID",
    "object.add": "LATTICE",
}
# Operators that turn what is there into something else.
_QUICK = ("object.quick_fur", "object.quick_explode", "object.quick_smoke", "object.quick_liquid")


def _operator(path):
    group, name = path.split(".")
    found = getattr(getattr(bpy.ops, group), name)
    try:
        found.get_rna_type()
    except KeyError:
        raise Missing(f"{path} is not in this Blender") from None
    return found


def _added(path, **options):
    def build():
        _, material = stage()
        _operator(path)(**options)
        obj = bpy.context.object
        if hasattr(obj.data, "materials"):
            obj.data.materials.append(material)

    return build


def _bevelled(path):
    def build():
        _added(path)()
        bpy.context.object.data.bevel_depth = 0.1

    return build


def _quick(path):
    def build():
        _, material = stage()
        add_surface(material)
        _operator(path)()

    return build


def scenes() -> list[Whole]:
    found = [Whole("operator", path, _added(path)) for paths in _PLAIN.values() for path in paths]
    found += [Whole("operator", f"{path}, bevel", _bevelled(path)) for path in _PLAIN["curve"]]
    for path, kinds in _KINDS.items():
        found += [
            Whole("operator", f"{path} {kind}", _added(path, type=kind)) for kind in kinds.split()
        ]
    return found + [Whole("operator", path, _quick(path)) for path in _QUICK]
