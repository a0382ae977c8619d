"""Remove what IWIS can make again: wavelet tables and compiled kernels."""

from __future__ import annotations

from pathlib import Path

import bpy

from ..iwis_addon.preferences import cache_dir

# The only subfolders that are IWIS' own: a user may have chosen a folder with other things in it.
SUBFOLDERS = ("numba", "tables")


class IWIS_OT_clear_cache(bpy.types.Operator):
    """Remove wavelet tables and compiled code, which are made again when they are needed"""

    bl_idname = "iwis.clear_cache"
    bl_label = "Clear IWIS Cache"

    def execute(self, _context):
        try:
            count, size = clear_cache(cache_folders())
        except (ImportError, OSError) as error:
            self.report({"ERROR"}, f"The cache was not cleared: {error}")
            return {"CANCELLED"}
        self.report({"INFO"}, f"Removed {count} files, {size / 1e6:.1f} MB")
        return {"FINISHED"}


def cache_folders() -> list[Path]:
    """The folder of the tables and that of the kernels; mostly the same."""
    from ..core._jit import user_cache_dir

    return list(dict.fromkeys(Path(folder) for folder in (cache_dir(), user_cache_dir()) if folder))


def clear_cache(folders: list[Path]) -> tuple[int, int]:
    """Remove IWIS' files below the folders; return how many and their bytes.

    Folders stay: numba writes the next kernel into one that it has seen.
    """
    count = size = 0
    for folder in folders:
        for subfolder in SUBFOLDERS:
            for path in (folder / subfolder).rglob("*"):
                if path.is_file():
                    size += path.stat().st_size
                    path.unlink()
                    count += 1
    return count, size


CLASSES = (IWIS_OT_clear_cache,)
