"""Solids as signed distances, melted into each other, and the mesh of their surface.

A solid is a function of points (n, 3) to float32 (n,), metres, negative inside; near enough to a
distance that mixing two of them gives a fillet of about the width asked for.
"""

import numpy as np


def ellipsoid(points, center, radii):
    """A sphere stretched along the axes; exact on the surface, nearly so beside it."""
    q = (points - np.float32(center)) / np.float32(radii)
    length = np.linalg.norm(q, axis=1)
    slope = np.linalg.norm(q / np.float32(radii), axis=1)
    return length * (length - 1.0) / np.maximum(slope, 1e-6)


def limb(points, start, end, start_radius, end_radius):
    """A rounded cone from start to end."""
    start, end = np.float32(start), np.float32(end)
    axis = end - start
    t = np.clip((points - start) @ axis / (axis @ axis), 0.0, 1.0)
    nearest = np.linalg.norm(points - start - t[:, None] * axis, axis=1)
    return nearest - (start_radius + (end_radius - start_radius) * t)


def mirrored(solid):
    """The solid and its mirror image in x, from the half with x >= 0."""
    return lambda points: solid(np.abs(points) * (1, 0, 0) + points * np.float32((0, 1, 1)))


def melt(a, b, width):
    """Union with a fillet of about `width`."""
    h = np.maximum(width - np.abs(a - b), 0.0) / width
    return np.minimum(a, b) - h * h * (0.25 * width)


def carve(a, b, width):
    """`a` without `b`, edges rounded by about `width`."""
    return -melt(-a, b, width)


def noise(points, size, *, seed=0):
    """Smooth noise in -1 ... 1 with bumps about `size` metres wide, as hewn stone has. (n,)"""
    lattice = np.random.default_rng(seed).uniform(-1.0, 1.0, (16, 16, 16)).astype(np.float32)
    q = points / np.float32(size)
    cell = np.floor(q).astype(int)
    t = q - cell
    t = t * t * (3.0 - 2.0 * t)
    total = np.zeros(len(points), np.float32)
    for corner in np.ndindex(2, 2, 2):
        at = (cell + corner) % 16
        weight = np.where(corner, t, 1.0 - t).prod(axis=1)
        total += weight * lattice[at[:, 0], at[:, 1], at[:, 2]]
    return total


def mesh_of(solid, low, high, step):
    """Quads of the surface solid = 0: one vertex in each cell that it crosses (naive surface nets).

    low, high: corners of the block that is searched; step: side of a cell, metres
    Returns vertices float64 (n, 3), faces int (m, 4), wound so that normals point outwards
    """
    axes = [np.arange(a, b + step, step, dtype=np.float32) for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    slabs = [solid(slab.reshape(-1, 3)).reshape(slab.shape[:-1]) for slab in grid]
    distance = np.stack(slabs).astype(np.float64)
    inside = distance < 0.0
    total, count = _crossings(distance, inside)
    cells = count > 0
    number = np.full(count.shape, -1)
    number[cells] = np.arange(cells.sum())
    corner = np.argwhere(cells)
    # A tenth towards the cell's centre: else vertices of two cells can meet on their common side.
    place = 0.5 + 0.9 * (total[cells] / count[cells][:, None] - 0.5)
    vertices = np.float64(low) + step * (corner + place)
    return vertices, _quads(inside, number)


def _crossings(distance, inside):
    """Sum and number of the points where the surface cuts the 12 edges of each cell."""
    shape = np.array(distance.shape) - 1
    total, count = np.zeros((*shape, 3)), np.zeros(shape)
    for axis in range(3):
        along = np.moveaxis(distance, axis, 0)
        a, b = along[:-1], along[1:]
        cut = np.moveaxis(inside, axis, 0)
        cut = cut[:-1] != cut[1:]
        t = np.where(cut, a / np.where(cut, a - b, 1.0), 0.0)
        cut, t = np.moveaxis(cut, 0, axis), np.moveaxis(t, 0, axis)
        others = [k for k in range(3) if k != axis]
        for offsets in ((0, 0), (0, 1), (1, 0), (1, 1)):
            at = [slice(None)] * 3
            for k, offset in zip(others, offsets, strict=True):
                at[k] = slice(offset, offset + shape[k])
            here = cut[tuple(at)]
            count += here
            total[..., axis] += t[tuple(at)]
            for k, offset in zip(others, offsets, strict=True):
                total[..., k] += offset * here
    return total, count


def _quads(inside, number):
    """A quad across each grid edge that the surface cuts, of the vertices in the cells round it."""
    faces = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        first = np.moveaxis(inside, axis, 0)
        starts = np.argwhere(np.moveaxis(first[:-1] != first[1:], 0, axis))
        starts = starts[(starts[:, u] > 0) & (starts[:, v] > 0)]
        starts = starts[(starts[:, u] < number.shape[u]) & (starts[:, v] < number.shape[v])]
        ring = []
        for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
            cell = starts.copy()
            cell[:, u] -= du
            cell[:, v] -= dv
            ring.append(number[tuple(cell.T)])
        quads = np.stack(ring, 1)
        outwards = inside[tuple(starts.T)]
        faces.append(np.where(outwards[:, None], quads, quads[:, ::-1]))
    return np.concatenate(faces)
