"""Surfaces that let light through: cut off by the camera's clipping, added to what shows itself."""

import bpy

from .cases import CASES, Case
from .lit_cases import image_of, noise_of
from .scene import Tree

_TINT = (0.9, 0.5, 0.2)


def new_material(make):
    """A new material of the shader make(tree)."""
    material = bpy.data.materials.new("Clear")
    if material.node_tree is None:
        material.use_nodes = True
    tree = Tree(material.node_tree)
    tree.surface(make(tree))
    return material


def _clear(tree, color=(1.0, 1.0, 1.0)):
    return tree.made("ShaderNodeBsdfTransparent", 0, {"Color": color})


def _diffuse(tree, color=(0.2, 0.5, 0.7)):
    return tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": color})


def _glow(tree, strength=0.4):
    return tree.made("ShaderNodeEmission", 0, {"Color": _TINT, "Strength": strength})


def _both(kind, *inputs):
    def make(tree):
        node = tree.node(f"ShaderNode{kind}Shader")
        for value, socket in zip(inputs, node.inputs, strict=True):
            tree.link(value(tree) if callable(value) else value, socket)
        return node.outputs[0]

    return make


def _before_and_behind(make, film, end):
    """A matte scene with a card of make(tree) in it, which the camera sees as far as ``end``."""

    def build(scene, tree):
        scene.render.film_transparent = film
        tree.surface(_diffuse(tree, (0.8, 0.7, 0.6)))
        bpy.ops.mesh.primitive_plane_add(size=3.0, location=(0.3, 3.0, 1.0), rotation=(1.4, 0, 0))
        bpy.context.object.data.materials.append(new_material(make))
        bpy.ops.mesh.primitive_plane_add(size=1.2, location=(-0.6, -2.0, 0.5), rotation=(1.4, 0, 0))
        bpy.context.object.data.materials.append(new_material(make))
        scene.camera.data.clip_end = end

    return build


def _case(name, make, film=False, end=100.0, **options):
    build = _before_and_behind(make, film, end)
    CASES.append(Case(name, build, lit=True, blurred=True, with_alpha=film, **options))


_PANES = {
    "a pane": lambda tree: _clear(tree, _TINT),
    "half a pane": _both("Mix", 0.4, _clear, _diffuse),
}
for _name, _make in _PANES.items():
    for _film in (False, True):
        _where = ", transparent film" if _film else ""
        _case(f"Camera's clip end before {_name}{_where}", _make, _film, end=7.5)

_ADDED = {
    "diffuse": _both("Add", _clear, _diffuse),
    "emission": _both("Add", _clear, _glow),
    "diffuse, tinted": _both("Add", lambda t: _clear(t, _TINT), _diffuse),
    "diffuse, emission": _both("Add", _clear, _both("Add", _diffuse, _glow)),
    "diffuse, in a mixture": _both("Mix", noise_of, _both("Add", _clear, _diffuse), _diffuse),
    "image": _both("Add", _diffuse, lambda t: _clear(t, image_of(t))),
}
for _name, _make in _ADDED.items():
    _case(f"Transparent added to {_name}", _make)
_case("Transparent added to diffuse, transparent film", _ADDED["diffuse"], film=True)
_case("Transparent added to image, transparent film", _ADDED["image"], film=True)
