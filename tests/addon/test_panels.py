"""What registering adds to Blender's interface, and that unregistering takes it back."""

import types
from pathlib import Path

import bpy
import pytest

import iwis
from iwis.core.scene import PANORAMAS
from iwis.core.stats import RenderStats
from iwis.iwis_addon import (
    panel_base,
    panels,
    panels_bake,
    panels_camera,
    panels_lamp,
    panels_passes,
    panels_simplify,
    panels_status,
    panels_view,
    panels_world,
)
from iwis.iwis_addon.job import RenderJob, RenderRecord
from iwis.iwis_addon.preferences import IWISPreferences
from iwis.iwis_addon.sampling_presets import SETTINGS
from iwis.iwis_addon.settings import render_settings
from support.panel_layout import Layout
from support.view_space import view_space

# Panels without which a user cannot edit what IWIS renders.
NEEDED = (
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_MATERIAL_PT_displacement",
    "EEVEE_WORLD_PT_surface",
    "WORLD_PT_context_world",
    "DATA_PT_EEVEE_light",
    "DATA_PT_spot",
    "DATA_PT_lens",
    "DATA_PT_camera",
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "OBJECT_PT_shading",
    "OBJECT_PT_visibility",
    "DATA_PT_preview",
    "RENDER_PT_format",
    "RENDER_PT_output",
    "RENDER_PT_frame_range",
    "VIEWLAYER_PT_layer",
    "VIEWLAYER_PT_layer_passes",
    "MATERIAL_PT_preview",
    "RENDER_PT_color_management",
    # what no engine is asked about
    "DATA_PT_context_pointcloud",
    "DATA_PT_pointcloud_attributes",
    "DATA_PT_speaker",
    "IWIS_PT_performance_compositor",
    "IWIS_PT_performance_compositor_denoise",
)
FREESTYLE = (
    "RENDER_PT_freestyle",
    "VIEWLAYER_PT_freestyle",
    "VIEWLAYER_PT_freestyle_lineset",
    "VIEWLAYER_PT_freestyle_linestyle_color",
    "MATERIAL_PT_freestyle_line",
)
SENSELESS = ("DATA_PT_light", "DATA_PT_lightprobe", "RENDER_PT_gpencil")


def compatible():
    found = set()
    waiting = [bpy.types.Panel]
    while waiting:
        cls = waiting.pop()
        waiting += cls.__subclasses__()
        if "IWIS" in getattr(cls, "COMPAT_ENGINES", ()):
            found.add(cls.__name__)
    return found


@pytest.mark.parametrize("name", NEEDED)
def test_needed_panels_are_shown(name):
    """Node trees, camera, output and passes can be edited with IWIS as the engine."""
    assert name in compatible()


@pytest.mark.skipif(not bpy.app.build_options.freestyle, reason="a Blender without Freestyle")
@pytest.mark.parametrize("name", FREESTYLE)
def test_freestyle_can_be_turned_off(name):
    """Blender draws its lines over a picture of IWIS: they can be set, as with Cycles."""
    assert name in compatible()


@pytest.mark.parametrize("name", SENSELESS)
def test_senseless_panels_are_not_shown(name):
    """Nothing is offered that has no effect."""
    assert name not in compatible()


def test_unregister_takes_everything_back():
    """No class, property, handler or panel is left; registering again works."""
    counts = {name: len(getattr(bpy.app.handlers, name)) for name in ("render_init", "load_pre")}
    iwis.unregister()
    try:
        assert not [name for name in compatible() if not name.startswith("IWIS_")]
        assert not hasattr(bpy.types.Scene, "iwis")
        assert not hasattr(bpy.types.ViewLayer, "iwis")
        assert not hasattr(bpy.types.View3DShading, "iwis")
        assert not [name for name in dir(bpy.types) if name.startswith("IWIS")]
        assert len(bpy.app.handlers.render_init) == counts["render_init"] - 1
        assert len(bpy.app.handlers.load_pre) == counts["load_pre"] - 2
        assert not bpy.app.handlers.undo_post and not bpy.app.handlers.redo_post
        assert not [
            path for path in bpy.utils.preset_paths("iwis/sampling") if "iwis_addon" in path
        ]
        draws = bpy.types.TOPBAR_MT_render._dyn_ui_initialize() + (
            bpy.types.IMAGE_MT_image._dyn_ui_initialize()
        )
        assert not [draw for draw in draws if "operators" in draw.__module__]
    finally:
        iwis.register()
    assert set(NEEDED) | {"IWIS_PT_sampling"} <= compatible()


CAMERA_PANELS = [panels_camera.IWIS_PT_motion_blur, panels_camera.IWIS_PT_motion_blur_curve]
PANELS = [
    *panels.CLASSES,
    *panels_simplify.CLASSES,
    *CAMERA_PANELS,
    *panels_bake.CLASSES,
    *panels_passes.CLASSES,
    *panels_status.CLASSES,
    *panels_world.CLASSES,
    IWISPreferences,
]


@pytest.mark.parametrize("cls", PANELS, ids=lambda cls: cls.__name__)
def test_panels_draw_what_exists(scene, cls):
    """Every property and operator that a panel names is there, and something is drawn."""
    scene.world = bpy.data.worlds.new("World")
    panel = types.SimpleNamespace(layout=Layout(), group=getattr(cls, "group", ""))
    panel.split_layout = lambda: panel.layout
    panel.bl_rna = types.SimpleNamespace(properties={"cache_dir"})
    if hasattr(cls, "draw_header"):
        cls.draw_header(panel, bpy.context)
    RenderJob.get().records.append(
        RenderRecord(1, "ViewLayer", "", RenderStats(warnings=["Light: ignored"]))
    )
    cls.draw(panel, bpy.context)
    has_children = any(getattr(c, "bl_parent_id", "") == cls.__name__ for c in PANELS)
    assert panel.layout.drawn or has_children


@pytest.mark.parametrize("estimator", ["UNBIASED", "PAPER"])
def test_coefficients_are_grey_where_no_table_is_made(scene, estimator):
    """They are of mode PAPER alone."""
    panel, grey = types.SimpleNamespace(layout=Layout()), {}
    panel.split_layout = lambda: panel.layout
    panel.layout.prop = lambda _owner, name: grey.update({name: not panel.layout.active})
    scene.iwis.estimator = estimator
    panels.IWIS_PT_sampling_advanced.draw(panel, bpy.context)
    assert [name for name in grey if grey[name]] == ["coefficients"] * (estimator != "PAPER")


@pytest.mark.parametrize("width", [218, 400])
def test_texts_beside_buttons_are_not_cut_off(width):
    """At the width of a new window's properties editor, and wider: 6.2 pixels a letter, measured,
    beside an icon, a button and edges."""
    context = types.SimpleNamespace(
        region=types.SimpleNamespace(width=width),
        preferences=types.SimpleNamespace(system=types.SimpleNamespace(ui_scale=1.0)),
    )
    text = "cannot keep tables (No such file or directory): they are built again at each render"
    layout = Layout()
    panel_base.wrapped(layout, context, text, "INFO")
    assert " ".join(layout.drawn) == text
    assert 6.2 * max(map(len, layout.drawn)) <= width - 120


@pytest.mark.parametrize("kind", ["POINT", "SUN", "SPOT", "AREA"])
def test_lamps_can_be_set(scene, kind):
    """What EEVEE's panel leaves out and IWIS reads: an area's spread, the shadow, whether
    mirrors show it, the nodes."""
    context = types.SimpleNamespace(engine="IWIS", light=bpy.data.lights.new("Lamp", kind))
    shown, drawn = [cls for cls in panels_lamp.CLASSES if cls.poll(context)], []
    for cls in shown:
        panel = types.SimpleNamespace(layout=Layout())
        panel.split_layout = lambda panel=panel: panel.layout
        cls.draw(panel, context)
        drawn += panel.layout.drawn
    assert (panels_lamp.IWIS_PT_lamp_beam in shown) == (kind == "AREA")
    assert {"use_shadow", "use_multiple_importance_sampling"} < set(drawn)
    assert not panels_lamp.IWIS_PT_lamp_settings.poll(types.SimpleNamespace(engine="IWIS"))


def test_the_shading_menu_is_cycles(scene):
    """Of the rendered view of IWIS alone: lamps, world, what stands for it, and the pass."""
    space = view_space()
    context = types.SimpleNamespace(engine="IWIS", space_data=space)
    lighting, render_pass = panels_view.CLASSES

    def drawn(cls):
        panel = types.SimpleNamespace(layout=Layout())
        cls.draw(panel, context)
        return panel.layout.drawn

    assert all(cls.poll(context) for cls in panels_view.CLASSES)
    scenes = ["use_scene_lights_render", "use_scene_world_render"]
    assert drawn(lighting) == scenes and drawn(render_pass) == ["render_pass"]
    space.shading.use_scene_world_render = False
    studio = ["studiolight_rotate_z", "studiolight_intensity", "studiolight_background_alpha"]
    assert drawn(lighting) == [*scenes, "studio_light", "screen.userpref_show", *studio]
    space.shading.type = "SOLID"
    assert not any(cls.poll(context) for cls in panels_view.CLASSES)
    space.shading.type, context.engine = "RENDERED", "CYCLES"
    assert not any(cls.poll(context) for cls in panels_view.CLASSES)


@pytest.mark.parametrize("kind", PANORAMAS)
def test_every_panorama_can_be_set(scene, kind):
    """With all its numbers, for a camera of type PANO only."""
    data = bpy.data.cameras.new("Camera")
    context = types.SimpleNamespace(engine="IWIS", camera=data)
    assert not panels_camera.IWIS_PT_panorama.poll(context)
    data.type = "PANO"
    assert panels_camera.IWIS_PT_panorama.poll(context)
    owner = data if hasattr(data, "panorama_type") else data.cycles
    owner.panorama_type = kind
    panel = types.SimpleNamespace(layout=Layout())
    panel.split_layout = lambda: panel.layout
    panels_camera.IWIS_PT_panorama.draw(panel, context)
    own = [
        name for name in PANORAMAS[kind] if name not in ("sensor_width", "sensor_height", "axis")
    ]
    assert len(panel.layout.drawn) == 1 + len(own) + (kind == "CENTRAL_CYLINDRICAL")


def test_every_property_and_operator_has_a_tooltip_of_one_sentence(scene):
    """No full stop inside, none at the end: as Blender's own."""
    groups = [scene.iwis, scene.iwis.viewport, scene.view_layers[0].iwis, view_space().shading.iwis]
    texts = {
        f"{group.bl_rna.name}.{name}": group.bl_rna.properties[name].description
        for group in groups
        for name in group.bl_rna.properties.keys()
        if name not in ("name", "rna_type", "viewport", "bl_system_properties")
    }
    for name in dir(bpy.ops.iwis):
        rna = getattr(bpy.ops.iwis, name).get_rna_type()
        texts[name] = rna.description
    for name, text in texts.items():
        assert text and not text.endswith(".") and ". " not in text, (name, text)


def test_order_and_words_are_blenders():
    """The render tab's panels, as Cycles orders them."""
    labels = {cls.bl_label: cls.bl_order for cls in PANELS if hasattr(cls, "bl_order")}
    assert sorted(labels, key=labels.get) == [
        "Warnings", "Sampling", "Light", "Subdivision", "Simplify", "Motion Blur", "Film",
        "Performance", "Bake", "Statistics",
    ]  # fmt: skip


@pytest.mark.parametrize("name", ["Preview", "Final", "Paper"])
def test_presets_are_found_and_set_valid_settings(scene, name):
    """Blender's mechanism finds the file and runs it; the settings can be rendered with."""
    path = bpy.utils.preset_find(name, "iwis/sampling")
    assert path
    scene.iwis.max_samples = 1
    bpy.ops.script.execute_preset(filepath=path, menu_idname="IWIS_PT_sampling_presets")
    assert render_settings(scene).max_samples > 1
    assert (scene.iwis.estimator == "PAPER") == (name == "Paper")
    text = Path(path).read_text()
    assert all(f"iwis.{setting} = " in text for setting in SETTINGS)


def test_a_preset_is_added_where_the_user_may_write(scene, tmp_path, monkeypatch):
    """Not in the add-on's own folder; it is found and removed again."""
    monkeypatch.setattr(bpy.utils, "user_resource", lambda *_, **k: str(make(tmp_path / k["path"])))
    scene.iwis.max_samples = 77
    assert bpy.ops.iwis.sampling_preset_add(name="Mine") == {"FINISHED"}
    text = (tmp_path / "presets/iwis/sampling/Mine.py").read_text()
    assert "iwis.max_samples = 77" in text and "iwis.pixel_filter" in text


def make(folder):
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def test_overlay_is_chosen_for_iwis_only(scene):
    """The menu's choice is the property that the view reads."""
    assert bpy.ops.iwis.view_overlay(overlay="ERROR") == {"FINISHED"}
    assert scene.iwis.viewport.overlay == "ERROR"
    scene.render.engine = "CYCLES"
    assert not bpy.ops.iwis.view_overlay.poll()
