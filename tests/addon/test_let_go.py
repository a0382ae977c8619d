"""What a render has read is let go of when it ends, not when Python looks for cycles."""

import gc
import weakref

import bpy
import pytest

from iwis.iwis_addon.export import ExportCache, export_scene

_MATERIAL = {
    "an image": ("ShaderNodeTexImage", "Color"),
    "a ramp": ("ShaderNodeValToRGB", "Color"),
    "a noise": ("ShaderNodeTexNoise", "Fac"),
}


@pytest.fixture
def without_cycles():
    """Python frees what nothing refers to, and looks for nothing else."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


@pytest.mark.parametrize("behind", _MATERIAL)
def test_an_export_leaves_nothing_behind(cube_scene, without_cycles, behind):
    """A script that renders frame after frame would keep the images of all of them: each scene
    lived on until some thousand objects later."""
    kind, output = _MATERIAL[behind]
    material = bpy.data.materials.new("M")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    node = tree.nodes.new(kind)
    if kind == "ShaderNodeTexImage":
        node.image = bpy.data.images.new("I", 4, 4)
    surface = next(own for own in tree.nodes if own.type == "BSDF_PRINCIPLED")
    link = next(out for out in node.outputs if out.name in (output, "Factor"))
    tree.links.new(link, surface.inputs["Base Color"])
    for obj in cube_scene.objects:
        if obj.type == "MESH":
            obj.data.materials.clear()
            obj.data.materials.append(material)
    cache = ExportCache()
    exported = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=[], cache=cache)
    kept = weakref.ref(cache.texels), weakref.ref(exported.mesh.vertices)
    del cache, exported
    assert [ref() for ref in kept] == [None, None]
