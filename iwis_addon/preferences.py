"""The add-on's preferences: where what can be computed again is kept."""

import os

import bpy
from bpy.props import StringProperty

from . import ADDON_ID, dependencies

ENVIRONMENT = "IWIS_CACHE_DIR"


class IWISPreferences(bpy.types.AddonPreferences):
    bl_idname = ADDON_ID

    cache_dir: StringProperty(
        name="Cache Folder",
        description="Where tables and compiled code are kept; empty for the default place",
        subtype="DIR_PATH",
    )

    def draw(self, _context):
        layout = self.layout
        for line in dependencies.advice():
            layout.label(text=line, icon="ERROR")
        layout.prop(self, "cache_dir", placeholder=cache_dir())
        row = layout.row()
        if cache_dir():
            row.label(text=f"Size: {folder_bytes(cache_dir()) / 1e6:.1f} MB")
        row.operator("iwis.clear_cache")


def add_on_preferences():
    """IWIS' preferences; None where it was registered by hand."""
    addon = bpy.context.preferences.addons.get(ADDON_ID)
    return None if addon is None else addon.preferences


def cache_dir() -> str:
    """The folder of tables and compiled kernels; "" where the core's own default is meant.

    In this order: the preferences, the environment's IWIS_CACHE_DIR, the folder that Blender gives
    an extension.
    """
    own = add_on_preferences()
    if own is not None and own.cache_dir:
        return bpy.path.abspath(own.cache_dir)
    if os.environ.get(ENVIRONMENT):
        return os.environ[ENVIRONMENT]
    try:
        return bpy.utils.extension_path_user(ADDON_ID)
    except ValueError:  # not installed as an extension
        return ""


def share_cache_dir() -> None:
    """Tell the core's kernels, which know no preferences, to use the same folder.

    To be called before the first import of a kernel. A user's own variable is left as it is.
    """
    folder = cache_dir()
    if folder:
        os.environ.setdefault(ENVIRONMENT, folder)


def folder_bytes(folder: str) -> int:
    """The sum of all files' sizes; 0 for a folder that is not there."""
    total = 0
    for root, _folders, files in os.walk(folder):
        for name in files:
            try:
                total += os.path.getsize(os.path.join(root, name))
            except OSError:  # removed meanwhile
                continue
    return total


CLASSES = (IWISPreferences,)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
