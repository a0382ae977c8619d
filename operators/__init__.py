"""One file a button: it reads RNA, calls a plain function, reports."""

import bpy

from . import bake_tables, clear_cache, save_film

MODULES = (bake_tables, clear_cache, save_film)


def register() -> None:
    for module in MODULES:
        for cls in module.CLASSES:
            bpy.utils.register_class(cls)


def unregister() -> None:
    for module in reversed(MODULES):
        for cls in reversed(module.CLASSES):
            bpy.utils.unregister_class(cls)
