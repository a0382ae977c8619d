"""The Voronoi Texture node: distances to random points, one in each cell of a grid."""

from __future__ import annotations

import numpy as np

from .noise import noise_place
from .values import as_number, divided, mixed


def _distance(way, metric, exponent):
    a = np.abs(way)
    if metric == "EUCLIDEAN" or len(way) == 1:
        return np.sqrt((a * a).sum(0))
    if metric == "MANHATTAN":
        return a.sum(0)
    if metric == "CHEBYCHEV":
        return a.max(0)
    return np.power(np.power(a, exponent).sum(0), 1.0 / exponent)


def _kernels():
    """The exporters load without numba."""
    from ..textures import voronoi_cells

    return voronoi_cells


class _Cells:
    """One octave's look-ups, of p, float32 (d, n); numbers of the points are float32 (n,)."""

    def __init__(self, metric, randomness, exponent, smoothness, before=False):
        """before: whether cells are those of before Blender 5"""
        self.metric, self.randomness = metric, randomness
        self.exponent, self.smoothness = exponent, smoothness
        self.before = (0,) if before else ()

    def nearest(self, p, second=False):
        """(distance, colour, position) of the nearest point, or of the second nearest."""
        own, look, (color, position) = _taken(p), self._look(p), _room(p)
        distances, ranks = _rows(2, p), _rows(2, p, np.int32)
        _kernels().find_nearest(own, look, distances, ranks)
        k = int(second)
        _kernels().fill_points(own, look, ranks[k], color, position)
        return distances[k], np.stack(color, -1), np.stack(position[: len(p)])

    def smooth(self, p):
        (color, position), (distance,) = _room(p), _rows(1, p)
        _kernels().smooth_points(_taken(p), self._look(p), distance, color, position)
        return distance, np.stack(color, -1), np.stack(position[: len(p)])

    def edge(self, p):
        """Distance to the nearest border between two cells."""
        (distance,) = _rows(1, p)
        own = self.randomness, self.before
        _kernels().border_distances(_taken(p), *own, _rows(5, p), distance)
        return distance

    def radius(self, p):
        """Half the way from the nearest point to the point nearest to that."""
        own = self.randomness, self.exponent, self.smoothness, self.before
        plain = _Cells("EUCLIDEAN", *own)
        _, _, point = plain.nearest(p)
        (radius,) = _rows(1, p)
        _kernels().point_radii(_taken(point), self.randomness, self.before, radius)
        return radius

    def _look(self, p):
        kernels = _kernels()
        metric = kernels.METRICS[self.metric if len(p) > 1 else "EUCLIDEAN"]
        numbers = self.randomness, self.exponent, self.smoothness
        return kernels.Look(metric, self.before, *numbers, *_rows(1, p))


def _taken(p) -> tuple[np.ndarray, ...]:
    """As kernels take it."""
    p = np.nan_to_num(np.asarray(p, np.float32), posinf=0.0, neginf=0.0)
    return tuple(np.ascontiguousarray(row) for row in p)


def _room(p):
    """For colours and places."""
    return _rows(3, p), _rows(4, p)


def _rows(count, p, dtype=np.float32) -> tuple[np.ndarray, ...]:
    """Room for a number of each point, ``count`` times."""
    return tuple(np.empty((count, p.shape[1]), dtype))


def _largest(cells, d, second):
    corner = np.broadcast_to(0.5 + 0.5 * cells.randomness, (d, len(cells.randomness)))
    return _distance(corner, cells.metric, cells.exponent) * (2.0 if second else 1.0)


def _octaves(detail):
    return range(int(np.ceil(detail.max(initial=0.0))) + 1)


def _sum_of_octaves(look_up, p, detail, roughness, lacunarity):
    """(distance, colour, position, greatest amplitude), octaves added up as in Cycles."""
    n = p.shape[1]
    plain = (detail == 0.0) | (roughness == 0.0)
    amplitude, most, scale = np.ones(n, np.float32), np.zeros(n, np.float32), np.ones(n, np.float32)
    total, color = np.zeros(n, np.float32), np.zeros((n, 3), np.float32)
    position = np.zeros_like(p)
    rest = detail - np.floor(detail)
    for k in _octaves(detail):
        distance, new, place = look_up(p * scale)
        if k == 0 and plain.all():
            return distance, new, place, np.ones(n, np.float32)
        # Full octaves count whole; the one after them by the detail's fraction; later ones not.
        share = np.where(k <= detail, 1.0, np.where(k < detail + 1.0, rest, 0.0))
        share = np.where(plain, float(k == 0), share).astype(np.float32)
        most = most + share * amplitude
        total = total + share * amplitude * distance
        color = color + (share * amplitude)[:, None] * new
        position = mixed(position, mixed(position, place / scale, amplitude), share)
        scale, amplitude = scale * lacunarity, amplitude * roughness
    return total, color, position, most


def _edge_of_octaves(cells, p, detail, roughness, lacunarity, largest):
    plain = (detail == 0.0) | (roughness == 0.0)
    n = p.shape[1]
    amplitude, scale = np.ones(n, np.float32), np.ones(n, np.float32)
    most, total = largest, np.full(n, 8.0, np.float32)
    rest = detail - np.floor(detail)
    for k in _octaves(detail):
        distance = cells.edge(p * scale)
        if k == 0:
            first = distance
        full = mixed(total, np.minimum(total, distance / scale), amplitude)
        full_most = mixed(most, largest / scale, amplitude)
        share = np.where(k <= detail, 1.0, np.where(k < detail + 1.0, rest, 0.0)).astype(np.float32)
        partly = mixed(total, np.minimum(total, full), share)
        total = np.where(k <= detail, full, partly)
        most = mixed(most, full_most, share)
        scale, amplitude = scale * lacunarity, amplitude * roughness
    return np.where(plain, first, total), np.where(plain, largest, most)


def voronoi_texture(context, settings, inputs):
    n = len(context)
    scale = as_number(inputs["Scale"], n)
    p = noise_place(context, inputs, settings["voronoi_dimensions"]) * scale

    def number(name, otherwise=0.0):
        return as_number(inputs.get(name, np.float32(otherwise)), n)

    detail, roughness = np.clip(number("Detail"), 0.0, 15.0), np.clip(number("Roughness"), 0.0, 1.0)
    smoothness = np.clip(number("Smoothness") / 2.0, 0.0, 0.5)
    cells = _Cells(
        settings["distance"],
        np.clip(number("Randomness"), 0.0, 1.0),
        number("Exponent", 1.0),
        smoothness,
        settings.get("before", False),
    )
    feature, normalize = settings["feature"], settings["normalize"]
    if feature == "N_SPHERE_RADIUS":
        return {"Radius": cells.radius(p)}
    octaves = detail, roughness, number("Lacunarity", 2.0)
    if feature == "DISTANCE_TO_EDGE":
        largest = 0.5 + 0.5 * cells.randomness
        distance, most = _edge_of_octaves(cells, p, *octaves, largest)
        return {"Distance": distance / most if normalize else distance}
    look_up = {
        "F1": cells.nearest,
        "F2": lambda q: cells.nearest(q, second=True),
        "SMOOTH_F1": lambda q: cells.nearest(q) if not smoothness.any() else cells.smooth(q),
    }[feature]
    distance, color, position, most = _sum_of_octaves(look_up, p, *octaves)
    if normalize:
        distance = distance / (most * _largest(cells, len(p), feature == "F2"))
        color = color / most[:, None]
    position = divided(position, scale)
    outputs = {"Distance": distance, "Color": color}
    padded = np.zeros((4, n), np.float32)
    padded[3 if len(p) == 1 else slice(0, len(p))] = position[0] if len(p) == 1 else position
    return outputs | {"Position": padded[:3].T, "W": padded[3]}


FUNCTIONS = {"ShaderNodeTexVoronoi": voronoi_texture}
