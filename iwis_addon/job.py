"""What outlives Blender's engine object, from the start of a render job to its end.

Blender makes a new engine object for every frame, and keeps it only with Persistent Data on
(4.5 and 5.2 alike). So caches that span an animation, and the figures and films that the command
line and the operators read afterwards, are kept here: made by `render_init`, let go by
`render_complete` or `render_cancel`; with Persistent Data they stay until another file is loaded or
the option is turned off.
"""

from __future__ import annotations

import logging
import threading
import time
from dataclasses import dataclass, field
from typing import ClassVar

import bpy
from bpy.app.handlers import persistent

from ..core.film import Film
from ..core.stats import RenderStats
from .export import ExportCache
from .leave import end_with_failure
from .number_film import NumberFilm
from .one_line import one_line
from .output import check_movie, check_saved, has_pixels, is_farm_job, lacks_layers

log = logging.getLogger(__name__)

ENGINE = "IWIS"


@dataclass(frozen=True, slots=True)
class RenderRecord:
    """What one view of one view layer of one frame cost."""

    frame: int
    layer: str
    view: str
    stats: RenderStats


class RenderJob:
    """Caches of a job, what its renders cost, and their films where a user keeps them.

    records: one a frame, view layer and view, in the order of rendering
    films: (view layer, view) -> Film of the last frame, filled with `scene.iwis.keep_film`
    numbers: likewise NumberFilm, filled in a window and with `scene.iwis.keep_film`
    unsaved: what is wrong with the file of a frame of this job, "" where nothing is
    layer_turned_on: a view layer of a farm's scene where none was on, so that the engine can fail
    begun: whether a frame of it has begun
    interrupt: the command line's event; once it is set, all renders end as by a user's Esc
    rendering: the engine that Blender renders with, "" where it does not; a bake is not a render
    around: the engines of the renders that a handler or a scene strip has begun this one inside of
    """

    current: ClassVar[RenderJob | None] = None
    interrupt: ClassVar[threading.Event] = threading.Event()
    rendering: ClassVar[str] = ""
    around: ClassVar[list[str]] = []

    def __init__(self):
        self.records: list[RenderRecord] = []
        self.films: dict[tuple[str, str], Film] = {}
        self.numbers: dict[tuple[str, str], NumberFilm] = {}
        self.unsaved = ""
        self.layer_turned_on = ""
        self.begun = False
        self._warned: set[str] = set()
        self.export_cache = ExportCache()
        self._render_cache = None
        self.mark_rendered()

    @classmethod
    def get(cls) -> RenderJob:
        """The running or last job; a new one if there was none."""
        if cls.current is None:
            cls.current = cls()
        return cls.current

    @classmethod
    def start(cls, keep_caches: bool) -> RenderJob:
        """A new job, with the caches of the one before where they are to be kept."""
        before, cls.current = cls.current, cls()
        if keep_caches and before is not None:
            cls.current.export_cache = before.export_cache
            cls.current._render_cache = before._render_cache
        return cls.current

    def render_cache(self):
        """The core's cache. Imports the core's kernels, so only a render may ask for it."""
        if self._render_cache is None:
            from ..core.render import RenderCache

            self._render_cache = RenderCache()
        return self._render_cache

    def warn(self, lines: list[str]) -> None:
        """Print each warning once a job: the next view layer and frame would only repeat it."""
        for line in lines:
            if line not in self._warned:
                self._warned.add(line)
                log.warning("IWIS: %s", one_line(line))

    def forget_caches(self) -> None:
        """Let the caches go; a render that still holds one keeps its own until it ends."""
        self.export_cache = ExportCache()
        self._render_cache = None

    def mark_rendered(self) -> None:
        """The engine is done; what follows until mark_written() is output: compositing, saving."""
        self._rendered_at = time.perf_counter(), time.process_time()

    def mark_written(self) -> None:
        """Count the time since mark_rendered() as output of the last record."""
        if self.records:
            stats = self.records[-1].stats
            stats.seconds["output"] += time.perf_counter() - self._rendered_at[0]
            stats.cpu_seconds["output"] += time.process_time() - self._rendered_at[1]


@dataclass(slots=True)
class FrameStats:
    """The records of one frame, added up."""

    frame: int
    stats: RenderStats = field(default_factory=RenderStats)

    def add(self, part: RenderStats) -> None:
        """Add one view's figures: counts and seconds add up, size and maximum are the largest."""
        total = self.stats
        total.width, total.height = part.width, part.height
        total.samples_max = max(total.samples_max, part.samples_max)
        total.triangles = max(total.triangles, part.triangles)
        total.cancelled |= part.cancelled
        total.warnings += [line for line in part.warnings if line not in total.warnings]
        total.tables += [line for line in part.tables if line not in total.tables]
        for name in ("shaded_pixels", "samples_total", "primary_rays", "shadow_rays"):
            setattr(total, name, getattr(total, name) + getattr(part, name))
        for phase in total.seconds:
            total.seconds[phase] += part.seconds[phase]
            total.cpu_seconds[phase] += part.cpu_seconds[phase]


def stats_by_frame(records: list[RenderRecord]) -> list[FrameStats]:
    """One FrameStats a frame, in the order of rendering."""
    frames: dict[int, FrameStats] = {}
    for record in records:
        frames.setdefault(record.frame, FrameStats(record.frame)).add(record.stats)
    return list(frames.values())


@persistent
def _on_render_init(scene, _depsgraph=None):
    RenderJob.around.append(RenderJob.rendering)
    if scene.render.engine == ENGINE:
        job = RenderJob.start(keep_caches=scene.render.use_persistent_data)
        if is_farm_job() and scene.render.is_movie_format:
            # Blender says why it cannot begin a movie, and ends with 0.
            end_with_failure(bpy.app.tempdir, unless=lambda: job.begun)
        if is_farm_job() and not has_pixels(scene.render):
            log.error("IWIS: the picture has no pixels: raise Resolution %, or enlarge the border")
            end_with_failure(bpy.app.tempdir)
    elif RenderJob.current is not None:
        RenderJob.current.forget_caches()


@persistent
def _on_render_pre(scene, _depsgraph=None):
    # Not at render_init: a movie that cannot be begun has no end that handlers are told of.
    RenderJob.rendering = scene.render.engine
    if scene.render.engine != ENGINE:
        return
    RenderJob.get().begun = True
    # The frame's own values are there: Use for Rendering may be animated.
    if is_farm_job() and lacks_layers(scene):
        layer = scene.view_layers[0]
        layer.use = True
        RenderJob.get().layer_turned_on = layer.name


@persistent
def _on_render_post(_scene, _depsgraph=None):
    # Blender calls this after it has saved the frame.
    if RenderJob.current is not None:
        RenderJob.current.mark_written()


@persistent
def _on_render_write(scene, _depsgraph=None):
    # Scene strips that were rendered for this picture have ended jobs of their own.
    if scene.render.engine == ENGINE:
        _check(check_saved, scene)


def _check(saved, scene) -> None:
    """Make a failure of the job's process of what saved(scene) finds; its next frame then fails."""
    job = RenderJob.get()
    try:
        saved(scene)
    except OSError as error:
        if bpy.app.background and not job.unsaved:  # Blender would end with 0
            end_with_failure(bpy.app.tempdir)
        job.unsaved = f"IWIS: {error}"
        log.error(job.unsaved)


@persistent
def _on_render_end(scene, _depsgraph=None):
    RenderJob.rendering = RenderJob.around.pop() if RenderJob.around else ""
    job = RenderJob.current
    if job is not None and job.layer_turned_on in scene.view_layers:
        scene.view_layers[job.layer_turned_on].use = False
    if job is not None and job.begun and scene.render.engine == ENGINE and is_farm_job():
        _check(check_movie, scene)
    if job is not None and not scene.render.use_persistent_data:
        job.forget_caches()


@persistent
def _on_load(_path=None, _depsgraph=None):
    RenderJob.current = None
    RenderJob.around.clear()


_HANDLERS = (
    ("render_init", _on_render_init),
    ("render_pre", _on_render_pre),
    ("render_post", _on_render_post),
    ("render_write", _on_render_write),
    ("render_complete", _on_render_end),
    ("render_cancel", _on_render_end),
    ("load_pre", _on_load),
)


def register() -> None:
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    for name, handler in reversed(_HANDLERS):
        getattr(bpy.app.handlers, name).remove(handler)
    RenderJob.current = None
