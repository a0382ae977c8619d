"""Value nodes of one material's tree to operations of a core.data.program.Program.

Links are followed through reroutes, muted nodes and groups (node_values.follow). What does not
depend on the point is computed at once, so that a constant stays a constant however it is made.
"""

from __future__ import annotations

import bpy
import numpy as np

from ....core.data.program import Op, Program, Ref, Value
from ....core.data.program_ops import PURE
from ....core.nodes import FUNCTIONS
from ....core.nodes.wireframe import OF_ELEMENTS
from ..images.color_spaces import luminance_of_channels
from ..objects.origins import ORIGIN, PARTICLE
from .node_values import NodeReader, follow
from .program_nodes import HANDLERS, SETTINGS
from .seen_tree import name_of

_TYPES = {
    "VALUE": "NUMBER",
    "INT": "NUMBER",
    "BOOLEAN": "NUMBER",
    "VECTOR": "VECTOR",
    "ROTATION": "VECTOR",
    "RGBA": "COLOR",
}
_ZERO = np.float32(0.0)
# Nodes that give something else in Blender 4.5.
_OF_VERSIONS = "ShaderNodeTexVoronoi", "ShaderNodeMath", "ShaderNodeVectorMath"
# Nodes that tell of strands, points or a mesh's shape -> output -> the values that it needs
# (element_values.py), where that is not the one of its name.
_ELEMENTS = {
    "ShaderNodeHairInfo": {"Tangent Normal": ("Tangent",)},
    "ShaderNodePointInfo": {"Position": ("Position", "Radius")},
    "ShaderNodeWireframe": {"Fac": OF_ELEMENTS},
}
_OF_THE_SHAPE = ("Pointiness", "Random Per Island")


def constant_of(socket) -> np.ndarray | None:
    """float32 () or (3,) of a socket's own value; None if it has none."""
    value = getattr(socket, "default_value", None)
    if isinstance(value, (bool, int, float)):
        return np.float32(value)
    try:
        return np.array(value[:3], np.float32)
    except TypeError:
        return None


class ProgramBuilder:
    """The operations of one material, as far as they have been asked for.

    depsgraph: or a scene, whose time nodes ask for; None: no node may
    requests: names of the mesh data that they need (surface_data.py)
    displaced: the normal that displacement leaves, a vector; None: the surface's own
    of_instances: whether nodes may ask how an instance was made
    """

    of_instances = True

    def __init__(self, reader: NodeReader, images, depsgraph=None):
        self.reader, self.images, self.depsgraph = reader, images, depsgraph
        self.requests: set[str] = set()
        self.displaced: Value | None = None
        self._ops: list[Op] = []
        self._known: dict[tuple, int] = {}

    @property
    def scene(self):
        """The evaluated scene, or None."""
        return getattr(self.depsgraph, "scene_eval", self.depsgraph)

    @property
    def ops(self) -> tuple[Op, ...]:
        return tuple(self._ops)

    def number(self, node, name: str, groups) -> Value:
        """What feeds an input, as a number."""
        return self.behind(node.inputs[name], groups, "NUMBER")

    def color(self, node, name: str, groups) -> Value:
        """What feeds an input, as a colour."""
        return self.behind(node.inputs[name], groups, "COLOR")

    def vector(self, node, name: str, groups) -> Value:
        """What feeds an input, as a vector."""
        return self.behind(node.inputs[name], groups, "VECTOR")

    def vector_if_linked(self, node, name: str, groups) -> Value | None:
        """What feeds an input; None where nothing is linked."""
        return self._if_linked(node, name, groups, "VECTOR")

    def number_if_linked(self, node, name: str, groups) -> Value | None:
        """The same, as a number."""
        return self._if_linked(node, name, groups, "NUMBER")

    def _if_linked(self, node, name, groups, target):
        if name not in node.inputs or follow(node.inputs[name], groups).node is None:
            return None
        return self.behind(node.inputs[name], groups, target)

    def normal(self, node, name: str, groups) -> Value | None:
        """What feeds a normal; else the displaced one; None: the surface's own."""
        found = self.vector_if_linked(node, name, groups)
        return self.displaced if found is None else found

    def of_origin(self, name: str) -> Value:
        """A vector that an instance has of its instancer."""
        settings = {"table": f"{ORIGIN}:{name}", "outputs": set()}
        self.requests.add(settings["table"])
        return Ref(self.add_node(None, (), "object_attribute", {}, settings), "Vector")

    def run(self, kind: str, output: str = "", **settings_and_inputs) -> Value:
        """An operation of our own, one that no node stands for."""
        settings = settings_and_inputs.pop("settings", {})
        return self._add(kind, settings_and_inputs, settings, output)

    def default_tangent(self) -> Value:
        """The Geometry node's Tangent, which Cycles takes where nothing is linked."""
        self.requests.add("generated")
        kind, settings = "ShaderNodeNewGeometry", {"outputs": {"Tangent"}}
        return Ref(self.add_node(None, (), kind, {}, settings), "Tangent")

    def outwards(self) -> Value:
        """To whoever looks, as a luminaire of a material has it: a normal of the object's space."""
        settings = {"outputs": {"Incoming"}}
        along = self.run_at_points("ShaderNodeNewGeometry", "Incoming", settings=settings)[0]
        settings = {"vector_type": "NORMAL", "convert_from": "WORLD", "convert_to": "OBJECT"}
        settings["outputs"] = {"Vector"}
        kind = "ShaderNodeVectorTransform"
        return self.run_at_points(kind, "Vector", Vector=along, settings=settings)[0]

    def run_at_points(self, kind: str, *outputs: str, **inputs) -> Value | list[Value]:
        """The same, of one that depends on the point even where its inputs do not: its outputs."""
        settings = inputs.pop("settings", {})
        self._ops.append(Op(kind, inputs, settings))
        found = [Ref(len(self._ops) - 1, name) for name in outputs or ("",)]
        return found if outputs else found[0]

    def scaled(self, color: Value, factor: Value) -> Value:
        """Colour times number."""
        return self.run("scale", Color=color, Factor=factor)

    def inputs(self, node, groups) -> dict[str, Value]:
        """All inputs of a node by identifier; normals and places of textures only if linked: else
        they are the surface's own. Sockets that show no value have one all the same."""
        found = {}
        for socket in node.inputs:
            if socket.type not in _TYPES or not (socket.enabled or not socket.is_linked):
                continue
            value = self.behind(socket, groups, _TYPES[socket.type])
            if value is None and not _is_the_surfaces(node, socket):
                value = constant_of(socket)
            if value is not None:
                found[socket.identifier] = value
        return found

    def add_node(self, node, groups, kind: str, inputs, settings) -> int:
        """The operation of a node, once for each place that a group stands in."""
        self._ops.append(Op(kind, inputs, settings))
        return len(self._ops) - 1

    def added(self, values: list[Value]) -> Value | None:
        """The sum of colours; None of none."""
        if len(values) < 2:
            return values[0] if values else None
        return self.run("sum", **{f"{k}": value for k, value in enumerate(values)})

    def mean(self, value: Value) -> np.ndarray:
        """A constant that stands for a value, where only one can be had."""
        from ....core.nodes.typical import mean_value

        return mean_value(Program(ops=self.ops, closures=()), value)

    def behind(self, socket, groups, target) -> Value | None:
        """What feeds a socket, as a target NUMBER, VECTOR or COLOR; None: it has no value."""
        end = follow(socket, groups)
        if end.node is None:
            if socket.hide_value and end.socket is socket:
                return None
            value, source = constant_of(end.socket), _TYPES.get(end.socket.type, target)
            if value is None:
                value, source = constant_of(socket), _TYPES.get(socket.type, target)
            return self._converted(_ZERO if value is None else value, source, target)
        value, source = self._output(end)
        if value is None:
            value, source = constant_of(socket), _TYPES.get(socket.type, target)
            value = _ZERO if value is None else value
            self.reader.warn(
                end.node,
                f'{end.node.bl_label} is not supported: "{socket.name}" of '
                f"{name_of(socket.node)} is {_text(value)}, the value under the link",
            )
        return self._converted(value, source, target)

    def _converted(self, value, source, target):
        if source == target or {source, target} == {"VECTOR", "COLOR"}:
            return value
        settings = {"source": source, "target": target, "luminance": luminance_of_channels()}
        return self.run("convert", Value=value, settings=settings)

    def _output(self, end) -> tuple[Value | None, str]:
        """(value, type) of a node's output; None if the node is not supported."""
        node, name = end.node, end.socket.identifier
        source = _TYPES.get(end.socket.type)
        if node.bl_idname in ("ShaderNodeRGB", "ShaderNodeValue"):
            return constant_of(end.socket), source
        if source is None:
            return None, "NUMBER"
        key = (node.as_pointer(), *(group.as_pointer() for group in end.groups))
        if key not in self._known:
            made = self._made(node, end.groups)
            if made is None:
                return None, source
            self._known[key] = made
        made = self._known[key]
        if isinstance(made, dict):
            return made[name], source
        settings = self._ops[made].settings
        if "outputs" in settings:
            settings["outputs"].add(name)
            self._request(node, name)
        return Ref(made, name), source

    def _request(self, node, output):
        if node.bl_idname == "ShaderNodeTexCoord" and output in ("Generated", "UV"):
            own = {"Generated": "generated", "UV": "uv:"}[output]
            made = node.from_instancer and self.of_instances
            self.requests.add(f"{ORIGIN}:{output}" if made else own)
        elif node.bl_idname == PARTICLE:
            self.requests.add(f"{ORIGIN}:{'Index' if output == 'Random' else output}")
        elif node.bl_idname in _ELEMENTS:
            names = _ELEMENTS[node.bl_idname].get(output, (output,))
            self.requests.update(f"element:{name}" for name in names)
        elif node.bl_idname == "ShaderNodeNewGeometry" and output == "Tangent":
            self.requests.add("generated")
        elif node.bl_idname == "ShaderNodeNewGeometry" and output in _OF_THE_SHAPE:
            self.requests.add(f"element:{output}")

    def _made(self, node, groups):
        """Row of a node's operation, or its constant outputs; None if it is not supported."""
        kind = node.bl_idname
        if kind in HANDLERS:
            return HANDLERS[kind](self, node, groups)
        if kind not in SETTINGS:
            return None
        settings = {name: getattr(node, name) for name in SETTINGS[kind] if hasattr(node, name)}
        if kind in _OF_VERSIONS:  # as Cycles of this version
            settings["before"] = bpy.app.version < (5, 0)
        if kind == "ShaderNodeRGBToBW":
            settings["luminance"] = luminance_of_channels()
        if kind == "ShaderNodeTexMagic":
            settings["scaled_first"] = bpy.app.version >= (5, 0)
        if kind not in PURE:
            settings["outputs"] = set()
        inputs = self.inputs(node, groups)
        if "TEX_" in node.type and "Vector" not in inputs:
            self.requests.add("generated")
        if kind == "ShaderNodeBump" and self.displaced is not None:
            inputs.setdefault("Normal", self.displaced)
        if kind in PURE and not any(isinstance(value, Ref) for value in inputs.values()):
            with np.errstate(all="ignore"):
                return FUNCTIONS[kind](None, settings, inputs)
        return self.add_node(node, groups, kind, inputs, settings)

    def _add(self, kind, inputs, settings, output) -> Value:
        if not any(isinstance(value, Ref) for value in inputs.values()):
            return np.asarray(FUNCTIONS[kind](None, settings, inputs)[output], np.float32)
        self._ops.append(Op(kind, inputs, settings))
        return Ref(len(self._ops) - 1, output)


def _is_the_surfaces(node, socket) -> bool:
    """Whether an input of which nothing is told is the surface's normal, or a place on it."""
    if socket.identifier == "Vector":  # of white noise: 0, as in Cycles
        return "TEX_" in node.type and node.type != "TEX_WHITE_NOISE"
    return socket.identifier == "Normal"


def _text(value) -> str:
    if np.ndim(value) == 0:
        return f"{value:.3g}"
    return "(" + ", ".join(f"{c:.3g}" for c in value) + ")"
