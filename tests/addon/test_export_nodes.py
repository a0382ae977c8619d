"""Nodes that read data-blocks, and nodes with nothing linked to them."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export.shaders.program_nodes import HANDLERS, SETTINGS
from support.material_builds import Build, only


@pytest.fixture
def build(scene):
    return Build()


def _outputs():
    """(kind, number) of all outputs of supported nodes that have a value."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    nodes = bpy.data.node_groups.new("all", "ShaderNodeTree").nodes
    for kind in sorted({*SETTINGS, *HANDLERS}):
        if kind.startswith("ShaderNode") and hasattr(bpy.types, kind):
            for k, socket in enumerate(nodes.new(kind).outputs):
                if socket.enabled and socket.type in ("VALUE", "VECTOR", "RGBA"):
                    yield kind, k


@pytest.mark.parametrize("attribute", ("GEOMETRY", "OBJECT", "INSTANCER", "VIEW_LAYER"))
def test_attribute_of_everything_is_exported(build, attribute):
    node = build.node("ShaderNodeAttribute")
    node.attribute_type, node.attribute_name = attribute, "number"
    diffuse = build.node("ShaderNodeBsdfDiffuse", links=[("Color", node.outputs[0])])
    row, warnings = only(build.surface(diffuse))
    assert warnings == [] and np.isfinite(row["base_color"]).all()


def test_nodes_with_nothing_linked_have_a_value(build):
    """Every output of every node: a row of means is worked out of each, by running it."""
    for kind, k in _outputs():
        build = Build()
        wave = build.node("ShaderNodeTexWave")
        added = build.node("ShaderNodeVectorMath", links=[(0, wave.outputs[0])])
        build.link(build.node(kind).outputs[k], added.inputs[1])
        diffuse = build.node("ShaderNodeBsdfDiffuse", links=[("Color", added.outputs[0])])
        row, _ = only(build.surface(diffuse))
        assert np.isfinite(row["base_color"]).all(), (kind, k)
