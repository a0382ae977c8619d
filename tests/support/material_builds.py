"""Materials made node by node in the open file, and the rows that the exporter makes of them."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export.shaders.material import export_materials, export_shaders


class Build:
    """A new material and its nodes."""

    def __init__(self, name="M"):
        self.material = bpy.data.materials.new(name)
        if bpy.app.version < (5, 0):
            self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        self.output = self.node("ShaderNodeOutputMaterial", name="Out")

    def node(self, kind, name=None, tree=None, links=(), **values):
        """A node; values of inputs and properties by name, spaces as _; links: (input, output)."""
        node = (tree or self.tree).nodes.new(kind)
        node.name = name or node.name
        for key, value in values.items():
            socket = node.inputs.get(key.replace("_", " "))
            if socket is None:
                setattr(node, key, value)
            else:
                socket.default_value = value
        for socket, output in links:
            self.link(output, node.inputs[socket], tree)
        return node

    def link(self, output, socket, tree=None):
        (tree or self.tree).links.new(output, socket)

    def surface(self, node):
        self.link(node.outputs[0], self.output.inputs["Surface"])
        return self


def exported(*materials):
    """Rows of the table as dicts, and the warnings."""
    warnings = []
    params, index = export_materials([getattr(m, "material", m) for m in materials], warnings)
    assert index.dtype == np.float32 and index.shape == (len(materials),)
    for column in params:
        assert column.flags.c_contiguous and len(column) == len(materials)
    rows = [
        {name: column[i].tolist() for name, column in params._asdict().items()}
        for i in range(len(materials))
    ]
    return rows, warnings


def only(build):
    """The one row and its warnings."""
    rows, warnings = exported(build)
    return rows[0], warnings


def about(values):
    return pytest.approx(values, rel=1e-6)  # float32


def program_of(build):
    """The one program, or None."""
    return export_shaders([build.material], []).programs[0]
