"""Sparse Haar series, one for each slice of a table, as quadtrees.

A node is a square that has a coefficient, or has one below it. It holds the three details, the
mean over the square (so a walk needs no sums from above) and its four children. [Ng04] proves what
haar_product does with two of them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from .haar import haar_forward

NO_CHILD = -1


class HaarForest(NamedTuple):
    """Series of n slices with c channels, float32 but root and child.

    root: int32 (n,), the node of the whole square, NO_CHILD for a constant slice
    slice_mean: (n, c), the scaling coefficients
    mean: (m, c), average over the node's square; detail: (m, 3, c), its h, v, d coefficients
    child: int32 (m, 4), nodes of the quadrants TL, TR, BL, BR
    """

    root: np.ndarray
    slice_mean: np.ndarray
    mean: np.ndarray
    detail: np.ndarray
    child: np.ndarray

    @property
    def nbytes(self) -> int:
        return sum(array.nbytes for array in self)


@kernel
def _largest(values, n, k, work):
    """The k-th largest of values[0 ... n - 1] (quickselect); work: scratch of the same length."""
    for i in range(n):
        work[i] = values[i]
    low, high, target = 0, n - 1, k - 1
    while low < high:
        pivot = work[(low + high) // 2]
        i, j = low, high
        while i <= j:
            while work[i] > pivot:
                i += 1
            while work[j] < pivot:
                j -= 1
            if i <= j:
                work[i], work[j] = work[j], work[i]
                i += 1
                j -= 1
        if target <= j:
            high = j
        elif target >= i:
            low = i
        else:
            break
    return work[target]


@kernel
def _truncate(coefficients, keep, magnitude, work):
    """Zero all but the mean and the keep - 1 largest coefficients (largest over all channels)."""
    channels, n = coefficients.shape
    for k in range(n):
        total = np.float32(0.0)
        for c in range(channels):
            total += coefficients[c, k] * coefficients[c, k]
        magnitude[k] = total
    magnitude[0] = np.inf
    if keep >= n:
        return
    threshold = _largest(magnitude, n, keep, work)
    left = keep
    for k in range(n):
        if magnitude[k] > threshold:
            left -= 1
    for k in range(n):
        if magnitude[k] < threshold or (magnitude[k] == threshold and left <= 0):
            for c in range(channels):
                coefficients[c, k] = 0.0
        elif magnitude[k] == threshold:
            left -= 1


@kernel
def _mark_squares(coefficients, levels, marked):
    """marked[(4^l - 1) / 3 + i 2^l + j] = whether the square or one below has a coefficient."""
    channels = coefficients.shape[0]
    for level in range(levels - 1, -1, -1):
        side = 1 << level
        here, below = ((1 << (2 * level)) - 1) // 3, ((1 << (2 * level + 2)) - 1) // 3
        for i in range(side):
            for j in range(side):
                base = side * side + 3 * (i * side + j)
                found = False
                for c in range(channels):
                    for t in range(3):
                        if coefficients[c, base + t] != 0.0:
                            found = True
                if level + 1 < levels:
                    for q in range(4):
                        row, column = 2 * i + (q >> 1), 2 * j + (q & 1)
                        if marked[below + row * 2 * side + column]:
                            found = True
                marked[here + i * side + j] = found


@kernel
def _add_nodes(coefficients, levels, marked, first, mean, detail, child, places):
    """Write the nodes of one slice, breadth first; returns one past the last."""
    channels = coefficients.shape[0]
    if not marked[0]:
        return first
    places[first, 0], places[first, 1], places[first, 2] = 0, 0, 0
    for c in range(channels):
        mean[first, c] = coefficients[c, 0]
    end, node = first + 1, first
    while node < end:
        level, i, j = places[node, 0], places[node, 1], places[node, 2]
        side = 1 << level
        base = side * side + 3 * (i * side + j)
        for c in range(channels):
            for t in range(3):
                detail[node, t, c] = coefficients[c, base + t]
        below = ((1 << (2 * level + 2)) - 1) // 3
        for q in range(4):
            child[node, q] = NO_CHILD
            row, column = 2 * i + (q >> 1), 2 * j + (q & 1)
            if level + 1 < levels and marked[below + row * 2 * side + column]:
                child[node, q] = end
                places[end, 0], places[end, 1], places[end, 2] = level + 1, row, column
                sign_h = np.float32(1.0) if (q & 1) == 0 else np.float32(-1.0)
                sign_v = np.float32(1.0) if q < 2 else np.float32(-1.0)
                for c in range(channels):
                    mean[end, c] = mean[node, c] + side * (
                        sign_h * detail[node, 0, c]
                        + sign_v * detail[node, 1, c]
                        + sign_h * sign_v * detail[node, 2, c]
                    )
                end += 1
        node += 1
    return end


@kernel(allocates=True)
def _build(grids, keep, levels, root, slice_mean, mean, detail, child, places, first):
    """Write the trees of some slices from node ``first`` on; returns one past the last node."""
    n_slices, channels, side, _ = grids.shape
    coefficients = np.empty((channels, side * side), np.float32)
    scratch = np.empty((side, side), np.float32)
    magnitude = np.empty(side * side, np.float32)
    work = np.empty(side * side, np.float32)
    marked = np.empty((side * side - 1) // 3, np.bool_)
    node = first
    for s in range(n_slices):
        for c in range(channels):
            haar_forward(grids[s, c], scratch, coefficients[c])
            slice_mean[s, c] = coefficients[c, 0]
        _truncate(coefficients, keep, magnitude, work)
        _mark_squares(coefficients, levels, marked)
        end = _add_nodes(coefficients, levels, marked, node, mean, detail, child, places)
        root[s] = node if end > node else NO_CHILD
        node = end
    return node


def build_forest(grids: np.ndarray, fraction: float) -> HaarForest:
    """The largest ``fraction`` of each slice's Haar coefficients.

    grids: float32 (n, c, side, side), cell averages, side = 2^levels; overwritten as scratch
    """
    n_slices, channels, side, _ = grids.shape
    levels = int(side).bit_length() - 1
    keep = max(1, round(fraction * side * side))
    # A coefficient brings at most its ancestors: levels nodes each, and never more than squares.
    capacity = n_slices * min(keep * levels + 1, (side * side - 1) // 3)
    root = np.empty(n_slices, np.int32)
    slice_mean = np.empty((n_slices, channels), np.float32)
    mean = np.empty((capacity, channels), np.float32)
    detail = np.empty((capacity, 3, channels), np.float32)
    child = np.empty((capacity, 4), np.int32)
    places = np.empty((capacity, 3), np.int32)
    end = _build(grids, keep, levels, root, slice_mean, mean, detail, child, places, 0)
    return HaarForest(root, slice_mean, mean[:end].copy(), detail[:end].copy(), child[:end].copy())


def join_forests(forests: list[HaarForest]) -> HaarForest:
    """One forest of all slices, in order; the channels must agree."""
    shift, roots, children = 0, [], []
    for forest in forests:
        roots.append(np.where(forest.root >= 0, forest.root + shift, NO_CHILD))
        children.append(np.where(forest.child >= 0, forest.child + shift, NO_CHILD))
        shift += len(forest.mean)
    return HaarForest(
        np.concatenate(roots).astype(np.int32),
        np.concatenate([forest.slice_mean for forest in forests]),
        np.concatenate([forest.mean for forest in forests]),
        np.concatenate([forest.detail for forest in forests]),
        np.concatenate(children).astype(np.int32),
    )


def with_channels(forest: HaarForest, channels: int) -> HaarForest:
    """The forest with ``channels`` equal channels in place of its one, or as it is."""
    if forest.slice_mean.shape[1] == channels:
        return forest
    wide = {
        name: np.repeat(getattr(forest, name), channels, axis=-1)
        for name in ("slice_mean", "mean", "detail")
    }
    return forest._replace(**wide)
