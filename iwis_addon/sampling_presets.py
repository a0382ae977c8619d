"""Sampling presets by Blender's own mechanism: Preview, Final, Paper, and what a user adds.

The three lie beside this file and are only read; a user's go where Blender keeps presets.
"""

import os

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from .job import ENGINE

_FOLDER = os.path.dirname(os.path.abspath(__file__))
SUBFOLDER = "iwis/sampling"
SETTINGS = (
    "estimator",
    "stop_rule",
    "error_threshold",
    "max_samples",
    "target_samples",
    "time_limit",
    "batch_size",
    "coefficients",
    "pixel_filter",
    "filter_width",
    "decorrelation",
)


class IWIS_PT_sampling_presets(PresetPanel, bpy.types.Panel):
    bl_label = "Sampling Presets"
    preset_subdir = SUBFOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = "iwis.sampling_preset_add"
    COMPAT_ENGINES = {ENGINE}  # noqa: RUF012


class IWIS_OT_sampling_preset_add(AddPresetBase, bpy.types.Operator):
    """Add a sampling preset"""

    bl_idname = "iwis.sampling_preset_add"
    bl_label = "Add Sampling Preset"
    preset_menu = "IWIS_PT_sampling_presets"
    preset_subdir = SUBFOLDER
    preset_defines = ("iwis = bpy.context.scene.iwis",)
    preset_values = tuple(f"iwis.{name}" for name in SETTINGS)


CLASSES = (IWIS_PT_sampling_presets, IWIS_OT_sampling_preset_add)


def register() -> None:
    bpy.utils.register_preset_path(_FOLDER)
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    bpy.utils.unregister_preset_path(_FOLDER)
