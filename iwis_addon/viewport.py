"""The rendered view: what Blender's callbacks do, and what they draw.

Blender makes one engine object for each region that shows the rendered view, calls `view_update`
after every change of its dependency graph and `view_draw` for every redraw, and forgets the object
when the region shows something else.
"""

from __future__ import annotations

import dataclasses
import time
import weakref
from collections.abc import Callable

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ..core.denoising.denoise import Denoising
from ..core.scene import Camera, Scene
from ..core.settings import RenderSettings
from . import view_picture, view_thread
from .denoiser import denoising
from .export import ExportCache, LiveExport, export_scene, film_exposure
from .export.same import same
from .export.view_shading import AS_RENDERED
from .export.worlds.late_sky import LateSkies
from .preferences import share_cache_dir
from .settings import denoise_settings, viewport_settings
from .view_camera import view_camera
from .view_shading import view_shading

# Viewports that live, for operators, panels and tests.
_LIVING: weakref.WeakSet[Viewport] = weakref.WeakSet()


class Viewport:
    """One region's rendered view, as long as Blender's engine object for it.

    warnings: of the last export; export_seconds: what it took of Blender's time
    restarts: how many times a change began the picture anew
    region: address of the region; pixel_size: pixels of the screen to one of the picture's frame
    """

    def __init__(self, engine):
        self._engine = weakref.ref(engine)
        self._cache, self._live = ExportCache(), LiveExport()
        self._cache.live = self._live.meshes
        self._skies = LateSkies(_redrawing(self._engine))
        self._cache.texels.skies = self._skies
        self._scene: Scene | None = None
        self._settings: RenderSettings | None = None
        self._camera: Camera | None = None
        self._denoise: tuple[Denoising, int] | None = None
        self._guided = False
        self._shading = AS_RENDERED
        self._drawing = view_picture.PictureDrawing()
        self.failure = ""
        self.warnings: list[str] = []
        self.export_seconds = 0.0
        self.restarts = 0
        self.region, self.pixel_size = 0, 1
        share_cache_dir()
        # The thread must not hold the viewport: it would outlive the region, with its whole scene.
        self.thread = view_thread.ViewThread(_redrawing(self._engine))
        self.thread.start()
        _LIVING.add(self)

    def __del__(self):
        self.close()

    def close(self) -> None:
        """End what runs beside Blender's own thread."""
        self.thread.close()
        self._skies.close()

    def update(self, context, depsgraph) -> None:
        """`view_update`: read what has changed; a click on an object changes nothing."""
        started = time.perf_counter()
        camera = self._seen(context, depsgraph)
        space = context.space_data
        self._shading = shading = view_shading(space.shading)
        self._cache.shown = lambda item: _shown(item, space, shading.lights)
        self._live.begin(depsgraph.updates, depsgraph.scene.frame_current_final)
        warnings: list[str] = []
        scene = export_scene(
            depsgraph,
            warnings=warnings,
            cache=self._cache,
            camera=camera or self._camera or _PLACEHOLDER,
            live=self._live,
            view=shading,
        )
        self.failure, self.warnings = "", warnings
        scene = _replace(scene, camera=_PLACEHOLDER)  # to be compared whatever the view
        if self._scene is not None and same(scene, self._scene):
            scene = self._scene
        self.export_seconds = time.perf_counter() - started
        self._want(scene, depsgraph.scene, camera)

    def fail(self, text: str) -> None:
        """Show a message instead of a picture, until the next update."""
        self.failure, self._scene = text, None
        self.thread.idle()
        self._live.forget()

    def draw(self, context, depsgraph) -> None:
        """`view_draw`: draw the last picture; begin a new one where the view has changed."""
        if self._scene is not None and self._is_outdated(context.space_data):
            self.update(context, depsgraph)
        if self._scene is not None:
            # An add-on's own properties change without an update of the graph, even its copies.
            original, scene = depsgraph.scene, self._scene
            exposure = film_exposure(original)
            if exposure != scene.exposure:
                scene = _replace(scene, exposure=exposure)
            self._want(scene, original, self._seen(context, depsgraph))
        engine = self._engine()
        self.region = context.region.as_pointer()
        picture = None if self.failure else self.thread.picture
        if picture is not None:
            self._drawing.draw(
                engine, depsgraph.scene, picture, self.thread.version, self.pixel_size
            )
        engine.update_stats("", self.line())

    def _is_outdated(self, space) -> bool:
        """Whether there is something to be read that the graph does not tell of."""
        if self._skies.take():
            self._live.forget_world()
            return True
        # Of an add-on's own properties, and of what scripts set, Blender tells nobody.
        return view_shading(space.shading) != self._shading

    def line(self) -> str:
        """What the view says about itself in its corner."""
        if self.failure or self.thread.failure is not None:
            return self.failure or f"IWIS: {self.thread.failure}"
        if self._camera is None and self._scene is not None:
            return "IWIS | nothing to render inside the border"
        picture = self.thread.picture
        if picture is None:
            return "IWIS | Loading; a machine's first render compiles for half a minute"
        sky = " | the Sky Texture is being rendered" if self._skies.waiting else ""
        if self.thread.denoiser.working:
            return f"IWIS | Denoising{sky}"
        if picture.converged:
            return f"IWIS | Done | {_mean_samples(picture):.1f} samples a pixel{sky}"
        if picture.step > 1:
            return f"IWIS | 1/{picture.step} of the pixels{sky}"
        return f"IWIS | Rendering {picture.fraction:.0%}{sky}"

    @property
    def converged(self) -> bool:
        """Whether the picture is all that was asked for, and the thread asleep."""
        picture = self.thread.picture
        return picture is not None and picture.converged and not self.thread.working

    def _seen(self, context, depsgraph) -> Camera | None:
        self.pixel_size = int(self._engine().get_preview_pixel_size(depsgraph.scene))
        return view_camera(
            context.region,
            context.region_data,
            context.space_data,
            depsgraph.scene_eval,
            self.pixel_size,
        )

    def _want(self, scene: Scene, original, camera: Camera | None) -> None:
        """Have this rendered, unless it is what is being rendered. original: Blender's scene"""
        settings, own = viewport_settings(original), original.iwis.viewport
        wanted = denoise_settings(own)
        if scene.asked.shown:  # passes keep their noise
            wanted = dataclasses.replace(wanted, denoise=False)
        denoise = denoising(wanted), own.denoise_start
        if denoise != self._denoise:
            self._denoise = denoise
            self.thread.denoise(*denoise)
        if camera is not None and settings.pixel_filter == "CENTER":
            scatters = scene.shaders is not None and scene.shaders.scatters
            if camera.lens is not None or scatters:  # one point has no blur
                settings = dataclasses.replace(settings, pixel_filter="BOX")
        before = self._scene, self._settings
        unchanged = scene is before[0] and settings == before[1] and same(camera, self._camera)
        if denoise[0].settings.denoise and not self._guided:
            unchanged = False  # the picture that is there keeps nothing for a denoiser
        self._scene, self._settings, self._camera = scene, settings, camera
        if unchanged:
            return
        self.restarts += 1
        self._guided = denoise[0].settings.denoise
        if camera is None:
            self.thread.idle()
            self.thread.picture = None
        else:
            self.thread.request(_replace(scene, camera=camera), settings)


def _redrawing(engine: weakref.ref) -> Callable[[], None]:
    """What has Blender draw the engine's region; to be called by any thread."""

    def redraw() -> None:
        found = engine()
        if found is None:
            raise ReferenceError
        found.tag_redraw()

    return redraw


def _shown(item, space, lights: bool) -> bool:
    """Whether a view shows one of a graph's instances: local view, local collections, lights."""
    if item.object.type == "LIGHT" and not lights:
        return False
    owner = item.parent if item.is_instance and item.parent else item.object
    return owner.original.visible_in_viewport_get(space)


def _mean_samples(picture) -> float:
    """Of the pixels that show an object."""
    samples = picture.layers["samples"]
    return float(samples.sum() / max(np.count_nonzero(samples), 1))


def living() -> list[Viewport]:
    """The viewports that show IWIS now."""
    return list(_LIVING)


def _replace(scene: Scene, **changes) -> Scene:
    """The scene with other fields, without another look at all its triangles."""
    changed = object.__new__(Scene)
    for name in Scene.__slots__:
        object.__setattr__(changed, name, changes.get(name, getattr(scene, name)))
    return changed


_PLACEHOLDER = Camera(
    kind="PERSPECTIVE",
    camera_to_world=None,
    window=(-1.0, 1.0, -1.0, 1.0),
    width=1,
    height=1,
    region=(0, 0, 1, 1),
    clip_start=0.1,
    clip_end=1.0,
)


def _close_all() -> None:
    for viewport in living():
        viewport.close()
    view_thread.close_all()


@persistent
def _on_load_pre(_path=None, _depsgraph=None):
    _close_all()


@persistent
def _on_undo(_scene=None, _depsgraph=None):
    # Undo puts other data where the old was, under the same name and address.
    for viewport in living():
        viewport._live.forget()


_HANDLERS = (("load_pre", _on_load_pre), ("undo_post", _on_undo), ("redo_post", _on_undo))


def register() -> None:
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    for name, handler in reversed(_HANDLERS):
        getattr(bpy.app.handlers, name).remove(handler)
    _close_all()
