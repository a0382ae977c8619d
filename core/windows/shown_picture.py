"""A picture for a window in work: its tiles, taken on in threads, and the layers that are shown."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..data.asked_passes import AskedPasses, channels_of
from ..denoising.denoise import DATA_LAYERS, Guided, data_layers
from ..film import LAYERS
from ..machine.turns import Turns
from ..render import make_tile, worker_count
from ..scene import Scene
from ..tiles.tile_job import Job, TileWork
from ..tiles.tiles import tile_rects

# What every picture carries, of film.LAYERS.
SHOWN = ("combined", "samples", "error", "visibility")
_TILE_PX = 32  # at the most: a coarse picture has few pixels, and all threads are to have some


class Picture(NamedTuple):
    """What can be shown now.

    step: pixels of the frame that a pixel of the layers covers, to either side
    region: (x0, y0, x1, y1) of the frame that the layers cover, in units of ``step``
    layers: of SHOWN, and ``shown``: float32 (h, w, channels), row 0 at the bottom; with step 1 they
        go on changing
    fraction: of the rounds that may come; converged: no sample is wanted any more
    shown: the layer that is looked at, of film.LAYERS, denoise.DATA_LAYERS or a matte
    """

    step: int
    region: tuple[int, int, int, int]
    layers: dict[str, np.ndarray]
    fraction: float
    converged: bool
    shown: str = "combined"


def tile_works(job: Job) -> list[TileWork]:
    tile_px = min(job.settings.tile_px, _TILE_PX)
    return [make_tile(job, rect) for rect in tile_rects(job.scene.camera.region, tile_px)]


def new_shown_layers(region, asked: AskedPasses) -> dict[str, np.ndarray]:
    """Picture.layers, zero."""
    (x0, y0, x1, y1), channels = region, LAYERS | DATA_LAYERS
    channels |= {matte.layer: channels_of(matte.levels) for matte in asked.mattes}
    names = dict.fromkeys((*SHOWN, asked.shown or SHOWN[0]))
    return {name: np.zeros((y1 - y0, x1 - x0, channels[name]), np.float32) for name in names}


def advance(
    works: list[TileWork], samples: int, layers: dict, job: Job, guided: Guided | None = None
) -> Iterator[bool]:
    """Take tiles on in threads, write each into the layers; yield whether each is done.

    guided: of the same picture; None: nobody wants it
    """
    waiting, finished = queue.SimpleQueue(), queue.SimpleQueue()
    count = min(worker_count(job.settings), len(works))
    turns = Turns(count)
    for work in works:
        waiting.put(work)

    def work_on():
        try:
            while not job.stop.is_set():
                work = waiting.get_nowait()
                with turns.taken():
                    done = work.advance(samples)
                    _write(work, layers, job.scene, guided)
                    work.rest()
                finished.put((work, done))
        except queue.Empty:
            pass
        except BaseException as error:  # raised again in the caller's thread
            finished.put(error)
        finally:
            finished.put(None)

    threads = [
        threading.Thread(target=work_on, name=f"iwis-view-{k}", daemon=True) for k in range(count)
    ]
    for thread in threads:
        thread.start()
    while count:
        result = finished.get()
        if isinstance(result, BaseException):
            raise result
        if result is None:
            count -= 1
        else:
            yield result


def _write(work: TileWork, layers: dict, scene: Scene, guided: Guided | None) -> None:
    tile = work.develop()
    x, y = tile.x - scene.camera.region[0], tile.y - scene.camera.region[1]
    made = tile.layers
    if scene.asked.shown in DATA_LAYERS:
        made = made | data_layers(made, scene)
    for name, layer in layers.items():
        layer[y : y + tile.height, x : x + tile.width] = made[name]
    if guided is not None:
        guided.take(Guided.of_layers(tile.layers, scene), x, y)
