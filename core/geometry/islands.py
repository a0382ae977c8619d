"""Islands of a mesh: sets of vertices that edges join."""

from __future__ import annotations

import numpy as np

from .._jit import kernel


@kernel
def _root(parents, vertex):
    root = vertex
    while parents[root] != root:
        root = parents[root]
    while parents[vertex] != root:
        parents[vertex], vertex = root, parents[vertex]
    return root


@kernel
def _join_all(edges, parents, ranks):
    for row in range(len(edges)):
        a, b = _root(parents, edges[row, 0]), _root(parents, edges[row, 1])
        if a == b:
            continue
        if ranks[a] < ranks[b]:
            a, b = b, a
        parents[b] = a
        if ranks[a] == ranks[b]:
            ranks[a] += 1
    for vertex in range(len(parents)):
        parents[vertex] = _root(parents, vertex)


def island_roots(edges: np.ndarray, count: int) -> np.ndarray:
    """int32 (count,): for each vertex the one that stands for its island. Which one that is, is
    what a disjoint-set forest with union by rank finds, as in Cycles, edge by edge.

    edges: int32 (n, 2), two of the count vertices each
    """
    parents = np.arange(count, dtype=np.int32)
    _join_all(edges, parents, np.zeros(count, np.uint8))
    return parents
