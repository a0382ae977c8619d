"""Slow, obvious twins of the kernels: NumPy, float64, no cleverness."""

import math

import numpy as np


def haar_basis(side: int) -> np.ndarray:
    """float64 (side^2, side^2): row k is basis function k as a grid of its values, row by row.

    Written down from the definition (core/wavelets/haar.py): 1, then 2^l s_t on square (l, i, j).
    """
    basis = np.zeros((side * side, side, side))
    basis[0] = 1.0
    signs = {0: ((1, -1), (1, -1)), 1: ((1, 1), (-1, -1)), 2: ((1, -1), (-1, 1))}
    k, squares = 1, 1
    while squares < side:
        half = side // squares // 2
        for i in range(squares):
            for j in range(squares):
                for t in range(3):
                    for a in range(2):
                        for b in range(2):
                            rows = slice((2 * i + a) * half, (2 * i + a + 1) * half)
                            columns = slice((2 * j + b) * half, (2 * j + b + 1) * half)
                            basis[k, rows, columns] = squares * signs[t][a][b]
                    k += 1
        squares *= 2
    return basis.reshape(side * side, side * side)


def warp_grid(grid: np.ndarray, x: float, y: float):
    """Warp a point by a grid of densities >= 0, halving rows, then columns: (x, y, density)."""
    side = len(grid)
    total = grid.sum()
    rows, columns = (0, side), (0, side)
    while rows[1] - rows[0] > 1:
        middle = (rows[0] + rows[1]) // 2
        part = grid[rows[0] : rows[1], columns[0] : columns[1]]
        share = grid[rows[0] : middle, columns[0] : columns[1]].sum() / part.sum()
        if y < share:
            y, rows = y / share, (rows[0], middle)
        else:
            y, rows = (y - share) / (1.0 - share), (middle, rows[1])
        middle = (columns[0] + columns[1]) // 2
        part = grid[rows[0] : rows[1], columns[0] : columns[1]]
        share = grid[rows[0] : rows[1], columns[0] : middle].sum() / part.sum()
        if x < share:
            x, columns = x / share, (columns[0], middle)
        else:
            x, columns = (x - share) / (1.0 - share), (middle, columns[1])
    density = grid[rows[0], columns[0]] / total * side * side
    return (columns[0] + x) / side, (rows[0] + y) / side, density


def radical_inverse(index: int, base: int) -> float:
    """The digits of index, mirrored at the point, most significant last."""
    digits = []
    while index:
        index, digit = divmod(index, base)
        digits.append(digit)
    return sum(digit / base ** (k + 1) for k, digit in enumerate(digits))


def hits_triangles(mesh, origins, directions):
    """(distance (n,), triangle (n,)) of the nearest hits by Moeller and Trumbore; inf, -1: none."""
    nearest = np.full(len(origins), np.inf)
    which = np.full(len(origins), -1)
    for k, corners in enumerate(mesh.vertices[mesh.triangles].astype(np.float64)):
        edge1, edge2 = corners[1] - corners[0], corners[2] - corners[0]
        p = np.cross(directions, edge2)
        determinant = p @ edge1
        with np.errstate(divide="ignore", invalid="ignore"):
            s = origins - corners[0]
            u = (p * s).sum(-1) / determinant
            q = np.cross(s, edge1)
            v = (q * directions).sum(-1) / determinant
            t = q @ edge2 / determinant
            hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-9) & (t < nearest)
        nearest[hit], which[hit] = t[hit], k
    return nearest, which


def frame_of(normal):
    """float64 (3, 3): rows tangent, bitangent, normal, right-handed."""
    other = (0.0, 1.0, 0.0) if abs(normal[0]) > 0.5 else (1.0, 0.0, 0.0)
    tangent = np.cross(other, normal)
    tangent /= np.linalg.norm(tangent)
    return np.stack([tangent, np.cross(normal, tangent), normal])


def cosine_grid(side: int) -> np.ndarray:
    """float64 (side^2, 3): local directions that stand for equal parts of the cosine's integral.

    The mean of a function over them is its integral against cos / pi: a midpoint rule on the disc.
    """
    a, b = np.meshgrid(*2 * [(np.arange(side) + 0.5) / side], indexing="ij")
    r, phi = np.sqrt(a.ravel()), 2.0 * math.pi * b.ravel()
    return np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1.0 - a.ravel())], -1)


def ggx_grid(side: int, alpha: float) -> np.ndarray:
    """float64 (side^2, 3): local half vectors that stand for equal parts of D cos."""
    a, b = np.meshgrid(*2 * [(np.arange(side) + 0.5) / side], indexing="ij")
    tan2 = alpha * alpha * a.ravel() / (1.0 - a.ravel())
    cos = 1.0 / np.sqrt(1.0 + tan2)
    sin, phi = np.sqrt(tan2) * cos, 2.0 * math.pi * b.ravel()
    return np.stack([sin * np.cos(phi), sin * np.sin(phi), cos], -1)


def ggx_lambda(alpha, cos):
    """Smith's Lambda of an isotropic GGX surface."""
    return 0.5 * (np.sqrt(1.0 + alpha * alpha * (1.0 - cos * cos) / (cos * cos)) - 1.0)


def integrate_diffuse(light, albedo, normal, side=500):
    """float64 (3,): reflected radiance of a Lambert surface.

    light(directions (n, 3)) -> (n, 3): what arrives, shadows included
    """
    return albedo * light(cosine_grid(side) @ frame_of(normal)).mean(0)


def integrate_glossy(light, color, alpha, normal, wo, side=700):
    """float64 (3,): reflected radiance of a Glossy (GGX, F = 1) surface with colour ``color``.

    Steps are fine where the lobe is high: for light that is only bright in its tails, use
    integrate_texel.
    """
    frame = frame_of(normal)
    local_wo = frame @ wo
    h = ggx_grid(side, alpha)
    wo_h = h @ local_wo
    wi = 2.0 * wo_h[:, None] * h - local_wo
    good = (wi[:, 2] > 0.0) & (wo_h > 0.0)
    wi, h, wo_h = wi[good], h[good], wo_h[good]
    hidden = 1.0 + ggx_lambda(alpha, local_wo[2]) + ggx_lambda(alpha, wi[:, 2])
    # brdf cos_i d wi = D G2 / (4 cos_o) 4 (wo . h) d h, and d h has density D cos_h.
    weight = wo_h / (local_wo[2] * h[:, 2] * hidden)
    return color * (light(wi @ frame) * weight[:, None]).sum(0) / side**2


def ggx_brdf_cos(wi, color, alpha, normal, wo):
    """float64 (n, 3): the Glossy BRDF (GGX, F = 1) times the cosine of wi (n, 3)."""
    cos_o, cos_i = wo @ normal, wi @ normal
    half = wi + wo
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    cos_h = half @ normal
    d = alpha**2 / (math.pi * (cos_h**2 * (alpha**2 - 1.0) + 1.0) ** 2)
    up = np.maximum(cos_i, 1e-9)
    g = 1.0 / (1.0 + ggx_lambda(alpha, cos_o) + ggx_lambda(alpha, up))
    return np.where(cos_i > 0.0, d * g / (4.0 * cos_o), 0.0)[:, None] * color


def texel_directions(height, row, column, side=600):
    """What one texel lights, through the bilinear filter: (directions (n, 3), weights (n,)).

    weights: share of the texel's radiance that arrives from there, times steradians
    """
    step = (np.arange(side) + 0.5) / side * 2.0 - 1.0
    a, b = (x.ravel() for x in np.meshgrid(step, step, indexing="ij"))
    latitude = ((row + 0.5 + a) / height - 0.5) * math.pi
    longitude = (0.5 - (column + 0.5 + b) / (2 * height)) * 2.0 * math.pi
    ring = np.cos(latitude)
    directions = [ring * np.cos(longitude), ring * np.sin(longitude), np.sin(latitude)]
    area = (2.0 / side * math.pi / height) ** 2
    return np.stack(directions, -1), (1.0 - np.abs(a)) * (1.0 - np.abs(b)) * ring * area


def forest_grid(forest, s: int, channel: int, side: int) -> np.ndarray:
    """float64 (side, side): the values of slice s of a HaarForest, node by node."""
    grid = np.full((side, side), float(forest.slice_mean[s, channel]))

    def add(node, level, i, j):
        scale, size = 2.0**level, side >> level
        h, v, d = (float(x) for x in forest.detail[node, :, channel])
        half = size // 2
        square = grid[i * size : (i + 1) * size, j * size : (j + 1) * size]
        square[:half, :half] += scale * (h + v + d)
        square[:half, half:] += scale * (-h + v - d)
        square[half:, :half] += scale * (h - v - d)
        square[half:, half:] += scale * (-h - v + d)
        for q, child in enumerate(forest.child[node]):
            if child >= 0:
                add(child, level + 1, 2 * i + q // 2, 2 * j + q % 2)

    if forest.root[s] >= 0:
        add(forest.root[s], 0, 0, 0)
    return grid
