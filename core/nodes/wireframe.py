"""The Wireframe node: 1 near one of the three edges of the triangle, else 0.

Points, strands, lamps and worlds have no wires, as in Cycles.
"""

from __future__ import annotations

import numpy as np

from ..camera.panorama_places import panorama_places, space_axes
from ..data.rows import any_in_row
from .element_info import element_number
from .values import as_number, column, dot, length, normalized

# What tells of points and strands, which are triangles here, but not in Cycles.
OF_ELEMENTS = ("Is Strand", "Radius")


def wireframe(context, settings, inputs):
    """settings: use_pixel_size, whether Size is of pixels, not of metres"""
    corners, n = context.corners, len(context)
    if corners is None:
        return {"Fac": np.zeros(n, np.float32)}
    # Half of the width: the face beside has the other half.
    reach = np.float32(0.5) * as_number(inputs["Size"], n)
    if settings["use_pixel_size"]:
        reach = reach * _pixel_widths(context)
    near = np.zeros(n, np.bool_)
    for k in range(3):
        edge = corners[:, k] - corners[:, k - 1]
        across = np.cross(edge, context.position - corners[:, k])
        near |= dot(across, across) < dot(edge, edge) * reach * reach
    for name in OF_ELEMENTS:
        near &= element_number(context, name) == 0.0
    return {"Fac": near.astype(np.float32)}


def _pixel_widths(context) -> np.ndarray:
    """float32 (n,), metres: of the mean of two lines in the plane of the face, as long as a pixel
    is wide there, what is seen of them."""
    widths = [
        length(line - column(dot(line, context.wo)) * context.wo)
        for line in context.tangents(_ray_widths(context))
    ]
    return (0.5 * (widths[0] + widths[1])).astype(np.float32)


def _ray_widths(context) -> np.ndarray:
    """float32 (n,), metres between the rays of two pixels at each point: the mean of both ways."""
    camera, distance = context.camera, length(context.camera_position)
    if camera.kind == "ORTHOGRAPHIC":
        return context.footprint
    left, right, bottom, top = camera.window
    steps = (right - left) / camera.width, (top - bottom) / camera.height
    spread = _spread_on_panorama if camera.kind == "PANORAMIC" else _spread_on_plane
    return (0.5 * spread(context, steps) * distance).astype(np.float32)


def _spread_on_plane(context, steps) -> np.ndarray:
    """(n,): the lengths of what directions differ by that are steps apart, added up."""
    place = context.camera_position
    away = place / np.maximum(np.abs(place[:, 2:]), np.float32(1e-20))
    own, wide = normalized(away), 0.0
    for axis, step in enumerate(steps):
        aside = away.copy()
        aside[:, axis] += np.float32(step)
        wide = wide + length(normalized(aside) - own)
    return wide


def _spread_on_panorama(context, steps) -> np.ndarray:
    """The same of a panorama's directions."""
    from ..camera.panorama import panorama_directions  # a kernel: the exporters load without numba

    panorama = context.camera.panorama
    own = normalized(context.camera_position) @ space_axes(context.camera)[:3, :3].T
    u, v = panorama_places(panorama, own).T
    right = panorama_directions(panorama, u + steps[0], v)
    above = panorama_directions(panorama, u, v + steps[1])
    # Beyond the lens nothing is as wide as a pixel: no wires beside its edge, as in Cycles.
    beyond = ~(any_in_row(right) & any_in_row(above))
    return np.where(beyond, 0.0, length(right - own) + length(above - own))


FUNCTIONS = {"ShaderNodeWireframe": wireframe}
