"""What registering adds to Blender's interface, and that unregistering takes it back."""

import re
from pathlib import Path

import bpy
import pytest

import iwis
from iwis.iwis_addon import panels

ROOT = Path(iwis.__file__).parent

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


def test_panels_name_operators_that_exist():
    """A button whose operator is missing prints an error at every draw."""
    for file in ("panels.py", "preferences.py"):
        source = (ROOT / "iwis_addon" / file).read_text()
        for name in re.findall(r'\.operator\("iwis\.(\w+)"', source):
            assert hasattr(bpy.types, f"IWIS_OT_{name}"), name


def test_panels_draw_properties_that_exist(scene):
    """Every flag of the passes panels is a property of its owner."""
    for row in panels.TABLE:
        if row.flag:
            owner = scene.view_layers[0].iwis if row.owned else scene.view_layers[0]
            assert isinstance(getattr(owner, row.flag), bool)
    source = (ROOT / "iwis_addon" / "panels.py").read_text()
    for name in re.findall(r'prop\(iwis, "(\w+)"', source):
        assert name in scene.iwis.bl_rna.properties
