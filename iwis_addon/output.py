"""A full disk: Blender writes half a file and calls it a success, so IWIS looks for itself."""

from __future__ import annotations

import shutil
import sys
from glob import escape
from pathlib import Path

import bpy

from .file_outputs import check_not_full, check_outputs, compositor_tree
from .whole_file import KNOWN, is_cut_short

# Pictures of little content compress to this part of their size; less room than that is none.
_LEAST_COMPRESSED = 1 / 16
# Of Blender's command line: it renders and saves.
_RENDERS = {"-f", "--render-frame", "-a", "--render-anim"}


def is_farm_job() -> bool:
    """Whether Blender renders, saves and ends by itself, as its command line says."""
    words = sys.argv[: sys.argv.index("--")] if "--" in sys.argv else sys.argv  # then a script's
    return bpy.app.background and not bpy.app.module and bool(_RENDERS & set(words))


def has_pixels(render) -> bool:
    """Whether a picture has any: Blender says that it is too small, and ends with 0."""
    share = render.resolution_percentage / 100
    width, height = int(render.resolution_x * share), int(render.resolution_y * share)
    if render.use_border:
        width = int(render.border_max_x * width) - int(render.border_min_x * width)
        height = int(render.border_max_y * height) - int(render.border_min_y * height)
    return width >= 1 and height >= 1


NO_LAYER = "No view layer is on: turn on Use for Rendering of one"


def lacks_layers(scene) -> bool:
    """Whether a picture is to be rendered of view layers, of which none is on.

    Blender then asks no engine, saves a picture without a pixel of light, and ends with 0. It asks
    none, too, where strips or a compositor without a Render Layers node of the scene make it.
    """
    if any(layer.use for layer in scene.view_layers):
        return False
    render = scene.render
    editor = scene.sequence_editor
    if render.use_sequencer and editor is not None and len(editor.strips_all):
        return False
    tree = compositor_tree(scene)
    if tree is None:
        return True
    return any(
        node.bl_idname == "CompositorNodeRLayers" and not node.mute and node.scene in (None, scene)
        for node in tree.nodes
    )


def check_room(scene, channels: int) -> None:
    """Raise OSError where a Blender program is about to save a picture that has no room.

    To be called before Blender saves, which it does by itself in background mode only, where its
    command line says so: what a script does with a picture it knows alone.
    channels: of all passes of the view layer
    """
    if not is_farm_job():
        return
    path = _picture_path(scene)
    folder = next((parent for parent in path.parents if parent.is_dir()), None)
    if folder is None:  # Blender says so
        return
    render = scene.render
    share = (render.resolution_percentage / 100) ** 2
    pixels = render.resolution_x * render.resolution_y * share
    multilayer = render.image_settings.file_format == "OPEN_EXR_MULTILAYER"
    needed = pixels * (4 * channels if multilayer else 3) * _LEAST_COMPRESSED
    usage = shutil.disk_usage(folder)
    free = usage.free
    if usage.total and free < needed:  # file systems in memory, and some of networks, say nothing
        raise OSError(
            f"{folder}: {free} bytes are left on the disk, too few for {path.name}: "
            "free some space or choose another folder"
        )


def check_saved(scene) -> None:
    """Raise OSError where a Blender program has just saved a frame that is not whole.

    To be called after Blender has saved, which calls what it could not write a success.
    """
    if bpy.app.module:
        return
    check_outputs(scene)
    if scene.render.is_movie_format:  # not whole before its end
        return
    path = _picture_path(scene)
    for file in check_written(path):
        if file.suffix.lower() not in KNOWN and file.is_file():
            check_not_full(file.parent)


def check_movie(scene) -> None:
    """Raise OSError where the movie that a Blender program has just ended is not whole."""
    folder = _picture_path(scene).parent
    if scene.render.is_movie_format and folder.is_dir():
        check_not_full(folder)


def _picture_path(scene) -> Path:
    """The file of the scene's frame, or of its movie."""
    return Path(bpy.path.abspath(scene.render.frame_path(frame=scene.frame_current)))


def check_written(path: Path) -> list[Path]:
    """The files of a picture, one a view where there are several; OSError where one is cut short.

    Stereo views put theirs beside the name, as out_L.exr.
    """
    views = path.parent.glob(f"{escape(path.stem)}*{path.suffix}")
    written = [path] if path.exists() else list(views)
    for file in written:
        if is_cut_short(file):
            raise OSError(
                f"{file}: is cut short: the disk is full, or your share of it: free some space, or "
                "choose another"
            )
    return written
