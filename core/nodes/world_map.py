"""A world's program over all directions: the texels of an equirectangular map.

Texel (i, j) of (h, 2h) looks along v = (i + 1/2) / h, u = (j + 1/2) / 2h (environment.py). Where
neighbours differ much, a texel is the mean of several directions inside it: an edge or a speck that
one direction would miss or take whole has the light that it has. Rows go in blocks, so that an 8K
map takes little more memory than its texels.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..data.program import Op, Program, Ref, Value
from .evaluate import Evaluation
from .world import ENVIRONMENT, WorldContext

_BLOCK = 1 << 15  # directions at once: their arrays stay in a core's cache
# Of the brighter of two neighbours: less is no edge, a map that is interpolated shows it well.
# Of what is darker than the mean, a part of that: it lights nothing.
_CONTRAST = np.float32(0.1)
_FINE, _COARSE = 4, 2  # directions along a side of a texel; the coarse where many texels ask
_MANY = 0.05


def reached_ops(program: Program, value: Value) -> dict[int, Op]:
    """The operations that a value depends on, by row."""
    found: dict[int, Op] = {}
    waiting = [value]
    while waiting:
        value = waiting.pop()
        if isinstance(value, Ref) and value.op not in found:
            found[value.op] = program.ops[value.op]
            waiting.extend(found[value.op].inputs.values())
    return found


def ready(program: Program, value: Value) -> Program:
    """The program with the lookups of the images that a value needs."""
    # Here and not above: the add-on imports this before numba is known to be there.
    from ..light.environment import make_lookup

    ops = list(program.ops)
    for row, op in reached_ops(program, value).items():
        if op.kind == ENVIRONMENT:
            lookup = make_lookup(op.settings["map"])
            ops[row] = op._replace(settings={**op.settings, "lookup": lookup})
    return dataclasses.replace(program, ops=tuple(ops))


def evaluate_directions(program: Program, value: Value, directions: np.ndarray) -> np.ndarray:
    """float32 (n, 3): the colour in each direction, 0 for what is no number.

    program: made ready; directions: float32 (n, 3), unit
    """
    return Evaluation(program, WorldContext(np.ascontiguousarray(directions))).vector(value)


def evaluate_texels(
    program: Program, value: Value, images: Mapping[int, np.ndarray], threads: int = 1
) -> np.ndarray:
    """float32 (h, w, 3): the colour where each texture gives the texel of its own image.

    images: row of the operation of each Environment Texture -> float32 (h, w, 3), all of one size
    """
    height, width, _ = next(iter(images.values())).shape
    out = np.empty((height, width, 3), np.float32)

    def fill(first, last):
        known = {
            row: {"Color": texels[first:last].reshape(-1, 3)} for row, texels in images.items()
        }
        context = WorldContext(np.zeros(((last - first) * width, 3), np.float32))
        part = Evaluation(program, context, known).vector(value)
        out[first:last] = part.reshape(-1, width, 3)

    _in_blocks(fill, height, max(1, _BLOCK // width), threads, lambda: None)
    return out


def evaluate_map(
    program: Program,
    value: Value,
    height: int,
    *,
    has_edges: bool,
    threads: int = 1,
    pause: Callable[[], None] = lambda: None,
) -> np.ndarray:
    """float32 (height, 2 * height, 3), row 0 looks along -z.

    has_edges: whether neighbours that differ are looked at more closely
    pause(): called every few milliseconds by the caller's thread; may raise to stop
    """
    out = np.empty((height, 2 * height, 3), np.float32)
    program = ready(program, value)

    def fill(first, last):
        rows = np.arange(first, last) + 0.5
        directions = _directions(rows[:, None], np.arange(2 * height) + 0.5, height)
        colors = evaluate_directions(program, value, directions.reshape(-1, 3))
        out[first:last] = colors.reshape(-1, 2 * height, 3)

    _in_blocks(fill, height, max(1, _BLOCK // (2 * height)), threads, pause)
    if has_edges:
        _refine(program, value, out, threads, pause)
    return out


def _refine(program, value, out, threads, pause):
    """Replace texels at edges by the mean over several directions inside of them."""
    height, width, _ = out.shape
    rows, columns = np.nonzero(_edges(out))
    side = _COARSE if len(rows) > _MANY * height * width else _FINE
    inside = (np.arange(side) + 0.5) / side
    up, right = (a.ravel() for a in np.meshgrid(inside, inside, indexing="ij"))

    def fill(first, last):
        i, j = rows[first:last], columns[first:last]
        directions = _directions(i[:, None] + up, j[:, None] + right, height)
        colors = evaluate_directions(program, value, directions.reshape(-1, 3))
        out[i, j] = colors.reshape(len(i), -1, 3).mean(1)

    _in_blocks(fill, len(rows), _BLOCK // (side * side), threads, pause)


def _edges(texels) -> np.ndarray:
    """bool (h, w): texels that differ much from the next one to a side or above or below."""
    found = np.zeros(texels.shape[:2], np.bool_)
    dark = np.abs(texels).mean(dtype=np.float32)
    for rows in range(0, len(texels), 64):
        part = texels[rows : rows + 65]
        here = found[rows : rows + 65]
        differ = _differ(part, np.roll(part, -1, 1), dark)
        here |= differ | np.roll(differ, 1, 1)
        differ = _differ(part[:-1], part[1:], dark)
        here[:-1] |= differ
        here[1:] |= differ
    return found


def _differ(a, b, dark):
    return (np.abs(a - b) > _CONTRAST * np.maximum(np.maximum(np.abs(a), np.abs(b)), dark)).any(-1)


def _directions(row, column, height) -> np.ndarray:
    """float32 (..., 3): along which a place in the map looks, in texels from its lower left."""
    latitude = (row / height - 0.5) * np.pi
    longitude = (0.5 - column / (2 * height)) * (2.0 * np.pi)
    level = np.cos(latitude)
    parts = np.broadcast_arrays(
        level * np.cos(longitude), level * np.sin(longitude), np.sin(latitude)
    )
    return np.stack(parts, -1).astype(np.float32)


def _in_blocks(fill, n, step, threads, pause):
    """fill(first, last) for all of n, a few in threads at a time."""
    spans = [(first, min(first + step, n)) for first in range(0, n, step)]
    if threads <= 1 or len(spans) < 2:
        for span in spans:
            pause()
            fill(*span)
        return
    with ThreadPoolExecutor(threads) as pool:
        try:
            for _ in pool.map(lambda span: fill(*span), spans):
                pause()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
