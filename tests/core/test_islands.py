"""Islands of a mesh."""

import numpy as np

from iwis.core.geometry.islands import island_roots


def test_vertices_that_edges_join_have_one_root():
    rng = np.random.default_rng(1)
    island = rng.integers(0, 40, 3000)
    order = np.argsort(island, kind="stable")
    chain = np.stack([order[:-1], order[1:]], -1)
    chain = chain[island[chain[:, 0]] == island[chain[:, 1]]]
    edges = rng.permuted(rng.permutation(chain), axis=1).astype(np.int32)
    roots = island_roots(edges, len(island))
    assert len(np.unique(roots)) == len(np.unique(island))
    for members in (np.flatnonzero(island == k) for k in range(40)):
        assert roots[members].min() == roots[members].max()
        assert roots[members[0]] in members


def test_the_higher_tree_keeps_its_root():
    """Union by rank, the first vertex of the edge where both are equal."""
    edges = np.int32([[3, 4], [0, 3], [1, 2], [2, 0]])
    assert island_roots(edges, 6).tolist() == [1, 1, 1, 1, 1, 5]


def test_no_edges():
    assert island_roots(np.empty((0, 2), np.int32), 3).tolist() == [0, 1, 2]
