"""Where a scene's compositor writes files of its own, and whether a disk has run full.

Blender calls a File Output node's picture, and a movie, a success whatever became of it.
"""

from __future__ import annotations

import errno
import os
import tempfile
from pathlib import Path

import bpy

_FULL = {errno.ENOSPC, errno.EDQUOT}
_LAST_BYTES = 16384  # a writer stops where less than a block of the disk is left


def compositor_tree(scene):
    """The tree that a scene's pictures go through; None where there is none."""
    if not scene.render.use_compositing:
        return None
    tree = scene.compositing_node_group if hasattr(scene, "compositing_node_group") else None
    if tree is None and scene.use_nodes:
        tree = getattr(scene, "node_tree", None)
    return tree


def output_folders(scene) -> list[Path]:
    """The folders of all File Output nodes, each once; those whose names are templates left out."""
    tree = compositor_tree(scene)
    found = dict.fromkeys(_paths(tree, set())) if tree is not None else {}
    return [Path(bpy.path.abspath(path)).parent for path in found if not set(path) & set("{}#")]


def _paths(tree, seen: set):
    """What File Output nodes say of their files, in groups too, and a letter that stands for it."""
    if tree in seen:
        return
    seen.add(tree)
    for node in tree.nodes:
        if node.mute:
            continue
        if node.type == "GROUP" and node.node_tree is not None:
            yield from _paths(node.node_tree, seen)
        elif node.bl_idname == "CompositorNodeOutputFile" and any(i.is_linked for i in node.inputs):
            if hasattr(node, "directory"):  # Blender 5
                yield os.path.join(node.directory or "//", "x")
            elif node.format.file_format == "OPEN_EXR_MULTILAYER":
                yield node.base_path  # with the file's name
            else:
                yield os.path.join(node.base_path, "x")


def check_outputs(scene) -> None:
    """Raise OSError where what File Output nodes have just written is not whole.

    Where they could not begin to write, Blender says so, and goes on.
    """
    for folder in output_folders(scene):
        if folder.is_dir():
            check_not_full(folder)


def check_not_full(folder: Path) -> None:
    """Raise OSError where a folder's disk, or the user's share of it, is full to the last block.

    What was written there last is then cut short, most likely. Nothing stays in the folder.
    """
    try:
        with tempfile.TemporaryFile(dir=folder, buffering=0) as file:
            if file.write(os.urandom(_LAST_BYTES)) < _LAST_BYTES:
                raise OSError(errno.ENOSPC, "no space left")
    except OSError as error:
        if error.errno in _FULL:
            raise OSError(
                f"{folder}: the disk is full, or your share of it: what was written there last is "
                "cut short: free some space, or choose another"
            ) from None
