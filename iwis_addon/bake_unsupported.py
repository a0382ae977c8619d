"""What IWIS does not know of a material, baked to images by Cycles and put in its place."""

from __future__ import annotations

import contextlib
from typing import NamedTuple

import bpy

from .callbacks import end_previews
from .unsupported import Unsupported, unsupported_of

_HALF = (0.5, 0.5, 0.5)


class BakeReport(NamedTuple):
    """done, problems: a line each, with object, material and node."""

    done: list[str]
    problems: list[str]


def bake_unsupported(context, size: int = 1024, samples: int = 16) -> BakeReport:
    """Bake each output that the export warns of, for all mesh objects of a context's view layer.

    size: pixels of each image's side; samples: of each pixel. A material of several objects is
    copied, as what is baked belongs to one object. The old nodes stay, without their links.
    Raises ValueError without Cycles or outside Object Mode.
    """
    scene = context.scene
    if not hasattr(scene, "cycles"):
        raise ValueError("Cycles is disabled: enable it in Preferences, Add-ons, to bake")
    if context.mode != "OBJECT":
        raise ValueError("baking needs Object Mode: leave the mode that you are in")
    report = BakeReport([], [])
    seen: set = set()
    with _baking(context, samples):
        for obj in [o for o in context.view_layer.objects if not o.hide_render]:
            for slot in obj.material_slots:
                if unsupported_of(slot.material):
                    _bake_slot(context, obj, slot, size, report, seen)
    return report


def _bake_slot(context, obj, slot, size, report, seen):
    """Bake what one slot's material needs."""
    where = f'object "{obj.name}", material "{slot.material.name}"'
    problem = _problem_of(context, obj, slot)
    if problem:
        report.problems.append(f"{where}: {problem}")
        return
    can = not all(what.groups for what in unsupported_of(slot.material))
    if can and (slot.material in seen or _is_shared(context, obj, slot.material)):
        copy = slot.material.copy()
        slot.link, slot.material = "OBJECT", copy
        where = f'object "{obj.name}", material "{copy.name}"'
    seen.add(slot.material)
    for what in unsupported_of(slot.material):
        line = f'{where}, node "{what.node.name}"'
        if what.groups:
            group = what.groups[-1].node_tree.name
            report.problems.append(f'{line}: it lies in the node group "{group}": ungroup it first')
            continue
        try:
            image = _bake(context, obj, what, size)
        except RuntimeError as error:
            report.problems.append(f"{line}: Cycles could not bake it: {str(error).strip()}")
            continue
        report.done.append(f'{line}: is now the image "{image.name}", packed')


def _problem_of(context, obj, slot) -> str:
    """Why a slot cannot be baked; "" where it can."""
    if obj.type != "MESH":
        return f"a {obj.type.lower()} has no UV map to bake to: convert it to a mesh first"
    if not obj.data.uv_layers:
        return "the object has no UV map: unwrap it (UV > Smart UV Project), then bake again"
    if slot.material.library or slot.material.override_library or obj.library:
        return "it is linked from another file and cannot be changed: make it local first"
    if not obj.visible_get(view_layer=context.view_layer):
        return "the object is hidden in the view, and Cycles bakes only what it sees: show it"
    if any(other.material is None for other in obj.material_slots):
        return "a material slot is empty, which Cycles cannot bake: remove it, or fill it"
    return ""


def _is_shared(context, obj, material) -> bool:
    others = (o for o in context.scene.objects if o is not obj)
    return any(slot.material == material for o in others for slot in o.material_slots)


def _bake(context, obj, what: Unsupported, size: int):
    """The image of an output over an object's UV map, linked in the output's place."""
    tree, output = what.material.node_tree, _output_of(what)
    name = f"{what.material.name} {what.node.name}"
    image = bpy.data.images.new(name, size, size, alpha=False, float_buffer=True)
    with contextlib.ExitStack() as stack:
        for material in {slot.material for slot in obj.material_slots}:
            own = image if material == what.material else None
            stack.enter_context(_target(material, own))
        stack.enter_context(_shown(what.material, output))
        _only_selected(context, obj)
        try:
            bpy.ops.object.bake(type="EMIT", use_clear=True, margin=8, save_mode="INTERNAL")
        except RuntimeError:
            bpy.data.images.remove(image)
            raise
    image.pack()
    _put_in_place(tree, what.node, output, image, obj.data.uv_layers.active.name)
    return image


def _output_of(what: Unsupported):
    return next(s for s in what.node.outputs if s.identifier == what.output)


@contextlib.contextmanager
def _target(material, image):
    """A material's active node shows where to bake to, a scratch image for what is not wanted."""
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    nodes = material.node_tree.nodes
    active, scratch = nodes.active, None
    if image is None:
        image = scratch = bpy.data.images.new("IWIS Scratch", 8, 8, float_buffer=True)
    node = nodes.new("ShaderNodeTexImage")
    node.image, nodes.active = image, node
    try:
        yield
    finally:
        nodes.remove(node)
        nodes.active = active
        if scratch is not None:
            bpy.data.images.remove(scratch)


@contextlib.contextmanager
def _shown(material, output):
    """The material emits what an output gives; a vector's -1 ... 1 as 0 ... 1."""
    tree = material.node_tree
    surface = tree.get_output_node("CYCLES").inputs["Surface"]
    before = [link.from_socket for link in surface.links]
    emission = tree.nodes.new("ShaderNodeEmission")
    made = [emission]
    if output.type == "VECTOR":
        made.append(_scaled(tree, output, _HALF, _HALF))
        output = made[-1].outputs[0]
    tree.links.new(output, emission.inputs["Color"])
    tree.links.new(emission.outputs[0], surface)
    try:
        yield
    finally:
        for node in made:
            tree.nodes.remove(node)
        for socket in before:
            tree.links.new(socket, surface)


def _scaled(tree, output, factor, offset):
    """A node of a vector times a factor, and an offset."""
    node = tree.nodes.new("ShaderNodeVectorMath")
    node.operation = "MULTIPLY_ADD"
    node.inputs[1].default_value, node.inputs[2].default_value = factor, offset
    tree.links.new(output, node.inputs[0])
    return node


def _put_in_place(tree, node, output, image, uv_map):
    """What the output fed is fed by the image."""
    coordinates, texture = tree.nodes.new("ShaderNodeUVMap"), tree.nodes.new("ShaderNodeTexImage")
    coordinates.uv_map, texture.image = uv_map, image
    x, y = node.location
    texture.location, coordinates.location = (x, y - 320.0), (x - 200.0, y - 320.0)
    texture.label = f"Baked {node.name}"
    tree.links.new(coordinates.outputs[0], texture.inputs["Vector"])
    source = texture.outputs["Color"]
    if output.type == "VECTOR":
        source = _scaled(tree, source, (2.0,) * 3, (-1.0,) * 3).outputs[0]
    for target in [link.to_socket for link in output.links]:
        tree.links.new(source, target)


def _only_selected(context, obj):
    for other in context.view_layer.objects:
        other.select_set(other == obj, view_layer=context.view_layer)
    context.view_layer.objects.active = obj


@contextlib.contextmanager
def _baking(context, samples):
    """Engine, samples, selection and what a bake asks of a scene; afterwards all as it was."""
    scene, layer = context.scene, context.view_layer
    bake, cycles, render = scene.render.bake, scene.cycles, scene.render
    values = [(render, "engine", "CYCLES"), (cycles, "samples", samples)]
    values += [(cycles, "use_adaptive_sampling", False), (cycles, "device", "CPU")]
    values += [(bake, "use_selected_to_active", False), (bake, "target", "IMAGE_TEXTURES")]
    multires = ((bake, "use_multires"), (render, "use_bake_multires"))  # Blender 5, before
    values += [(owner, name, False) for owner, name in multires if hasattr(owner, name)]
    kept = [(owner, name, getattr(owner, name)) for owner, name, _ in values]
    selected = [obj for obj in layer.objects if obj.select_get(view_layer=layer)]
    active = layer.objects.active
    end_previews()
    try:
        for owner, name, value in values:
            setattr(owner, name, value)
        yield
    finally:
        for owner, name, value in kept:
            setattr(owner, name, value)
        for obj in layer.objects:
            obj.select_set(obj in selected, view_layer=layer)
        layer.objects.active = active
