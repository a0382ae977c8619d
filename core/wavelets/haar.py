"""The two-dimensional non-standard Haar transform of a 2^n x 2^n grid of cell averages.

Notation of [Ng04] and docs/references.md: square (l, i, j) has side 2^-l; its three wavelets are
2^l s_t with the signs (TL, TR, BL, BR) h = (+ - + -), v = (+ + - -), d = (+ - - +). All
are orthonormal on the unit square.

Coefficients are kept in one vector of 4^n numbers: index 0 is the mean (the scaling coefficient),
detail t of square (l, i, j) stands at 4^l + 3 (i 2^l + j) + t.
"""

import numpy as np

from .._jit import kernel


@kernel
def haar_forward(grid, scratch, coefficients):
    """Write the Haar coefficients of one grid.

    grid: float32 (side, side), side = 2^n, cell averages; overwritten with scratch data
    scratch: float32 (side, side), overwritten
    coefficients: float32 (side * side,), written
    """
    half = grid.shape[0] // 2
    while half >= 1:
        scale = np.float32(0.25 / half)  # 2^-l / 4, for half = 2^l squares a row
        base = half * half
        for i in range(half):
            for j in range(half):
                a, b = grid[2 * i, 2 * j], grid[2 * i, 2 * j + 1]
                c, d = grid[2 * i + 1, 2 * j], grid[2 * i + 1, 2 * j + 1]
                scratch[i, j] = np.float32(0.25) * (a + b + c + d)
                k = base + 3 * (i * half + j)
                coefficients[k] = scale * (a - b + c - d)
                coefficients[k + 1] = scale * (a + b - c - d)
                coefficients[k + 2] = scale * (a - b - c + d)
        for i in range(half):
            for j in range(half):
                grid[i, j] = scratch[i, j]
        half //= 2
    coefficients[0] = grid[0, 0]


@kernel
def haar_inverse(coefficients, scratch, grid):
    """Write the grid whose Haar coefficients are given; inverse of haar_forward.

    coefficients: float32 (side * side,); scratch, grid: float32 (side, side), grid is written
    """
    side = grid.shape[0]
    grid[0, 0] = coefficients[0]
    half = 1
    while half < side:
        for i in range(half):
            for j in range(half):
                scratch[i, j] = grid[i, j]
        for i in range(half):
            for j in range(half):
                k = half * half + 3 * (i * half + j)
                h = half * coefficients[k]
                v = half * coefficients[k + 1]
                d = half * coefficients[k + 2]
                mean = scratch[i, j]
                grid[2 * i, 2 * j] = mean + h + v + d
                grid[2 * i, 2 * j + 1] = mean - h + v - d
                grid[2 * i + 1, 2 * j] = mean + h - v - d
                grid[2 * i + 1, 2 * j + 1] = mean - h - v + d
        half *= 2


def forward(grid: np.ndarray) -> np.ndarray:
    """float32 (4^n,): the Haar coefficients of a float32 (2^n, 2^n) grid, left as it is."""
    side = _side_of(grid)
    coefficients = np.empty(side * side, np.float32)
    haar_forward(grid.astype(np.float32), np.empty((side, side), np.float32), coefficients)
    return coefficients


def inverse(coefficients: np.ndarray) -> np.ndarray:
    """float32 (2^n, 2^n): the grid of a vector of Haar coefficients."""
    side = round(len(coefficients) ** 0.5)
    grid = np.empty((side, side), np.float32)
    haar_inverse(coefficients.astype(np.float32), np.empty_like(grid), grid)
    return grid


def truncated(coefficients: np.ndarray, fraction: float) -> np.ndarray:
    """A copy that keeps the mean and the largest ``fraction`` of the coefficients, 0 elsewhere.

    Orthonormal wavelets: the largest ones are the best choice in the L2 sense.
    """
    keep = max(1, round(fraction * len(coefficients)))
    order = np.argsort(-np.abs(coefficients[1:]), kind="stable")[: keep - 1] + 1
    kept = np.zeros_like(coefficients)
    kept[0] = coefficients[0]
    kept[order] = coefficients[order]
    return kept


def _side_of(grid):
    side = grid.shape[0]
    if grid.shape != (side, side) or side & (side - 1):
        raise ValueError(f"a Haar grid must be 2^n x 2^n, got {grid.shape}")
    return side
