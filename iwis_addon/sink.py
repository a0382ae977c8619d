"""Tiles -> Blender's render result, progress -> its status line, its cancel -> the core."""

from __future__ import annotations

import time
from collections.abc import Sequence

import bpy
import numpy as np

from ..core.film import Progress, Tile
from ..core.settings import RenderSettings
from ..core.stats import peak_memory_bytes
from .job import RenderJob
from .passes import Pass

# Blender prints a line for every update in background mode; a farm's log needs no more.
SECONDS_BETWEEN_UPDATES = 1.0 if bpy.app.background else 0.1
_TELLS_TIME = bpy.app.background  # above the picture of a window stands Blender's own
_PHASE_TEXTS = {
    "tables": "Preparing the light",
    "bvh": "Building BVH",
    "sampling": "Sampling",
    "denoising": "Denoising",
}


class BlenderSink:
    """The TileSink of one view of one view layer; to be called by Blender's thread only.

    region: (x0, y0, x1, y1) of the frame that the render result covers
    films: kept beside the result, each with a write_tile()
    whole: hand Blender the view at finish(), at once (stereo.at_once)
    """

    def __init__(
        self,
        engine,
        layer: str,
        view: str,
        rows: list[Pass],
        region: tuple[int, int, int, int],
        settings: RenderSettings,
        films: Sequence = (),
        whole: bool = False,
    ):
        self._engine, self._layer, self._view, self._rows = engine, layer, view, rows
        self._region, self._films, self._settings = region, films, settings
        self._held: dict[str, np.ndarray] | None = {} if whole else None
        self._started = time.perf_counter()
        self._last_update = 0.0
        self.tiles_written = 0
        self.output_seconds = 0.0

    def write_tile(self, tile: Tile) -> None:
        started = time.perf_counter()
        if self._held is None:
            pixels = {row.name: self._pixels(row, tile) for row in self._rows}
            x, y = tile.x - self._region[0], tile.y - self._region[1]
            self._deliver(x, y, tile.width, tile.height, pixels)
        else:
            self._hold(tile)
        for film in self._films:
            film.write_tile(tile)
        self.tiles_written += 1
        self.output_seconds += time.perf_counter() - started

    def finish(self) -> None:
        """Hand Blender what was held back; a view without a tile is left to others."""
        if self._held:
            x0, y0, x1, y1 = self._region
            self._deliver(0, 0, x1 - x0, y1 - y0, self._held)

    def _deliver(self, x: int, y: int, width: int, height: int, pixels: dict) -> None:
        result = self._engine.begin_result(x, y, width, height, layer=self._layer, view=self._view)
        passes = result.layers[0].passes
        for name, values in pixels.items():
            # foreach_set of float32: assigning to rect is some hundred times slower.
            passes.find_by_name(name, self._view).rect.foreach_set(values.ravel())
        self._engine.end_result(result)

    def _hold(self, tile: Tile) -> None:
        x0, y0, x1, y1 = self._region
        x, y = tile.x - x0, tile.y - y0
        for row in self._rows:
            if row.layer in tile.layers:
                shape = y1 - y0, x1 - x0, len(row.channel_ids)
                whole = self._held.setdefault(row.name, np.zeros(shape, np.float32))
                whole[y : y + tile.height, x : x + tile.width] = row.pixels(tile.layers)

    def _pixels(self, row: Pass, tile: Tile):
        """A pass of a tile, float32 (h, w, channels): as it is shown, where the tile has none.

        Blender empties what the new result of a part does not bring.
        """
        if row.layer in tile.layers:
            return row.pixels(tile.layers)
        result = self._engine.get_result()
        layer = next(layer for layer in result.layers if layer.name == self._layer)
        x0, y0, x1, y1 = self._region
        whole = np.empty((y1 - y0, x1 - x0, len(row.channel_ids)), np.float32)
        layer.passes.find_by_name(row.name, self._view).rect.foreach_get(whole.ravel())
        x, y = tile.x - x0, tile.y - y0
        return whole[y : y + tile.height, x : x + tile.width]

    def progress(self, progress: Progress) -> None:
        now = time.perf_counter()
        last = progress.tiles_total > 0 and progress.tiles_done == progress.tiles_total
        if now - self._last_update < SECONDS_BETWEEN_UPDATES and not last:
            return
        self._last_update = now
        peak = peak_memory_bytes() / (1 << 20)
        self._engine.update_memory_stats(memory_used=peak, memory_peak=peak)
        self._engine.update_stats("", self.line(progress, now - self._started, peak))
        if progress.phase == "sampling":
            self._engine.update_progress(progress.fraction)

    def cancelled(self) -> bool:
        return self._engine.test_break() or RenderJob.interrupt.is_set()

    def line(self, progress: Progress, seconds: float, peak_mb: float) -> str:
        """The status line; farms look for `Rendered 3/12 Tiles, Sample 12/128` in it."""
        parts = [f"Mem:{peak_mb:.2f}M"]
        if _TELLS_TIME:
            parts.append(f"Time:{clock(seconds)}")
        if progress.phase != "sampling":
            text = progress.text or _PHASE_TEXTS.get(progress.phase, progress.phase)
            return " | ".join([*parts, self._layer, f"{text} {progress.fraction:.0%}"])
        if 0.0 < progress.fraction < 1.0:
            parts.append(f"Remaining:{clock(seconds * (1.0 / progress.fraction - 1.0))}")
        x0, y0, x1, y1 = self._region
        pixels = max(progress.fraction * (x1 - x0) * (y1 - y0), 1.0)
        most = self._settings.max_samples  # tiles at the border are smaller than the mean one
        parts += [
            self._layer,
            f"Rendered {progress.tiles_done}/{progress.tiles_total} Tiles, "
            f"Sample {min(round(progress.samples / pixels), most)}/{most}",
        ]
        return " | ".join(parts)


def clock(seconds: float) -> str:
    """Seconds as Blender writes them: MM:SS.ss, with the hours in front where there are any."""
    minutes, rest = divmod(seconds, 60.0)
    hours, minutes = divmod(int(minutes), 60)
    return (f"{hours:02d}:" if hours else "") + f"{minutes:02d}:{rest:05.2f}"
