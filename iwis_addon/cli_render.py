"""The part of the command line that needs bpy: open, set, render, say what it cost."""

from __future__ import annotations

import os
import re
import threading
from pathlib import Path

import bpy

from .. import register, unregister
from ..core.settings import DenoiseSettings, RenderSettings
from . import preferences
from .cli import CommandError
from .file_outputs import check_outputs
from .job import ENGINE, FrameStats, RenderJob, stats_by_frame
from .leave import end_without_waiting
from .output import check_written
from .settings import apply_settings

# What to do about the errors of Blender that come before any engine is asked.
_ADVICE = {
    "Cannot render, no camera": "add one, or choose one in the scene's properties",
    "Image too small": "the render border holds no pixel: enlarge it or turn Render Region off",
}


def render_file(
    options, settings: tuple[RenderSettings, DenoiseSettings], file_format: str, interrupted
) -> list:
    """Render what the command line asks for; return the FrameStats of each frame.

    interrupted: threading.Event that ends the render. Raises CommandError.
    """
    cache_dir = settings[0].cache_dir
    if cache_dir:
        os.environ[preferences.ENVIRONMENT] = cache_dir
    RenderJob.interrupt = interrupted
    register()
    try:
        scene = _open(options.file)
        _prepare(scene, options, settings, file_format)
        return _render(scene, options)
    finally:
        # bpy 4.5 hangs at exit when a scene still names the engine, or its class is registered.
        for scene in bpy.data.scenes:
            if scene.render.engine == ENGINE:
                scene.render.engine = "BLENDER_WORKBENCH"
        unregister()
        RenderJob.interrupt = threading.Event()
        if interrupted.is_set():
            end_without_waiting(bpy.app.tempdir)


def _open(path: Path):
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False, use_scripts=False)
    except RuntimeError as error:
        raise CommandError(f"{path}: cannot be opened: {_one_line(error)}") from None
    return bpy.context.scene


def _prepare(scene, options, settings, file_format) -> None:
    render = scene.render
    render.engine = ENGINE
    for own in settings:
        apply_settings(scene, own, [name for name, _value in options.pairs])
    if options.resolution:
        render.resolution_x, render.resolution_y = options.resolution
        render.resolution_percentage = 100
    image = render.image_settings
    if hasattr(image, "media_type"):  # Blender 5: to be set before the format
        multilayer = file_format == "OPEN_EXR_MULTILAYER"
        image.media_type = "MULTI_LAYER_IMAGE" if multilayer else "IMAGE"
    image.file_format = file_format
    if file_format == "OPEN_EXR_MULTILAYER":
        image.color_depth = "32"  # half floats would round positions and sample counts
    render.use_overwrite, render.use_placeholder = True, False


def _render(scene, options) -> list[FrameStats]:
    animation = options.start is not None
    if animation:
        scene.frame_start, scene.frame_end, scene.frame_step = options.start, options.end, 1
        path = _with_digits(options.output)
    else:
        if options.frame is not None:
            scene.frame_set(options.frame)
        path = _numbered(options.output, scene.frame_current)
    scene.render.filepath = _for_blender(path)
    if not any(layer.use for layer in scene.view_layers):  # Blender crashes
        raise CommandError(f"{options.file}: no view layer is on: turn on Use for Rendering of one")
    if RenderJob.interrupt.is_set():
        raise CommandError("interrupted; nothing was rendered")
    try:
        bpy.ops.render.render(animation=animation, write_still=not animation)
    except RuntimeError as error:
        raise CommandError(_what_stopped(_one_line(error), options)) from None
    frames = stats_by_frame(RenderJob.get().records)
    cut_short = [frame.frame for frame in frames if frame.stats.cancelled]
    if animation and cut_short:
        raise CommandError(_set_aside(options, cut_short[0]))
    for frame in frames:
        _check(output_path(options, frame.frame))
    try:
        check_outputs(scene)
    except OSError as error:
        raise CommandError(str(error)) from None
    return frames


def _check(path: Path) -> None:
    """Every file of a frame is there, and whole."""
    try:
        written = check_written(path)
    except OSError as error:
        raise CommandError(str(error)) from None
    if not written:
        raise CommandError(f"{path}: was not written")


def output_path(options, frame: int) -> Path:
    """Where the picture of a frame is."""
    path = _with_digits(options.output) if options.start is not None else options.output
    return _numbered(path, frame)


def describe(frame: FrameStats, options) -> str:
    """What was rendered, what it cost and where it is; first a line for each table built."""
    stats = frame.stats
    path = output_path(options, frame.frame)
    phases = ", ".join(f"{phase} {seconds:.2f} s" for phase, seconds in stats.seconds.items())
    built = "".join(f"{table}\n" for table in stats.tables)
    return (
        f"{built}frame {frame.frame}: {stats.width}x{stats.height}, "
        f"{stats.samples_mean:.1f} samples a pixel (at most {stats.samples_max}), "
        f"{stats.primary_rays} camera rays, {stats.shadow_rays} shadow rays; "
        f"{phases}; {path}"
    )


def _with_digits(path: Path) -> Path:
    """The path with four # before its suffix where it has none: frames must not share a file."""
    return path if "#" in path.name else path.with_name(f"{path.stem}####{path.suffix}")


def _numbered(path: Path, frame: int) -> Path:
    """The path with its last run of # replaced by the frame's number, as Blender does it."""
    name = re.sub(r"#+(?=[^#]*$)", lambda match: f"{frame:0{len(match[0])}d}", path.name)
    return path.with_name(name)


def _for_blender(path: Path) -> str:
    """An absolute path that Blender takes as it is: single braces would be a template to it."""
    return str(path.resolve()).replace("{", "{{").replace("}", "}}")


def _set_aside(options, frame: int) -> str:
    """Give the picture of a frame of an animation that is not done another name, and tell it: who
    goes on later takes a file for a frame that is done."""
    path = output_path(options, frame)
    aside = path.with_name(f"{path.stem}-partial{path.suffix}")
    try:
        os.replace(path, aside)
    except OSError:  # of single views: other names
        return f"interrupted; the picture of frame {frame} holds what was done by then"
    return f"interrupted; what was done of frame {frame} by then is in {aside}"


def _what_stopped(message: str, options) -> str:
    """Blender's message, with what to do about it or what is kept."""
    if RenderJob.interrupt.is_set():
        cut_short = [f.frame for f in stats_by_frame(RenderJob.get().records) if f.stats.cancelled]
        if len(cut_short) < 2:  # the last one is the frame that has not begun
            return "interrupted; the frame was not saved"
        if options.start is not None:
            return _set_aside(options, cut_short[0])
        return f"interrupted; the picture of frame {cut_short[0]} holds what was done by then"
    return f"{message}: {_ADVICE[message]}" if message in _ADVICE else message


def _one_line(error: Exception) -> str:
    """Blender's reports, without their 'Error: ' and each once."""
    lines = (line.strip().removeprefix("Error: ") for line in str(error).splitlines())
    return "; ".join(dict.fromkeys(line for line in lines if line))
