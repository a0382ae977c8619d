"""The render result that Blender keeps of a picture: its size, and whether it fits into memory."""

from __future__ import annotations

from .export import ExportError
from .export.free_memory import free_memory_bytes
from .passes import wanted_passes
from .stereo import at_once

_CHANNEL_BYTES = 4
_COMBINED_BYTES = 4 * _CHANNEL_BYTES
_GIGABYTE = 1e9


def result_views(engine) -> list[str]:
    """Names of the views that Blender wants: left and right, or one without a name."""
    return [view.name for view in engine.get_result().views] or [""]


def result_size(engine) -> tuple[int, int]:
    """Width and height of the render result: the whole frame, or its border."""
    result = engine.get_result()
    return result.resolution_x, result.resolution_y


def deliver_empty(engine, layer: str, delivered: set[str]) -> None:
    """Deliver an empty picture of a view layer for every view but those delivered.

    None where there is no memory for one: Blender would die of it.
    """
    width, height = result_size(engine)
    free = free_memory_bytes()
    if free is not None and 2 * _COMBINED_BYTES * width * height > free:  # Blender's, and this
        return
    for view in result_views(engine):
        if view not in delivered:
            engine.end_result(engine.begin_result(0, 0, width, height, layer=layer, view=view))


def check_memory(engine, scene, view_layer) -> None:
    """Raise ExportError where the passes of a view layer are more than the memory that is free.

    Blender keeps all of them, whole, in float32.
    """
    width, height = result_size(engine)
    channels = sum(len(row.channel_ids) for row in wanted_passes(scene, view_layer))
    views = result_views(engine)
    # A view that arrives whole is held back once, and once more on its way.
    copies = len(views) + (2 if at_once(views[0]) else 0)
    needed = width * height * channels * copies * _CHANNEL_BYTES
    free = free_memory_bytes()
    if free is not None and needed > free:
        raise ExportError(
            f"The picture has {width} x {height} pixels; its passes need "
            f"{needed / _GIGABYTE:.1f} GB, of which {free / _GIGABYTE:.1f} are free. Lower "
            "the resolution, render a border of it, or turn off passes"
        )
