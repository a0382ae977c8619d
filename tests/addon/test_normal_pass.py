"""The pass Normal of bumpy surfaces, beside Cycles'."""

import bpy
import numpy as np
import pytest
from parity.scene import Tree

from support.cycles_render import render_cycles
from support.iwis_render import by_pass, render_iwis


def _diffuse(tree, bump):
    return tree.made("ShaderNodeBsdfDiffuse", 0, {"Normal": bump})


def _paint(tree, bump):
    return tree.made("ShaderNodeBsdfPrincipled", 0, {"Normal": bump})


def _mixed(tree, bump):
    """Of which one closure has the bump."""
    node = tree.node("ShaderNodeMixShader")
    for part, socket in zip(
        (_diffuse(tree, bump), tree.made("ShaderNodeBsdfGlossy")), node.inputs[1:], strict=True
    ):
        tree.tree.links.new(part, socket)
    return node.outputs[0]


def _wall(shader):
    """A plane that fills the picture, with a bump as of a gutter."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    material = bpy.data.materials.new("M")
    if material.node_tree is None:
        material.use_nodes = True
    tree = Tree(material.node_tree)
    x = tree.made("ShaderNodeSeparateXYZ", 0, {0: tree.coordinates()})
    square = tree.made("ShaderNodeMath", 0, {0: x, 1: x}, operation="MULTIPLY")
    bump = {"Height": square, "Strength": 1.0, "Distance": 1.0}
    tree.surface(shader(tree, tree.made("ShaderNodeBump", 0, bump)))
    bpy.ops.mesh.primitive_plane_add(size=2)
    bpy.context.object.data.materials.append(material)
    bpy.ops.object.camera_add(location=(0.0, 0.0, 5.0))
    scene.camera = bpy.context.object
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 2.0
    scene.render.resolution_x, scene.render.resolution_y = 64, 4
    return scene


@pytest.mark.parametrize("pixel_filter", ["CENTER", "BOX"])
@pytest.mark.parametrize("shader", [_diffuse, _paint, _mixed])
def test_it_shows_the_normals_that_bumps_leave(shader, pixel_filter, tmp_path):
    """As Cycles': the mean of those of the closures. What they weigh in a mixture is not the same
    to the last: .02; places within a pixel of the filter: .01 in the mean."""
    scene = _wall(shader)
    theirs = render_cycles(scene, tmp_path, ("normal",))["Normal"]
    scene.iwis.pixel_filter, scene.iwis.filter_width = pixel_filter, 0.51
    scene.iwis.max_samples, scene.iwis.stop_rule = 64, "FIXED"
    ours = by_pass(render_iwis(scene, tmp_path))["Normal"]
    assert np.abs(theirs[..., 0]).max() > 0.5
    np.testing.assert_allclose(ours, theirs, atol=0.035)
    assert np.abs(ours - theirs).mean() < 0.01
