"""What Blender 5 has trees do beside linking nodes: zones, closures, bundles, menus."""

import bpy

from .cases import lit, shown
from .scene import Tree, find_socket


def _repeated(tree, inside, iterations=3, kind="FLOAT", start=None):
    """A zone's result; inside(tree, iteration, value) is what each round makes of a value."""
    begin, end = tree.node("GeometryNodeRepeatInput"), tree.node("GeometryNodeRepeatOutput")
    begin.pair_with_output(end)
    end.repeat_items.clear()
    end.repeat_items.new(kind, "Value")
    tree.link(iterations, begin.inputs["Iterations"])
    if start is not None:
        tree.link(start, begin.inputs["Value"])
    value = inside(tree, begin.outputs["Iteration"], begin.outputs["Value"])
    tree.link(value, end.inputs["Value"])
    return end.outputs["Value"]


def _rings(tree):
    def inside(tree, iteration, value):
        moved = tree.made("ShaderNodeMath", 0, {0: value, 1: iteration}, operation="ADD")
        return tree.made("ShaderNodeMath", 0, {0: moved, 1: 0.5}, operation="MULTIPLY")

    return _repeated(tree, inside, 4, start=tree.axis("X"))


def _rounds_of_noise(tree):
    def inside(tree, iteration, value):
        place = tree.made("ShaderNodeVectorMath", 0, {0: value, 1: (0.1, 0.2, 0.3)})
        noise = tree.made("ShaderNodeTexNoise", "Color", {"Vector": place, "Scale": 1.5})
        return tree.made("ShaderNodeVectorMath", 0, {0: value, 1: noise})

    return _repeated(tree, inside, 2, "VECTOR", tree.coordinates())


def _no_round(tree):
    return _repeated(tree, lambda tree, iteration, value: 5.0, 0, start=tree.axis("Z"))


def _closure(tree):
    """One closure, evaluated for two values."""
    begin, end = tree.node("NodeClosureInput"), tree.node("NodeClosureOutput")
    begin.pair_with_output(end)
    end.input_items.new("FLOAT", "X")
    end.output_items.new("FLOAT", "Y")
    made = tree.made("ShaderNodeMath", 0, {0: begin.outputs["X"]}, operation="SINE")
    tree.link(made, end.inputs["Y"])
    found = []
    for axis in "XZ":
        asked = tree.node("NodeEvaluateClosure")
        asked.input_items.new("FLOAT", "X")
        asked.output_items.new("FLOAT", "Y")
        tree.tree.links.new(end.outputs["Closure"], asked.inputs["Closure"])
        tree.link(tree.axis(axis, 0.0, 3.0), asked.inputs["X"])
        found.append(asked.outputs["Y"])
    return tree.made("ShaderNodeCombineXYZ", 0, dict(enumerate(found)))


def _bundle(tree):
    put, taken = tree.node("NodeCombineBundle"), tree.node("NodeSeparateBundle")
    for node in (put, taken):
        node.bundle_items.new("RGBA", "A")
        node.bundle_items.new("FLOAT", "B")
    tree.link(tree.color(), put.inputs["A"])
    tree.link(tree.axis("Z", 0.5, 2.0), put.inputs["B"])
    tree.link(put.outputs["Bundle"], taken.inputs["Bundle"])
    inputs = {0: taken.outputs["A"], "Scale": taken.outputs["B"]}
    return tree.made("ShaderNodeVectorMath", 0, inputs, operation="SCALE")


def _group_with_menu(chosen):
    """A group that shows one of two pictures, by a menu of its own."""

    def make(tree):
        inner = bpy.data.node_groups.new("Group", "ShaderNodeTree")
        inner.interface.new_socket("Which", in_out="INPUT", socket_type="NodeSocketMenu")
        inner.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
        own = Tree(inner, "NodeGroupOutput")
        menu = own.node("GeometryNodeMenuSwitch")
        own.link(own.node("NodeGroupInput").outputs["Which"], menu.inputs["Menu"])
        own.link(own.color(), menu.inputs["A"])
        own.link(own.made("ShaderNodeTexChecker", 0, {"Scale": 3.0}), menu.inputs["B"])
        own.link(menu.outputs["Output"], own.output.inputs["Color"])
        group = tree.node("ShaderNodeGroup", node_tree=inner)
        group.inputs["Which"].default_value = chosen
        return group.outputs["Color"]

    return make


def _typed_in(kind, name, value, output):
    def make(tree):
        node = tree.node(kind, **{name: value})
        add = {0: tree.color(), 1: find_socket(node.outputs, output)}
        return tree.made("ShaderNodeVectorMath", 0, add)

    return make


def _time(output):
    def make(tree):
        scene = bpy.context.scene
        scene.render.fps, scene.render.fps_base = 30, 1.001
        scene.render.frame_map_old, scene.render.frame_map_new = 100, 50
        scene.frame_set(2, subframe=0.5)
        inputs = {0: tree.axis("X"), 1: tree.made("GeometryNodeInputSceneTime", output)}
        return tree.made("ShaderNodeMath", 0, inputs, operation="MULTIPLY")

    return make


def _menu_of_shaders(tree):
    menu = tree.node("GeometryNodeMenuSwitch", data_type="SHADER")
    tree.link(tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": tree.color()}), menu.inputs["A"])
    tree.link(tree.made("ShaderNodeBsdfGlossy", 0, {"Roughness": 0.3}), menu.inputs["B"])
    menu.inputs["Menu"].default_value = "B"
    return menu.outputs["Output"]


# Of numbers that are typed in: Blender works them out before Cycles sees them.
_CONSTANTS = {
    "power of 0": ("ShaderNodeMath", "POWER", (0.0, -2.0)),
    "divided vector": ("ShaderNodeVectorMath", "DIVIDE", ((1.0, 2.0, 3.0), (0.0, 1.0, 2.0))),
}


def _worked_out(kind, operation, numbers):
    def make(tree):
        value = tree.made(kind, 0, dict(enumerate(numbers)), operation=operation)
        least = tree.made("ShaderNodeClamp", 0, {"Value": value, "Min": -50.0, "Max": 50.0})
        return tree.made("ShaderNodeMath", 0, {0: least, 1: tree.axis("X")}, operation="ADD")

    return make


def _gamma_of_0(tree):
    dark = tree.made("ShaderNodeGamma", 0, {"Color": (0.0, 0.5, 1.0), "Gamma": 0.0})
    return tree.made("ShaderNodeVectorMath", 0, {0: dark, 1: tree.color()})


for _name, _made_of in _CONSTANTS.items():
    shown(f"Constant {_name}", _worked_out(*_made_of))
shown("Constant Gamma 0 of 0", _gamma_of_0)

if bpy.app.version >= (5, 0):
    shown("Repeat zone", _rings)
    shown("Repeat zone of noises", _rounds_of_noise)
    shown("Repeat zone, no round", _no_round)
    shown("Closure, evaluated twice", _closure)
    shown("Bundle", _bundle)
    shown("Menu of a group, first", _group_with_menu("A"))
    shown("Menu of a group, second", _group_with_menu("B"))
    shown("Integer", _typed_in("FunctionNodeInputInt", "integer", 2, "Integer"))
    shown("Boolean", _typed_in("FunctionNodeInputBool", "boolean", True, "Boolean"))
    shown("Vector", _typed_in("FunctionNodeInputVector", "vector", (0.1, 0.5, 0.2), "Vector"))
    shown("Scene Time, frame", _time("Frame"))
    shown("Scene Time, seconds", _time("Seconds"))
    lit("Menu of shaders", _menu_of_shaders)
