"""Geometry node trees, written down as a chain of calls."""

import bpy


class Graph:
    """A geometry node tree under construction: each method adds a node and returns its output."""

    def __init__(self, name):
        self.tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
        self.tree.is_modifier = True
        for direction in ("INPUT", "OUTPUT"):
            self.tree.interface.new_socket(
                name="Geometry", in_out=direction, socket_type="NodeSocketGeometry"
            )
        self.input = self._add("NodeGroupInput").outputs[0]

    def _add(self, kind, **links):
        node = self.tree.nodes.new(kind)
        node.location = (220 * len(self.tree.nodes), -140 * (len(self.tree.nodes) % 2))
        for socket, value in links.items():
            self._set(node.inputs[socket.replace("_", " ")], value)
        return node

    def _set(self, socket, value):
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = value

    def random_vector(self, low, high, *, seed):
        """A vector for each element, each coordinate between those of low and high."""
        node = self._add("FunctionNodeRandomValue", Seed=seed)
        node.data_type = "FLOAT_VECTOR"
        self._set(node.inputs[0], low)
        self._set(node.inputs[1], high)
        return node.outputs[0]

    def random_float(self, low, high, *, seed):
        """A number for each element, between low and high."""
        node = self._add("FunctionNodeRandomValue", Seed=seed)
        self._set(node.inputs[2], low)
        self._set(node.inputs[3], high)
        return node.outputs[1]

    def scatter(self, surface, density, *, seed):
        """Random points on `surface`, density of them a square metre."""
        node = self._add("GeometryNodeDistributePointsOnFaces", Mesh=surface, Seed=seed)
        self._set(node.inputs["Density"], density)
        return node.outputs["Points"]

    def instance(self, points, source, rotation, scale):
        """The object `source` at each of `points`, turned and scaled."""
        picked = self._add("GeometryNodeObjectInfo", Object=source)
        node = self._add(
            "GeometryNodeInstanceOnPoints",
            Points=points,
            Instance=picked.outputs["Geometry"],
            Rotation=rotation,
            Scale=scale,
        )
        return node.outputs[0]

    def attach(self, shape, geometry):
        """End the tree with `geometry` and make it a modifier of `shape`."""
        self._add("NodeGroupOutput", Geometry=geometry)
        shape.modifiers.new(self.tree.name, "NODES").node_group = self.tree
