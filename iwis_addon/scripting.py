"""What a script calls: iwis.settings(scene, ...) and iwis.render(scene) -> arrays, no files."""

from __future__ import annotations

import contextlib
import dataclasses

import bpy
import numpy as np

from ..core.settings import DenoiseSettings, RenderSettings
from .job import ENGINE, RenderJob
from .properties import NOT_ON_SCENE
from .settings import apply_settings, denoise_settings, render_settings


def change_settings(scene, **values) -> RenderSettings:
    """Set ``scene.iwis`` by the names of core.settings; return all that a sampler then takes.

    Raises ValueError for a value out of range and for a name that is no setting of a scene, before
    anything is set.
    """
    known = {
        field.name
        for kind in (RenderSettings, DenoiseSettings)
        for field in dataclasses.fields(kind)
        if field.name not in NOT_ON_SCENE
    }
    unknown = sorted(set(values) - known)
    if unknown:
        raise ValueError(f"no setting of a scene: {', '.join(unknown)}; there are {sorted(known)}")
    checked = [
        dataclasses.replace(own, **{name: values[name] for name in values if hasattr(own, name)})
        for own in (render_settings(scene), denoise_settings(scene.iwis))
    ]
    for own in checked:
        apply_settings(scene, own, list(values))
    return render_settings(scene)


def render_arrays(scene=None, layer: str = "", view: str = "") -> dict[str, np.ndarray]:
    """Render a scene's current frame with IWIS, whatever its engine is; no file is written.

    scene: of bpy.data, None: the context's; layer: a view layer, "" is the first that is rendered;
    view: of a stereo picture, "" is the first
    Returns all of core.film.LAYERS, and what is asked for beside them (``noisy``: combined before
    it was denoised), float32 (h, w, channels), row 0 at the bottom, scene-linear, of the part of
    the frame that is rendered. Raises RuntimeError where the render fails, with what
    to do about it; KeyError where there is no such layer or view. Settings stay as they were.
    """
    scene = bpy.context.scene if scene is None else scene
    with _set(scene.render, engine=ENGINE, use_compositing=False, use_sequencer=False):
        with _set(scene.iwis, keep_film=True):
            bpy.ops.render.render(scene=scene.name)
    films = RenderJob.get().films
    for (film_layer, film_view), film in films.items():
        if layer in ("", film_layer) and view in ("", film_view):
            return film.layers
    raise KeyError(f"no picture of view layer {layer!r}, view {view!r}: there are {list(films)}")


@contextlib.contextmanager
def _set(owner, **values):
    before = {name: getattr(owner, name) for name in values}
    try:
        for name, value in values.items():
            setattr(owner, name, value)
        yield
    finally:
        for name, value in before.items():
            setattr(owner, name, value)
