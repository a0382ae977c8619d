"""Light linking: which objects lamps and shining meshes light, and which throw their shadows."""

from __future__ import annotations

import bpy

from .cases import lit_by
from .emitter_cases import glowing_plane
from .lamp_cases import add_lamp, matte, shiny


def collection(name, objects=(), state="INCLUDE", children=(), child_state="INCLUDE"):
    """A collection for links, of objects by name and of collections, each with one state."""
    made = bpy.data.collections.new(name)
    for own in objects:
        made.objects.link(bpy.data.objects[own])
    for child in children:
        made.children.link(child)
    for item in made.collection_objects:
        item.light_linking.link_state = state
    for item in made.collection_children:
        item.light_linking.link_state = child_state
    return made


def _area(scene):
    add_lamp(scene, "AREA", (1.5, -2.0, 3.0), energy=150.0, size=0.6)
    return bpy.data.objects["Lamp"]


def _shining(scene):
    return glowing_plane(scene)


def _case(name, link, light=_area, make=matte, world=False, **options):
    """link(obj, linking) sets the links of the object that shines."""

    def build(scene, tree):
        tree.surface(make(tree))
        obj = light(scene)
        link(obj, obj.light_linking)

    lit_by(f"Linking: {name}", build, world=world, **options)


def _receive(*args, **options):
    return lambda _, linking: setattr(
        linking, "receiver_collection", collection("R", *args, **options)
    )


def _block(*args, **options):
    return lambda _, linking: setattr(
        linking, "blocker_collection", collection("B", *args, **options)
    )


def _mixed(_, linking):
    linking.receiver_collection = collection("R", ("Sphere", "Plane"))
    linking.receiver_collection.collection_objects[1].light_linking.link_state = "EXCLUDE"


def _child(_, linking):
    child = collection("Child", ("Cube",), "EXCLUDE")  # which says nothing in a child
    linking.receiver_collection = collection("R", ("Plane",), children=(child,))


def _children(_, linking):
    inner = collection("Inner", ("Sphere",))
    outer = collection("Outer", children=(inner,))
    linking.receiver_collection = collection("R", children=(outer,), child_state="EXCLUDE")


def _both(_, linking):
    linking.receiver_collection = collection("R", ("Cube",), "EXCLUDE")
    linking.blocker_collection = collection("B", ("Sphere",))


def _of_copies(receiver):
    """Copies of the sphere, linked by themselves or by the empty that makes them."""

    def link(obj, linking):
        sphere, scene = bpy.data.objects["Sphere"], bpy.context.scene
        own = bpy.data.collections.new("Own")
        own.objects.link(sphere)
        scene.collection.objects.unlink(sphere)
        for k in range(2):
            empty = bpy.data.objects.new(f"Copies {k}", None)
            empty.instance_type, empty.instance_collection = "COLLECTION", own
            empty.location = (0.0, 2.0 * k, 0.0)
            scene.collection.objects.link(empty)
        linking.receiver_collection = collection("R", (receiver, "Plane"))

    return link


def _two(obj, linking):
    linking.receiver_collection = collection("R", ("Sphere", "Plane"))
    linking.blocker_collection = collection("B", ("Cube",))
    other = add_lamp(bpy.context.scene, "POINT", (-2.5, -2.0, 1.5), energy=90.0)
    lamp = next(o for o in bpy.data.objects if o.data == other)
    lamp.light_linking.receiver_collection = collection("R2", ("Sphere",), "EXCLUDE")


def _on_catcher(obj, linking):
    bpy.data.objects["Plane"].is_shadow_catcher = True
    bpy.context.scene.render.film_transparent = True
    linking.blocker_collection = collection("B", ("Sphere", "Plane"))


def _holed(tree):
    """Half of it lets light through, in checks."""
    checks = {"Color1": 1.0, "Color2": 0.0, "Scale": 4.0, "Vector": tree.coordinates()}
    share = tree.made("ShaderNodeTexChecker", 1, checks)
    inputs = {0: share, 1: matte(tree), 2: tree.made("ShaderNodeBsdfTransparent")}
    return tree.made("ShaderNodeMixShader", 0, inputs)


_case("included", _receive(("Sphere", "Plane")))
_case("excluded", _receive(("Sphere", "Plane"), "EXCLUDE"), world=True)
_case("included and excluded", _mixed)
_case("empty collection", _receive())
_case("child collection", _child)
_case("children excluded", _children)
_case("mirrored", _receive(("Sphere",)), make=shiny(0.1), world=True)
_case("blockers", _block(("Sphere",)))
_case("blockers excluded", _block(("Cube",), "EXCLUDE"))
_case("receivers and blockers", _both)
_case("two lamps", _two)
_case("copies by their object", _of_copies("Sphere"))
_case("copies by their empty", _of_copies("Copies 1"))
_case("emissive plane", _receive(("Sphere", "Plane")), light=_shining)
_case("emissive plane, blockers", _block(("Sphere",), "EXCLUDE"), light=_shining)
_case("emissive plane, shiny", _receive(("Cube",), "EXCLUDE"), light=_shining, make=shiny(0.1))
_case("catcher", _on_catcher, with_alpha=True, blurred=True)
_case("holes, blockers", _block(("Cube",), "EXCLUDE"), make=_holed, blurred=True)
