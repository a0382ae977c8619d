"""render(scene, settings, sink): the entry point of the core."""

from __future__ import annotations

from .film import TileSink
from .scene import Scene
from .settings import RenderSettings
from .stats import RenderStats


class RenderCache:
    """What may be kept from one render to the next: BVH, environment, tables."""


def render(
    scene: Scene, settings: RenderSettings, sink: TileSink, cache: RenderCache | None = None
) -> RenderStats:
    """Deliver every tile of the camera's region to the sink and return what it cost."""
    raise RuntimeError("the sampler lands within the hour")
