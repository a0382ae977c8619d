"""What a 3D view's shading menu has a window show otherwise than a render."""

from __future__ import annotations

from typing import NamedTuple


class StudioLight(NamedTuple):
    """The HDRI that lights a view in place of the scene's world, as Cycles has it.

    path: of its file; rotation: radians about z; strength: its factor
    opacity: of it before the camera, over the world's plain color
    """

    path: str
    rotation: float = 0.0
    strength: float = 1.0
    opacity: float = 1.0


class ViewShading(NamedTuple):
    """lights: whether the scene's lamps are there; studio: what stands for its world, None = it is
    there itself; shown: of core.data.asked_passes.AskedPasses; colors: the layer of core.film that
    is drawn in false color over the picture, "" = none."""

    lights: bool = True
    studio: StudioLight | None = None
    shown: str = ""
    colors: str = ""


AS_RENDERED = ViewShading()
