"""The Voronoi Texture node: distances to random points, one in each cell of a grid."""

from __future__ import annotations

import itertools

import numpy as np

from .hashing import hash_cell, hash_flat_cell, hash_numbers
from .noise import noise_place
from .values import as_number, divided, mixed


def _point(cell, randomness):
    """The point of a cell, from its corner: float32 (d, n)."""
    if len(cell) == 1:
        return hash_numbers(cell[0])[None] * randomness
    if len(cell) == 2:
        return hash_flat_cell(cell) * randomness
    return hash_cell(cell)[: len(cell)] * randomness


def _distance(way, metric, exponent):
    a = np.abs(way)
    if metric == "EUCLIDEAN" or len(way) == 1:
        return np.sqrt((a * a).sum(0))
    if metric == "MANHATTAN":
        return a.sum(0)
    if metric == "CHEBYCHEV":
        return a.max(0)
    return np.power(np.power(a, exponent).sum(0), 1.0 / exponent)


def _offsets(d, reach):
    """Neighbours of a cell; x runs fastest, as in Cycles: ties go to the first."""
    for offset in itertools.product(range(-reach, reach + 1), repeat=d):
        yield np.float32(offset[::-1])[:, None]


class _Cells:
    """One octave's look-ups. randomness, exponent, smoothness: float32 (n,)"""

    def __init__(self, metric, randomness, exponent, smoothness):
        self.metric, self.randomness = metric, randomness
        self.exponent, self.smoothness = exponent, smoothness

    def _points(self, p, reach):
        cell = np.floor(p)
        local = p - cell
        for offset in _offsets(len(p), reach):
            point = offset + _point(cell + offset, self.randomness)
            yield cell, local, offset, point

    def nearest(self, p, second=False):
        """(distance, colour, position) of the nearest point, or of the second nearest."""
        n, d = p.shape[1], len(p)
        best = [np.full(n, np.finfo(np.float32).max, np.float32) for _ in range(2)]
        offsets = [np.zeros((d, n), np.float32) for _ in range(2)]
        points = [np.zeros((d, n), np.float32) for _ in range(2)]
        cell = np.floor(p)
        for _, local, offset, point in self._points(p, 1):
            distance = _distance(point - local, self.metric, self.exponent)
            first = distance < best[0]
            next_ = ~first & (distance < best[1])
            for old, new in ((offsets, offset), (points, point)):
                old[1] = np.where(first, old[0], np.where(next_, new, old[1]))
                old[0] = np.where(first, new, old[0])
            best[1] = np.where(first, best[0], np.where(next_, distance, best[1]))
            best[0] = np.where(first, distance, best[0])
        k = int(second)
        return best[k], _color(cell + offsets[k]), points[k] + cell

    def smooth(self, p):
        distance = h = None
        total = np.zeros(p.shape[1], np.float32)
        color = np.zeros((p.shape[1], 3), np.float32)
        position = np.zeros_like(p)
        for cell, local, offset, point in self._points(p, 2):
            distance = _distance(point - local, self.metric, self.exponent)
            if h is None:
                h = np.ones_like(total)
            else:
                h = np.clip(0.5 + 0.5 * (total - distance) / self.smoothness, 0.0, 1.0)
                h = h * h * (3.0 - 2.0 * h)
            correction = self.smoothness * h * (1.0 - h)
            total = mixed(total, distance, h) - correction
            correction = correction / (1.0 + 3.0 * self.smoothness)
            new = _color(cell + offset)
            color = mixed(color, new, h[:, None]) - correction[:, None]
            position = mixed(position, point, h) - correction
        return total, color, cell + position

    def edge(self, p):
        """Distance to the nearest border between two cells."""
        if len(p) == 1:
            cell = np.floor(p)
            local = (p - cell)[0]
            middle, left, right = (
                k + hash_numbers((cell + np.float32(k))[0]) * self.randomness
                for k in (0.0, -1.0, 1.0)
            )
            to_left, to_right = (np.abs((middle + x) / 2.0 - local) for x in (left, right))
            return np.minimum(to_left, to_right)
        ways = np.stack([point - local for _, local, _, point in self._points(p, 1)])
        squared = (ways * ways).sum(1)
        nearest = np.take_along_axis(ways, squared.argmin(0)[None, None], 0)[0]
        across = ways - nearest
        size = (across * across).sum(1)
        unit = across / np.sqrt(np.maximum(size, 1e-20))[:, None]
        distance = ((nearest + ways) / 2.0 * unit).sum(1)
        return np.where(size > 0.0001, distance, np.finfo(np.float32).max).min(0)

    def radius(self, p):
        """Half the way from the nearest point to the point nearest to that."""
        plain = _Cells("EUCLIDEAN", self.randomness, self.exponent, self.smoothness)
        _, _, point = plain.nearest(p)
        cell = np.floor(point)
        exact = np.full(p.shape[1], np.finfo(np.float32).max, np.float32)
        for offset in _offsets(len(p), 1):
            if not offset.any():
                continue
            other = cell + offset + _point(cell + offset, self.randomness)
            way = other - point
            exact = np.minimum(exact, np.sqrt((way * way).sum(0)))
        return exact / 2.0


def _color(cell):
    return hash_cell(cell)[:3].T


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
