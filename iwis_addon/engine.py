"""The engine as Blender sees it: callbacks that delegate, and the only catch-all of errors."""

from __future__ import annotations

import logging

import bpy

from . import callbacks
from .bake import BakeRender
from .dependencies import MissingPackage
from .export import ExportError
from .job import ENGINE, RenderJob
from .leave import end_with_failure, end_without_waiting
from .one_line import one_line
from .output import is_farm_job
from .passes import register_passes
from .preview import PreviewRender, StrokeRender, is_of_strokes
from .session import FinalRender
from .viewport import Viewport

log = logging.getLogger(__name__)

# Failures that say by themselves what is wrong and what to do; others need a traceback.
_SELF_EXPLAINING = (ExportError, MissingPackage, OSError, ValueError)

# Ctrl-C is an exception in the bpy module; left alone, Blender would save and go on.
_CAUGHT = (Exception, KeyboardInterrupt)

_END_SECONDS = 10.0  # compiling for the first time may take as long to let Python run


class IWISRenderEngine(bpy.types.RenderEngine):
    """Direct light of an HDRI, with as many samples a pixel as the eye needs there."""

    bl_idname = ENGINE
    bl_label = "IWIS"
    bl_use_postprocess = True  # or Blender skips compositing
    bl_use_shading_nodes_custom = False  # or Cycles' shader nodes are hidden
    bl_use_eevee_viewport = True  # Material Preview is EEVEE's
    bl_use_preview = True  # thumbnails of materials, worlds and lights
    bl_use_custom_freestyle = True  # or EEVEE renders the lines, for which it needs a GPU
    bl_use_spherical_stereo = False

    viewport: Viewport | None = None  # of an engine object that shows the rendered view

    # Blender counts the arguments of callbacks: no decorator may stand before one.

    def update(self, data=None, depsgraph=None):
        """Export, while Blender keeps its windows still. A failure waits for render()."""
        with callbacks.inside():
            self.failure = None
            if self.is_preview:
                self.session = PreviewRender(self, depsgraph)
            elif RenderJob.rendering and is_of_strokes(depsgraph.scene):
                self.session = StrokeRender(self, depsgraph)
            elif RenderJob.rendering:
                self.session = FinalRender(self, depsgraph, RenderJob.get())
            else:  # only a bake calls update() outside a render
                self.session = BakeRender(self, RenderJob.get())
            try:
                self.session.export(depsgraph)
            except _CAUGHT as error:
                self.failure = error

    def render(self, depsgraph):
        """Render; on any failure deliver a valid result first, then say what is wrong."""
        with callbacks.inside():
            session, self.session = self.session, None
            try:
                if self.failure is not None:
                    raise self.failure
                session.run(depsgraph)
            except _CAUGHT as error:
                self.failure = error
            session.complete()
            self.tell_failure()

    def bake(self, depsgraph, obj, pass_type, pass_filter, width, height):
        """Bake one image of an object, after update(); a failure leaves it black and is told."""
        with callbacks.inside():
            try:
                if self.failure is not None:
                    raise self.failure
                self.session.bake(obj, pass_type, pass_filter, width, height)
            except _CAUGHT as error:
                self.failure = error
            self.tell_failure()

    def view_update(self, context, depsgraph):
        """Read what has changed, for the rendered view; a failure is shown in the view."""
        if self.viewport is None:
            self.viewport = Viewport(self)
        try:
            self.viewport.update(context, depsgraph)
        except Exception as error:
            self.viewport.fail(_message(error))

    def view_draw(self, context, depsgraph):
        """Draw the last picture of the rendered view."""
        if self.viewport is None:
            return
        try:
            self.viewport.draw(context, depsgraph)
        except Exception as error:
            self.viewport.fail(_message(error))

    def update_render_passes(self, scene=None, renderlayer=None):
        register_passes(self, scene, renderlayer)

    def tell_failure(self) -> None:
        """Report a failure to Blender, which then stops the job with exit code 1.

        Only `report` does so, and only after a result. `error_set` shows the text above the picture
        in the window; in background mode it would only print it once more.
        """
        failure, self.failure = self.failure, None
        if failure is None:
            return
        text = _message(failure)
        if self.is_preview:  # a user who edits a material asked for no render
            log.debug("IWIS: a preview failed: %s", text)
            return
        self.report({"ERROR"}, text)
        if is_farm_job():
            # Blender ends with 0 where it was a compositor's other scene that failed. And a thread
            # that lacks memory, too, may never end.
            end = end_with_failure if RenderJob.rendering else end_without_waiting
            end(bpy.app.tempdir)
        if not bpy.app.background:
            self.error_set(text)


def _message(failure: BaseException) -> str:
    """One line for the user; what nobody foresaw is logged with its traceback as well."""
    if isinstance(failure, _SELF_EXPLAINING):
        return one_line(str(failure))
    if isinstance(failure, KeyboardInterrupt):
        return "IWIS: interrupted"
    if isinstance(failure, MemoryError):
        why = str(failure) or "render smaller, or with fewer triangles"
        return f"IWIS: not enough memory: {why}"
    log.error("IWIS: rendering failed", exc_info=failure)
    return one_line(f"IWIS: {type(failure).__name__}: {failure}")


CLASSES = (IWISRenderEngine,)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    callbacks.end_all(_END_SECONDS)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
