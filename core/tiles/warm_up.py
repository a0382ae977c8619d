"""Has all kernels of a render at hand before a clock runs: a machine's first render compiles them.

A few pixels that show an object are rendered and thrown away.
"""

from __future__ import annotations

import numpy as np

from ..camera.camera import rays_through
from .sample_plan import planned_counts, typical_for_rays
from .tile_job import Job, Rect, trace_points

_SIDE = 24  # the region is searched in so many columns and rows


def warm_up(job: Job, make_tile) -> None:
    """Look, plan, go on and develop once. make_tile(job, rect): the work at a tile"""
    rect = _pixel_with_an_object(job)
    if rect is None:
        return
    tile = make_tile(job, rect)
    tile.look(4.0, 1)
    demand = tile.demand(4.0)
    typical = typical_for_rays([demand], 4.0 * demand.shaded, 4)
    tile.go_to(planned_counts(demand, typical, 4), typical)
    tile.develop()
    tile.counts()


def _pixel_with_an_object(job: Job) -> Rect | None:
    """The first there is of a coarse grid over the region."""
    x0, y0, x1, y1 = job.scene.camera.region
    steps = (np.arange(_SIDE) + 0.5) / _SIDE
    columns, rows = (x0 + steps * (x1 - x0)).astype(int), (y0 + steps * (y1 - y0)).astype(int)
    columns, rows = (grid.ravel() for grid in np.meshgrid(columns, rows))
    found = trace_points(job, rays_through(job.scene.camera, columns + 0.5, rows + 0.5)).pixel
    return Rect(int(columns[found[0]]), int(rows[found[0]]), 1, 1) if len(found) else None
