"""The faces of one lamp as a tree of boxes, by which a face is drawn and a ray finds one.

Leaves are blocks of faces in the order of Morton's curve [Morton66], halved again and again. A node
stands before its first half, and that before the second one: of a node of n leaves the whole tree
has 2 n - 1 rows, so that no row needs to know another.
"""

from __future__ import annotations

import numpy as np

from ..data.lamps import BLOCK, LampFaces

_FAR = np.float32(np.inf)


def areas_of(corners) -> np.ndarray:
    """float64 (n,) of float (n, 3, 3): 0 for what is not finite, too."""
    corners = corners.astype(np.float64)
    with np.errstate(invalid="ignore", over="ignore"):
        sides = corners[:, 1:] - corners[:, :1]
        area = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    return np.where(np.isfinite(area), area, 0.0)


def powers_of_faces(corners, radiance) -> np.ndarray:
    """float64 (n, 2), of front and back: area times the root mean square of the channels.

    Not luminance: a blue face would be drawn so seldom that it makes specks. radiance: (n, 2, 3)
    """
    strength = np.sqrt((radiance.astype(np.float64) ** 2).mean(axis=2))
    return areas_of(corners)[:, None] * strength


def face_tree(corners, radiance, face, seldom) -> LampFaces:
    """The faces of one lamp. corners: float32 (n, 3, 3); radiance: float32 (n, 2, 3); face: int
    (n,), of LampFaces; seldom: float (n, 2), factors of the power of front and back"""
    order = _along_curve(corners.mean(axis=1))
    corners, radiance, face, seldom = (a[order] for a in (corners, radiance, face, seldom))
    missing = -len(corners) % BLOCK
    empty = np.repeat(corners[-1:, :1], 3, axis=1)
    corners = np.concatenate([corners, np.repeat(empty, missing, axis=0)])
    radiance = np.concatenate([radiance, np.zeros((missing, 2, 3), np.float32)])
    face = np.concatenate([face, np.repeat(face[-1:], missing)]).astype(np.int32)
    seldom = np.concatenate([seldom, np.ones((missing, 2))])
    power = powers_of_faces(corners, radiance) * seldom
    nodes, leaves = face_nodes(corners, power)
    radiance = np.ascontiguousarray(radiance.reshape(-1, 3))
    return LampFaces(np.ascontiguousarray(corners), power, radiance, nodes, leaves, face)


def face_nodes(corners, power):
    """LampFaces.nodes and leaves of whole blocks of faces. corners: float32 (m, 3, 3); power:
    float64 (m, 2)"""
    blocks = corners.reshape(-1, BLOCK * 3, 3).astype(np.float64)
    leaf_boxes = np.concatenate([blocks.min(axis=1), blocks.max(axis=1)], axis=1)
    of_blocks = _turned_powers(corners, power).reshape(-1, BLOCK, 10).sum(axis=1)
    leaves, boxes, sums = _grown(leaf_boxes, of_blocks)
    nodes = np.zeros((len(leaves), 16), np.float32)
    nodes[:, :3] = np.nextafter(np.float32(boxes[:, :3]), -_FAR)
    nodes[:, 3:6] = np.nextafter(np.float32(boxes[:, 3:]), _FAR)
    nodes[:, 6] = np.clip(sums[:, 0], 1e-30, 1e30)
    nodes[:, 7:] = sums[:, 1:] / np.maximum(sums[:, :1], 1e-300)
    return nodes, leaves


def _turned_powers(corners, power) -> np.ndarray:
    """float64 (m, 10): LampFaces.nodes' columns from power on, of faces, times their power."""
    sides = corners[:, 1:].astype(np.float64) - corners[:, :1]
    normal = np.nan_to_num(np.cross(sides[:, 0], sides[:, 1]))
    x, y, z = (normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)).T
    whole, more = power.mean(axis=1), 0.5 * (power[:, 0] - power[:, 1])
    squares = np.stack([x * x, y * y, z * z, x * y, x * z, y * z])
    return np.concatenate([whole[None], whole * squares, more * np.stack([x, y, z])]).T


def _grown(leaf_boxes, leaf_sums):
    """(leaves, boxes, sums) of all nodes over the boxes of leaves, (n, 6), and their sums."""
    n = len(leaf_boxes)
    leaves = np.empty(2 * n - 1, np.int32)
    boxes, sums = np.empty((2 * n - 1, 6)), np.empty((2 * n - 1, leaf_sums.shape[1]))
    rows, first, count = np.zeros(1, np.int64), np.zeros(1, np.int64), np.full(1, n)
    inner = []
    while len(rows):
        leaves[rows] = count
        end = count == 1
        boxes[rows[end]], sums[rows[end]] = leaf_boxes[first[end]], leaf_sums[first[end]]
        rows, first, count = rows[~end], first[~end], count[~end]
        half = (count + 1) // 2
        left, right = rows + 1, rows + 2 * half
        inner.append((rows, left, right))
        first = np.concatenate([first, first + half])
        rows, count = np.concatenate([left, right]), np.concatenate([half, count - half])
    for rows, left, right in reversed(inner):
        boxes[rows, :3] = np.minimum(boxes[left, :3], boxes[right, :3])
        boxes[rows, 3:] = np.maximum(boxes[left, 3:], boxes[right, 3:])
        sums[rows] = sums[left] + sums[right]
    return leaves, boxes, sums


def _along_curve(places) -> np.ndarray:
    """Their order along Morton's curve of 1024 steps a side."""
    low, size = places.min(axis=0), max(float(np.ptp(places, axis=0).max()), 1e-30)
    cells = np.clip((places - low) / size * 1023.0, 0.0, 1023.0).astype(np.int64)
    code = np.zeros(len(places), np.int64)
    for bit in range(10):
        for axis in range(3):
            code |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.argsort(code, kind="stable")
