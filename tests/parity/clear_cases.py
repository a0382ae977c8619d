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


def _hole_behind(film):
    """A ball that is a hole, half of it behind a pane."""
    seen_through = _before_and_behind(_PANES["a pane"], film, 100.0)

    def build(scene, tree):
        seen_through(scene, tree)
        bpy.data.objects["Sphere"].is_holdout = True

    return build


for _film, _blurred in ((True, True), (False, True), (True, False)):
    _where = f"{', transparent film' if _film else ''}{'' if _blurred else ', pixel centers'}"
    _own = {"lit": True, "blurred": _blurred, "with_alpha": True}
    CASES.append(Case(f"Holdout behind a pane{_where}", _hole_behind(_film), **_own))


def _by_depth(material):
    """Of surfaces of material(tree, depth): how many others rays have gone through."""

    def made(tree):
        return material(tree, tree.made("ShaderNodeLightPath", "Transparent Depth"))

    return made


def _glow_by(tree, depth):
    inputs = {"Value": depth, "From Max": 3.0, "To Max": 0.9}
    strength = tree.made("ShaderNodeMapRange", 0, inputs)
    return tree.made("ShaderNodeEmission", 0, {"Color": _TINT, "Strength": strength})


def _clear_by(tree, depth):
    """Nothing of it is lit: shadow rays are told another number."""
    return _both("Mix", depth, _clear, _glow)(tree)


def _before_the_scene(card, own):
    """Cards of one material before the scene, of another."""

    def build(scene, tree):
        _before_and_behind(card, False, 100.0)(scene, tree)
        tree.surface(own(tree))

    return build


for _name, _card, _own in (
    ("glow", _clear, _by_depth(_glow_by)),
    ("glow behind half a pane", _PANES["half a pane"], _by_depth(_glow_by)),
    ("a second pane is not clear", _by_depth(_clear_by), lambda tree: _glow(tree, 0.1)),
):
    _build = _before_the_scene(_card, _own)
    _options = {"lit": True, "blurred": True}
    CASES.append(Case(f"Light Path Transparent Depth: {_name}", _build, **_options))
