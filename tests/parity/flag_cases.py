"""What objects, their instancers and their collections are to rays and to the picture."""

from __future__ import annotations

import bpy

from .cases import CASES, Case


def _matte(tree):
    tree.surface(tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.7, 0.6, 0.5)}))


def _case(name, build, transparent=True, blurred=False):
    """build(scene, sphere) changes the scene; the sphere is in a collection of its own."""

    def whole(scene, tree):
        _matte(tree)
        scene.render.film_transparent = transparent
        sphere = bpy.data.objects["Sphere"]
        collection = bpy.data.collections.new("Own")
        collection.objects.link(sphere)
        scene.collection.objects.unlink(sphere)
        build(scene, sphere)

    CASES.append(Case(f"Flags: {name}", whole, lit=True, blurred=blurred, with_alpha=True))


def _flagged(name, setting, value, of_instancer, **options):
    """A sphere that an empty instances, with a flag of itself or of the empty."""

    def build(scene, sphere):
        empty = bpy.data.objects.new("Instancer", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", bpy.data.collections["Own"]
        scene.collection.objects.link(empty)
        setattr(empty if of_instancer else sphere, setting, value)

    _case(name, build, **options)


def _layered(name, **settings):
    """A sphere whose collection has settings of its own in the view layer."""

    def build(scene, sphere):
        scene.collection.children.link(bpy.data.collections["Own"])
        layer = scene.view_layers[0].layer_collection.children["Own"]
        for key, value in settings.items():
            setattr(layer, key, value)

    _case(name, build)


for _kind, _filter in (("", False), (", filtered", True)):
    _flagged(
        f"holdout in an opaque film{_kind}",
        "is_holdout",
        True,
        of_instancer=True,
        transparent=False,
        blurred=_filter,
    )


def _hole_on_a_catcher(scene, sphere):
    sphere.is_holdout = bpy.data.objects["Plane"].is_shadow_catcher = True
    scene.collection.children.link(bpy.data.collections["Own"])


_case("holdout on a catcher", _hole_on_a_catcher)
_case("holdout on a catcher in an opaque film", _hole_on_a_catcher, transparent=False)


def _hole_that_catches(scene, sphere):
    sphere.is_holdout = sphere.is_shadow_catcher = True
    scene.collection.children.link(bpy.data.collections["Own"])


_case("holdout that is a catcher", _hole_that_catches)
_case("holdout that is a catcher in an opaque film", _hole_that_catches, transparent=False)
_flagged("holdout of an instancer", "is_holdout", True, True)
_flagged("holdout of what is instanced does nothing", "is_holdout", True, False)
_flagged("instancer not seen by the camera", "visible_camera", False, True)
_flagged("what is instanced not seen by the camera", "visible_camera", False, False)
_flagged("instancer catches shadows", "is_shadow_catcher", True, True)
_flagged("what is instanced catches shadows", "is_shadow_catcher", True, False)
_layered("holdout of a collection", holdout=True)
_layered("collection is indirect only", indirect_only=True)
_layered("collection is holdout and indirect only", holdout=True, indirect_only=True)


def _filtered(name, flags, transparent):
    """A view layer without some kinds of things: a plane with hair and points beside the rest."""

    def build(scene, sphere):
        scene.collection.objects.link(sphere)
        bpy.ops.mesh.primitive_plane_add(size=1.0, location=(0.2, -1.5, -0.6))
        bpy.context.object.data.materials.append(bpy.data.materials["M"])
        bpy.context.object.modifiers.new("Hair", "PARTICLE_SYSTEM")
        hair = bpy.context.object.particle_systems[0].settings
        hair.type, hair.count, hair.hair_length, hair.root_radius = "HAIR", 12, 1.2, 20.0
        scene.cycles_curves.shape = "THICK"
        lamp = bpy.data.lights.new("Lamp", "POINT")
        lamp.energy, lamp.shadow_soft_size = 100.0, 0.3
        lamp = bpy.data.objects.new("Lamp", lamp)
        lamp.location = (-2.0, -3.0, 3.0)
        scene.collection.objects.link(lamp)
        for flag in flags:
            setattr(scene.view_layers[0], flag, False)

    _case(f"view layer without {name}", build, transparent=transparent, blurred=True)


for _name, _flags, _film in (
    ("environment", ["use_sky"], False),
    ("environment, transparent", ["use_sky"], True),
    ("surfaces", ["use_solid"], True),
    ("hair", ["use_strand"], True),
):
    _filtered(_name, _flags, _film)
