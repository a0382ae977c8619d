"""render(), and then the picture without its noise: delivered once more, as a whole."""

from __future__ import annotations

from .denoising.denoise import NOISY, Denoising, Guided, data_layers, denoise_apart, prepared
from .film import Progress, Tile, TileSink
from .render import render, worker_count
from .render_cache import RenderCache
from .scene import Scene
from .settings import RenderSettings
from .stats import RenderStats


def render_denoised(
    scene: Scene,
    settings: RenderSettings,
    denoising: Denoising,
    data: bool,
    sink: TileSink,
    cache: RenderCache | None = None,
) -> RenderStats:
    """render(), whose tiles have the layer NOISY too; then one tile of all with Combined alone.

    data: whether tiles are to have denoise.DATA_LAYERS as well
    Where the noise stays, by a cancel or because something is missing, stats.warnings says why.
    """
    keeper = _Keeper(scene, denoising.settings.denoise, data, sink)
    stats = render(scene, settings, keeper, cache)
    if not denoising.settings.denoise or stats.cancelled:
        return stats
    with stats.phase("denoising"):
        try:
            known, own = prepared(keeper.picture, denoising.settings, scene, settings)
            wanted = denoising._replace(settings=own)
            picture = _denoise(known, wanted, worker_count(settings), sink)
        except (OSError, MemoryError, RuntimeError) as error:
            stats.warnings.append(f"The picture keeps its noise: {error}")
            return stats
    if picture is None:
        stats.cancelled = True
        stats.warnings.append("The picture keeps its noise: denoising was cancelled")
        return stats
    x0, y0, _, _ = scene.camera.region
    height, width = picture.shape[:2]
    with stats.phase("output"):
        sink.write_tile(Tile(x0, y0, width, height, {"combined": picture}))
    return stats


def _denoise(picture: Guided, denoising: Denoising, threads: int, sink: TileSink):
    """Combined without its noise; None after a cancel."""
    told = -1.0

    def going(fraction):
        nonlocal told
        if fraction != told:
            sink.progress(Progress("denoising", fraction))
            told = fraction
        return not sink.cancelled()

    return denoise_apart(picture, denoising, threads, going)


class _Keeper:
    """The sink of a picture that is to be denoised: passes it on, and keeps what is needed.

    picture: so far, None where nothing is to be denoised
    """

    def __init__(self, scene: Scene, denoise: bool, data: bool, sink: TileSink):
        x0, y0, x1, y1 = scene.camera.region
        self._scene, self._data, self._sink, self._corner = scene, data, sink, (x0, y0)
        self.picture = Guided.empty(x1 - x0, y1 - y0) if denoise else None

    def write_tile(self, tile: Tile) -> None:
        layers = dict(tile.layers)
        if self.picture is not None:
            part = Guided.of_layers(tile.layers, self._scene)
            self.picture.take(part, tile.x - self._corner[0], tile.y - self._corner[1])
            layers[NOISY] = layers["combined"]
        if self._data:
            layers |= data_layers(tile.layers, self._scene)
        self._sink.write_tile(tile._replace(layers=layers))

    def progress(self, progress: Progress) -> None:
        self._sink.progress(progress)

    def cancelled(self) -> bool:
        return self._sink.cancelled()
