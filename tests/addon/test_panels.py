"""What registering adds to Blender's interface, and that unregistering takes it back."""

import types

import bpy
import pytest

import iwis
from iwis.core.stats import RenderStats
from iwis.iwis_addon import panels
from iwis.iwis_addon.job import RenderJob, RenderRecord
from iwis.iwis_addon.preferences import IWISPreferences

# Panels without which a user cannot edit what IWIS renders.
NEEDED = (
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
    "WORLD_PT_context_world",
    "DATA_PT_lens",
    "DATA_PT_camera",
    "RENDER_PT_format",
    "RENDER_PT_output",
    "RENDER_PT_frame_range",
    "VIEWLAYER_PT_layer",
    "VIEWLAYER_PT_layer_passes",
    "RENDER_PT_color_management",
)
SENSELESS = ("DATA_PT_light", "RENDER_PT_freestyle", "MATERIAL_PT_preview", "DATA_PT_lightprobe")


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
        assert not [name for name in dir(bpy.types) if name.startswith("IWIS")]
        assert len(bpy.app.handlers.render_init) == counts["render_init"] - 1
        assert len(bpy.app.handlers.load_pre) == counts["load_pre"] - 1
    finally:
        iwis.register()
    assert set(NEEDED) <= compatible()


class Layout:
    """A UILayout that checks what it is given: properties and operators that exist."""

    def __init__(self):
        self.drawn = []

    def prop(self, owner, name, **_options):
        assert name in owner.bl_rna.properties, (owner, name)
        self.drawn.append(name)

    def operator(self, name, **_options):
        assert hasattr(bpy.types, name.replace("iwis.", "IWIS_OT_")), name
        self.drawn.append(name)

    def label(self, text, icon="NONE"):
        self.drawn.append(text)

    def row(self, **_options):
        return self

    column = row


@pytest.mark.parametrize("cls", [*panels.CLASSES, IWISPreferences], ids=lambda cls: cls.__name__)
def test_panels_draw_what_exists(scene, cls):
    """Every property and operator that a panel names is there, and something is drawn."""
    panel = types.SimpleNamespace(layout=Layout(), group=getattr(cls, "group", ""))
    panel.split_layout = lambda: panel.layout
    panel.bl_rna = types.SimpleNamespace(properties={"cache_dir"})
    if hasattr(cls, "draw_header"):
        cls.draw_header(panel, bpy.context)
    RenderJob.get().records.append(
        RenderRecord(1, "ViewLayer", "", RenderStats(warnings=["Light: ignored"]))
    )
    cls.draw(panel, bpy.context)
    assert panel.layout.drawn
