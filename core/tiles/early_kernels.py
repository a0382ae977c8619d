"""Reads a render's machine code from disk while its hierarchy is built, which needs no Python.

Some thirty kernels take .3 s to be read, with Python's lock held; Embree builds without it. On a
machine that has none yet, a second process compiles the dearest one.
"""

from __future__ import annotations

import dataclasses
import logging
import threading

import numpy as np

from .. import _jit
from ..film import Film
from ..machine import compile_apart
from ..sampling.block_loop import continue_blocks
from ..sampling.loop_types import loop_signature
from ..scene import (
    DIFFUSE,
    GGX,
    ORTHOGRAPHIC,
    Camera,
    EnvironmentMap,
    MaterialParams,
    Scene,
    TriangleMesh,
)
from ..settings import RenderSettings

log = logging.getLogger(__name__)
_begun: set[tuple] = set()


def read_early(settings: RenderSettings, render) -> None:
    """Begin a render of one pixel in a thread of its own, once for each kind of settings.

    render: as in render.py. Mode PAPER would build tables: it is left out.
    """
    kind = settings.pixel_filter, settings.stop_rule
    if settings.estimator == "PAPER" or kind in _begun:
        return
    _begun.add(kind)
    if hasattr(continue_blocks, "is_kept"):  # not of a numba whose insides are not known
        compile_apart.begin(continue_blocks, loop_signature(), _jit._CACHE_DIR)
    changes = {"threads": 1, "max_samples": 8, "cache_dir": None}
    if settings.stop_rule == "BUDGET":
        changes |= {"target_samples": 8, "time_limit": 0.0}
    own = dataclasses.replace(settings, **changes)

    def work():
        try:
            scene = smallest_scene()
            film = _EndsWhereItWaits(scene.camera.region)
            render(scene, own, film)
            if film.has_ended:
                render(scene, own, Film(scene.camera.region))
        except Exception:  # the render that is waited for will say it
            log.debug("kernels could not be read early", exc_info=True)

    # Not a daemon: while one reads machine code, the interpreter must not end.
    threading.Thread(target=work, name="iwis-early").start()


class _EndsWhereItWaits(Film):
    """Ends a render that waits for the second process: what develops the pixel is made meanwhile.

    A pixel that is ended is developed with the samples that it has: here with none.
    """

    has_ended = False

    def cancelled(self) -> bool:
        self.has_ended |= compile_apart.is_awaited()
        return self.has_ended


def smallest_scene() -> Scene:
    """One pixel of one triangle under a grey sky."""
    one = np.ones(1, np.float32)
    triangle = np.float32([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
    camera = Camera(
        kind=ORTHOGRAPHIC,
        camera_to_world=np.array([*np.eye(4)[:2], [0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0]]),
        window=(-0.1, 0.1, -0.1, 0.1),
        width=1,
        height=1,
        region=(0, 0, 1, 1),
        clip_start=0.1,
        clip_end=10.0,
    )
    return Scene(
        mesh=TriangleMesh(
            vertices=triangle,
            triangles=np.int32([[0, 1, 2]]),
            corner_normals=np.tile(np.float32([0.0, 0.0, 1.0]), (1, 3, 1)),
            material_index=np.zeros(1, np.int32),
            object_index=np.zeros(1, np.int32),
        ),
        materials=MaterialParams(
            model=np.full(1, DIFFUSE, np.int8),
            distribution=np.full(1, GGX, np.int8),
            base_color=np.full((1, 3), 0.5, np.float32),
            metallic=0.0 * one,
            roughness=one,
            ior=1.5 * one,
            specular_level=0.5 * one,
            specular_tint=np.ones((1, 3), np.float32),
            emission=np.zeros((1, 3), np.float32),
            diffuse_roughness=0.0 * one,
        ),
        environment=EnvironmentMap(radiance=np.full((2, 4, 3), 0.5, np.float32)),
        camera=camera,
        material_pass_index=0.0 * one,
        object_pass_index=0.0 * one,
    )
