"""No choice that Blender has for a node ends a render: each is run, in a material and a world."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export.images import sky
from iwis.iwis_addon.export.worlds import world_picture
from support.material_builds import Build, only
from support.world_render import add, link, new_world, read

KINDS = sorted(
    kind for kind in dir(bpy.types) if kind.startswith("ShaderNode") and kind != "ShaderNodeTree"
)


def _choices(kind) -> list[tuple]:
    """(property, value) of all that a node's lists and switches can be, but for its defaults."""
    common = bpy.types.ShaderNode.bl_rna.properties
    own = [p for p in getattr(bpy.types, kind).bl_rna.properties if p.identifier not in common]
    found = []
    for p in own:
        if p.type == "ENUM" and not p.is_enum_flag and not p.is_readonly:
            others = (item.identifier for item in p.enum_items if item.identifier != p.default)
            found += [(p.identifier, value) for value in others]
        elif p.type == "BOOLEAN" and not p.is_array and not p.is_readonly:
            found.append((p.identifier, not p.default))
    return found


def _chosen(nodes, kind, name, value):
    """A node with a choice, and its outputs that are values; None where it cannot be had."""
    try:
        node = nodes.new(kind)
        setattr(node, name, value)
    except (RuntimeError, TypeError):
        return None, []
    return node, [s for s in node.outputs if s.enabled and s.type in ("VALUE", "VECTOR", "RGBA")]


@pytest.mark.parametrize("kind", [kind for kind in KINDS if _choices(kind)])
def test_materials_know_every_choice(scene, kind):
    """The mean of a colour that varies by it is a number."""
    for name, value in _choices(kind):
        build = Build()
        _, outputs = _chosen(build.tree.nodes, kind, name, value)
        wave = build.node("ShaderNodeTexWave") if outputs else None
        for output in outputs:
            links = [(0, wave.outputs[0]), (1, output)]
            added = build.node("ShaderNodeVectorMath", links=links)
            diffuse = build.node("ShaderNodeBsdfDiffuse", links=[("Color", added.outputs[0])])
            row, _ = only(build.surface(diffuse))
            assert np.isfinite(row["base_color"]).all(), (name, value, output.name)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if _choices(kind)])
def test_worlds_know_every_choice(scene, monkeypatch, kind):
    """Light that is a number in all directions. Skies are not rendered, which takes a process."""
    monkeypatch.setattr(world_picture, "LEAST_HEIGHT", 8)
    monkeypatch.setattr(sky, "_LAST", {})
    monkeypatch.setattr(sky, "render_sky", lambda *_: np.ones((8, 16, 3), np.float32))
    for name, value in _choices(kind):
        tree = new_world(scene)
        background = add(tree, "Background")
        link(tree, background, add(tree, "OutputWorld"))
        _, outputs = _chosen(tree.nodes, kind, name, value)
        for output in outputs:
            tree.links.new(output, background.inputs["Color"])
            world, _ = read()
            assert np.isfinite(world.light.radiance).all(), (name, value, output.name)
