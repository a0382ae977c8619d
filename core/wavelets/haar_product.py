"""The product of two sparse Haar series, coarse to fine, and the warp through it.

Local Parseval: over a square Q of side 2^-l the product's mean is

    mean_Q(F G) = mean_Q(F) mean_Q(G) + 4^l S_Q,   S_Q = sum of F_k G_k over wavelets inside Q,

so only nodes that both trees have need sums; where one tree ends, the product is the other one
times a constant [Ng04, section 5; docs/references.md]. The whole integral is S over all, plus the
means' product. The light F has three channels; the walk for sampling weighs them to one number.
The BRDF G has one channel, or three that go with the light's. Below the last common node only the
factor that still varies is walked; the other one's colour there (one number without colour where
G has one channel) does not change its weights.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from .haar_forest import NO_CHILD

# ProductTrees.child: >= 0 a product node, -1 a constant square, else a node of one factor alone
_FIRST_LIGHT, _FIRST_BRDF = -2, -3
MAX_COMMON = 1365  # squares of a 64^2 grid that can have details


class ProductTrees(NamedTuple):
    """Product nodes of many points, an arena.

    weight: float32 (m, 4), means of the product over the quadrants, not below 0
    child: int32 (m, 4), as above: -2 - 2 k is node k of the light, -3 - 2 k of the BRDF
    """

    weight: np.ndarray
    child: np.ndarray


class WalkScratch(NamedTuple):
    """Room for one product: light, brdf, parent, quadrant, level: int32 (MAX_COMMON,);
    inside: float32 (MAX_COMMON, 4), S of the quadrants.
    """

    light: np.ndarray
    brdf: np.ndarray
    parent: np.ndarray
    quadrant: np.ndarray
    level: np.ndarray
    inside: np.ndarray


def new_scratch() -> WalkScratch:
    """Scratch for build_product_tree; one for each thread."""
    return WalkScratch(
        *(np.empty(MAX_COMMON, np.int32) for _ in range(5)),
        np.empty((MAX_COMMON, 4), np.float32),
    )


@kernel(forceinline=True)
def _channel_step(brdf):
    """0 where the BRDF has one channel for all of the light's, 1 where it has three."""
    return brdf.slice_mean.shape[1] // 3


@kernel(forceinline=True)
def _product(light, brdf, own, weights):
    """Sum of light x BRDF x weight over the channels of one number each."""
    return (
        light[0] * brdf[0] * weights[0]
        + light[1] * brdf[own] * weights[1]
        + light[2] * brdf[2 * own] * weights[2]
    )


@kernel
def product_integral(light, light_slice, brdf, brdf_slice, stack, out):
    """Add to out (3,) the integral over the unit square of light x BRDF, per channel.

    light: HaarForest of 3 channels; brdf: of 1 or 3; stack: int32 (2, MAX_COMMON) scratch
    """
    own = _channel_step(brdf)
    for c in range(3):
        out[c] += light.slice_mean[light_slice, c] * brdf.slice_mean[brdf_slice, c * own]
    if light.root[light_slice] < 0 or brdf.root[brdf_slice] < 0:
        return
    stack[0, 0], stack[1, 0] = light.root[light_slice], brdf.root[brdf_slice]
    n = 1
    while n:
        n -= 1
        f, g = stack[0, n], stack[1, n]
        for t in range(3):
            for c in range(3):
                out[c] += light.detail[f, t, c] * brdf.detail[g, t, c * own]
        for q in range(4):
            if light.child[f, q] >= 0 and brdf.child[g, q] >= 0:
                stack[0, n], stack[1, n] = light.child[f, q], brdf.child[g, q]
                n += 1


@kernel
def _weighted(values, weights):
    return values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2]


@kernel
def _weighted_own(values, own, weights):
    return values[0] if own == 0 else _weighted(values, weights)


@kernel
def _find_common(light, light_root, brdf, brdf_root, scratch):
    """List the nodes that both trees have, parents first; returns how many."""
    scratch.light[0], scratch.brdf[0] = light_root, brdf_root
    scratch.parent[0], scratch.quadrant[0], scratch.level[0] = -1, 0, 0
    end, node = 1, 0
    while node < end:
        f, g = scratch.light[node], scratch.brdf[node]
        for q in range(4):
            if light.child[f, q] >= 0 and brdf.child[g, q] >= 0:
                scratch.light[end], scratch.brdf[end] = light.child[f, q], brdf.child[g, q]
                scratch.parent[end], scratch.quadrant[end] = node, q
                scratch.level[end] = scratch.level[node] + 1
                end += 1
        node += 1
    return end


@kernel
def count_common(light, light_slice, brdf, brdf_slice, scratch):
    """How many nodes build_product_tree will write for two slices."""
    light_root, brdf_root = light.root[light_slice], brdf.root[brdf_slice]
    if light_root < 0 or brdf_root < 0:
        return 0
    return _find_common(light, light_root, brdf, brdf_root, scratch)


@kernel
def _child_code(light_child, brdf_child):
    if light_child >= 0:
        return _FIRST_LIGHT - 2 * light_child
    if brdf_child >= 0:
        return _FIRST_BRDF - 2 * brdf_child
    return NO_CHILD


@kernel
def build_product_tree(light, light_slice, brdf, brdf_slice, weights, scratch, trees, first):
    """Write the nodes of one product from ``first`` on; returns (code of the root, end).

    weights: float32 (3,), what each channel of the light counts
    """
    light_root, brdf_root = light.root[light_slice], brdf.root[brdf_slice]
    if light_root < 0 or brdf_root < 0:
        return _child_code(light_root, brdf_root), first
    own = _channel_step(brdf)
    n = _find_common(light, light_root, brdf, brdf_root, scratch)
    for k in range(n):
        for q in range(4):
            scratch.inside[k, q] = 0.0
            trees.child[first + k, q] = NO_CHILD
    for k in range(n - 1, -1, -1):
        f, g = scratch.light[k], scratch.brdf[k]
        total = np.float32(0.0)
        for q in range(4):
            total += scratch.inside[k, q]
        for t in range(3):
            total += _product(light.detail[f, t], brdf.detail[g, t], own, weights)
        if k > 0:
            scratch.inside[scratch.parent[k], scratch.quadrant[k]] = total
            trees.child[first + scratch.parent[k], scratch.quadrant[k]] = first + k
    for k in range(n):
        _fill_weights(light, brdf, weights, scratch, k, trees, first)
    return first, first + n


@kernel
def _fill_weights(light, brdf, weights, scratch, k, trees, first):
    """The product's means over the quadrants of common node k, and where each goes on."""
    f, g = scratch.light[k], scratch.brdf[k]
    scale, own = np.float32(1 << scratch.level[k]), _channel_step(brdf)
    area = np.float32(4.0) * scale * scale
    for q in range(4):
        sh = np.float32(1.0) if (q & 1) == 0 else np.float32(-1.0)
        sv = np.float32(1.0) if q < 2 else np.float32(-1.0)
        value = area * scratch.inside[k, q]
        for c in range(3):
            a = _quadrant_mean(light.mean[f, c], light.detail, f, c, scale, sh, sv)
            b = _quadrant_mean(brdf.mean[g, c * own], brdf.detail, g, c * own, scale, sh, sv)
            value += weights[c] * a * b
        trees.weight[first + k, q] = max(value, np.float32(0.0))
        if trees.child[first + k, q] < 0:
            trees.child[first + k, q] = _child_code(light.child[f, q], brdf.child[g, q])


@kernel(forceinline=True)
def _quadrant_mean(mean, detail, node, c, scale, sh, sv):
    """Mean over the quadrant of signs sh, sv of one channel of a node."""
    h, v, d = detail[node, 0, c], detail[node, 1, c], detail[node, 2, c]
    return mean + scale * (sh * h + sv * v + sh * sv * d)


@kernel
def _quadrant_means(mean, h, v, d):
    zero = np.float32(0.0)
    return (
        max(mean + h + v + d, zero),
        max(mean - h + v - d, zero),
        max(mean + h - v - d, zero),
        max(mean - h - v + d, zero),
    )


@kernel
def _step_weights(light, brdf, weights, trees, code, scale):
    """The four quadrant weights of a node code and the four codes below it."""
    if code >= 0:
        w, child = trees.weight[code], trees.child[code]
        return w[0], w[1], w[2], w[3], child[0], child[1], child[2], child[3]
    if code & 1:
        node = (_FIRST_BRDF - code) // 2
        detail, own = brdf.detail[node], _channel_step(brdf)
        a, b, c, d = _quadrant_means(
            _weighted_own(brdf.mean[node], own, weights),
            scale * _weighted_own(detail[0], own, weights),
            scale * _weighted_own(detail[1], own, weights),
            scale * _weighted_own(detail[2], own, weights),
        )
        child, first = brdf.child[node], _FIRST_BRDF
    else:
        node = (_FIRST_LIGHT - code) // 2
        detail = light.detail[node]
        a, b, c, d = _quadrant_means(
            _weighted(light.mean[node], weights),
            scale * _weighted(detail[0], weights),
            scale * _weighted(detail[1], weights),
            scale * _weighted(detail[2], weights),
        )
        child, first = light.child[node], _FIRST_LIGHT
    k0 = first - 2 * child[0] if child[0] >= 0 else NO_CHILD
    k1 = first - 2 * child[1] if child[1] >= 0 else NO_CHILD
    k2 = first - 2 * child[2] if child[2] >= 0 else NO_CHILD
    k3 = first - 2 * child[3] if child[3] >= 0 else NO_CHILD
    return a, b, c, d, k0, k1, k2, k3


@kernel
def warp_tree(light, brdf, weights, trees, root, x, y):
    """Warp one point of the unit square through a product tree: (x, y, density on the square).

    [Clarberg05]: at each square first the row, then the column, is chosen in proportion to the
    means, and what is left of x and y is stretched to [0, 1) again. Where all four are 0 the
    square counts as uniform.
    """
    code, level, row, column, density = root, 0, 0, 0, 1.0
    while code != NO_CHILD:
        scale = np.float32(1 << level)
        a, b, c, d, k0, k1, k2, k3 = _step_weights(light, brdf, weights, trees, code, scale)
        total = np.float64(a) + np.float64(b) + np.float64(c) + np.float64(d)
        if total <= 0.0:
            break
        share = (np.float64(a) + np.float64(b)) / total
        if y < share:
            y /= share
            left, chosen = np.float64(a) / (np.float64(a) + np.float64(b)), 0
        else:
            y = (y - share) / (1.0 - share)
            left, chosen = np.float64(c) / (np.float64(c) + np.float64(d)), 2
        if x < left:
            x /= left
        else:
            x = (x - left) / (1.0 - left)
            chosen += 1
        x, y = min(x, 0.9999999999999999), min(y, 0.9999999999999999)
        weight = a if chosen == 0 else b if chosen == 1 else c if chosen == 2 else d
        code = k0 if chosen == 0 else k1 if chosen == 1 else k2 if chosen == 2 else k3
        density *= 4.0 * np.float64(weight) / total
        row, column = 2 * row + (chosen >> 1), 2 * column + (chosen & 1)
        level += 1
    side = 1 << level
    return (column + x) / side, (row + y) / side, density
