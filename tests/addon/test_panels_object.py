"""What the tabs of objects and materials let a user set of what IWIS reads."""

import types

import bpy

from iwis.iwis_addon import panels_object
from support.panel_layout import Layout

GROUP = {"lightgroup", "scene.view_layer_add_lightgroup"}
_SIZES = (("PIXEL", "adaptive_pixel_size"), ("OBJECT", "adaptive_object_edge_length"))


def _drawn(context):
    """What the object panels that show themselves draw."""
    drawn = []
    for cls in panels_object.CLASSES:
        if cls.poll(context):
            panel = types.SimpleNamespace(layout=Layout())
            panel.split_layout = lambda panel=panel: panel.layout
            cls.draw(panel, context)
            drawn += panel.layout.drawn
    return set(drawn)


def test_objects_can_be_set(scene):
    """What IWIS reads of a mesh, a lamp, a camera, and an empty that makes copies."""
    mesh = bpy.data.objects.new("Mesh", bpy.data.meshes.new("Mesh"))
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    copies, empty = (bpy.data.objects.new(name, None) for name in ("Copies", "Empty"))
    copies.instance_type = "COLLECTION"
    copies.instance_collection = bpy.data.collections.new("Own")
    shape = {
        "visible_camera",
        "visible_shadow",
        "is_shadow_catcher",
        "shadow_terminator_geometry_offset",
        "motion_steps",
        "use_deform_motion",
        *GROUP,
    }
    expected = {
        mesh: shape | {"use_camera_cull", "use_distance_cull"},
        copies: shape,
        lamp: {"visible_camera", "visible_diffuse", "visible_glossy", *GROUP},
        camera: {"motion_steps"},
        empty: set(),
    }
    for obj, names in expected.items():
        layer = scene.view_layers[0]
        context = types.SimpleNamespace(engine="IWIS", object=obj, scene=scene, view_layer=layer)
        assert _drawn(context) == names, obj.name
    assert not _drawn(types.SimpleNamespace(engine="IWIS", object=None, scene=scene))


def test_subdivision_can_be_set(scene):
    """Of an object whose last modifier subdivides: whether it is adaptive, and how fine."""
    obj = bpy.data.objects.new("Mesh", bpy.data.meshes.new("Mesh"))
    context = types.SimpleNamespace(
        engine="IWIS", object=obj, scene=scene, view_layer=scene.view_layers[0]
    )
    panel = panels_object.IWIS_PT_object_subdivision
    assert not panel.poll(context)
    last = obj.modifiers.new("Finer", "SUBSURF")
    assert panel.poll(context)
    newer = bpy.app.version >= (5, 0)
    for space, size in (
        ("PIXEL", "adaptive_pixel_size"),
        ("OBJECT", "adaptive_object_edge_length"),
    ):
        own = types.SimpleNamespace(layout=Layout())
        own.split_layout = lambda own=own: own.layout
        if newer:
            last.adaptive_space = space
        panel.draw_header(own, context)
        panel.draw(own, context)
        expected = {"adaptive_space", size} if newer else {"dicing_rate"}
        assert set(own.layout.drawn) == {"use_adaptive_subdivision", *expected}
        assert not own.layout.active
    owner = last if newer else obj.cycles
    owner.use_adaptive_subdivision = True
    panel.draw(own, context)
    assert own.layout.active
    obj.modifiers.new("Last", "TRIANGULATE")
    assert not panel.poll(context)


def test_materials_can_be_set(scene):
    """The pass's index, how it displaces, transparent shadows, and Cycles' bump map correction."""
    material = bpy.data.materials.new("M")
    context = types.SimpleNamespace(engine="IWIS", object=None, material=material, scene=scene)
    names = {"pass_index", "use_transparent_shadow", "use_bump_map_correction"}
    names.add("displacement_method")
    assert _drawn(context) == names
