"""The steps of walks under surfaces (random_walk.py), in kernels.

A walk enters refracted by the facets [Walter07], or as under a matte surface; each way is drawn for
one channel, and all count by its density in any (the balance heuristic, [Veach95]); after some ways
the medium scatters evenly, its density reduced (similarity, [Wyman89]). Half of the ways, and later
more, are guided to the surface as in a half space [Krivanek14, dEon20], which the balance heuristic
knows of too. So do Cycles' walks.
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from ..bsdf.microfacet import (
    HALF,
    ONE,
    PI,
    TWO,
    ZERO,
    basis,
    dot_xyz,
    sample_ggx_visible_normal,
    to_world,
)
from ..embree.embree_hits import hit_of, meets, new_look
from .walkers import next_number

MOST_STEPS = 256
# From this step on the medium scatters evenly, and less.
_SIMILAR = 10
_FAINT = np.float32(1e-6)
_EVEN = np.float32(1e-3)  # anisotropy
_LATER_GUIDED = np.float32(0.75)
_PER_SPHERE = np.float32(0.25 / math.pi)


@kernel
def enter(points, normal, medium, walkers, alive):
    """Draw the first direction of each, and whether it leads under the surface."""
    for w in range(len(alive)):
        n, wo = normal[w], points.wo[w]
        s, t = basis((n[0], n[1], n[2]))
        u, v = next_number(walkers, w), next_number(walkers, w)
        cos_o = dot_xyz(n, wo[0], wo[1], wo[2])
        if next_number(walkers, w) < medium.matte[w]:
            r, phi = math.sqrt(u), TWO * PI * v
            x, y, z = to_world(s, t, n, r * math.cos(phi), r * math.sin(phi), -math.sqrt(ONE - u))
        elif cos_o > ZERO:
            local = dot_xyz(s, wo[0], wo[1], wo[2]), dot_xyz(t, wo[0], wo[1], wo[2]), cos_o
            alpha = max(medium.alpha[w], np.float32(1e-4))
            h = sample_ggx_visible_normal(local[0], local[1], local[2], alpha, alpha, u, v)
            cos_h = h[0] * local[0] + h[1] * local[1] + h[2] * local[2]
            ratio = ONE / medium.ior[w]
            bent = ratio * cos_h - math.sqrt(ONE - ratio * ratio * (ONE - cos_h * cos_h))
            hx, hy, hz = to_world(s, t, n, h[0], h[1], h[2])
            x, y, z = (
                bent * hx - ratio * wo[0],
                bent * hy - ratio * wo[1],
                bent * hz - ratio * wo[2],
            )
        else:
            alive[w] = False
            continue
        alive[w] = dot_xyz(points.geometric_normal[w], x, y, z) < ZERO
        walkers.direction[w, 0], walkers.direction[w, 1], walkers.direction[w, 2] = x, y, z


@kernel(forceinline=True)
def _scattered(walkers, w, g):
    """The cosine of a scattering after [Henyey41], to the direction before."""
    u = next_number(walkers, w)
    if abs(g) <= _EVEN:
        return ONE - TWO * u
    k = (ONE - g * g) / (ONE - g + TWO * g * u)
    return (ONE + g * g - k * k) / (TWO * g)


@kernel(forceinline=True)
def _phase(g, cosine):
    """The density of that, sr^-1."""
    square = max(ONE + g * g - TWO * g * cosine, np.float32(1e-12))
    return _PER_SPHERE * (ONE - g * g) / (square * math.sqrt(square))


@kernel(forceinline=True)
def _turn(walkers, medium, w, step):
    """Scatter, as the medium does or guided to the surface, and note the guidance; returns whether
    it was guided."""
    g = medium.anisotropy[w] if step < _SIMILAR else ZERO
    share = _LATER_GUIDED if step >= _SIMILAR else ONE - max(HALF, abs(g) ** np.float32(0.125))
    d, n, length = walkers.direction[w], walkers.outward[w], medium.length[w]
    before, outward = (d[0], d[1], d[2]), (n[0], n[1], n[2])
    spread = math.log((length + ONE) / (length - ONE))
    guided = next_number(walkers, w) < share
    if guided:
        axis = outward
        cosine = length - (length + ONE) * math.exp(-next_number(walkers, w) * spread)
    else:
        axis, cosine = before, _scattered(walkers, w, g)
    sine, phi = math.sqrt(max(ONE - cosine * cosine, ZERO)), TWO * PI * next_number(walkers, w)
    s, t = basis(axis)
    x, y, z = to_world(s, t, axis, sine * math.cos(phi), sine * math.sin(phi), cosine)
    scale = ONE / math.sqrt(x * x + y * y + z * z)
    d[0], d[1], d[2] = x * scale, y * scale, z * scale
    out = min(dot_xyz(outward, d[0], d[1], d[2]), ONE)
    density = TWO * _PER_SPHERE / ((length - out) * spread)
    guide = walkers.guide[w]
    guide[0], guide[1] = share, density / _phase(g, dot_xyz(before, d[0], d[1], d[2]))
    guide[2] = ONE - out / length
    return guided


@kernel(forceinline=True)
def _channels(throughput, albedo, w):
    """How likely each channel is that a way is drawn for."""
    r, g, b = throughput[w, 0], throughput[w, 1], throughput[w, 2]
    r, g, b = r * albedo[w, 0], g * albedo[w, 1], b * albedo[w, 2]
    total = r + g + b
    if total <= ZERO:
        return ONE, ZERO, ZERO
    return r / total, g / total, b / total


@kernel(forceinline=True)
def _extinction(medium, w, a, step):
    """(extinction, scattering) of a channel at a step."""
    whole, albedo, g = medium.extinction[w, a], medium.albedo[w, a], medium.anisotropy[w]
    scattering = whole * albedo
    if step < _SIMILAR:
        return whole, scattering
    return whole - scattering * g, scattering * (ONE - g)


@kernel(forceinline=True)
def _next_way(walkers, medium, w):
    """How far walker w goes before it scatters, metres; its step is counted."""
    step, guided = walkers.steps[w], False
    if step > 0:
        guided = _turn(walkers, medium, w, step)
    p0, p1, _ = _channels(walkers.throughput, medium.albedo, w)
    u = next_number(walkers, w)
    channel = 0 if u < p0 else (1 if u < p0 + p1 else 2)
    extinction, _ = _extinction(medium, w, channel, step)
    if guided:
        extinction *= walkers.guide[w, 2]
    walkers.steps[w] = step + 1
    return -math.log(ONE - next_number(walkers, w)) / extinction


@kernel(forceinline=True)
def _passed(medium, guide, w, a, step, way, ends):
    """(what is left of a channel after a way, the density that it is drawn with for that)."""
    extinction, scattering = _extinction(medium, w, a, step)
    passed = math.exp(-extinction * way)
    left = passed if ends else scattering * passed
    density = passed if ends else extinction * passed
    share, ratio, stretch = guide[w, 0], guide[w, 1], guide[w, 2]
    if share > ZERO:
        passed = math.exp(-extinction * stretch * way)
        own = passed if ends else extinction * stretch * passed
        density += share * (ratio * own - density)
    return left, density


@kernel(forceinline=True)
def _go(walkers, medium, w, way, ends):
    """Take walker w along its way, to a surface if it ends; the most that is left of a channel."""
    p0, p1, p2 = _channels(walkers.throughput, medium.albedo, w)
    step = walkers.steps[w] - 1
    g0, d0 = _passed(medium, walkers.guide, w, 0, step, way, ends)
    g1, d1 = _passed(medium, walkers.guide, w, 1, step, way, ends)
    g2, d2 = _passed(medium, walkers.guide, w, 2, step, way, ends)
    density = p0 * d0 + p1 * d1 + p2 * d2
    scale = ONE / density if density > ZERO else ZERO
    t = walkers.throughput
    t[w, 0], t[w, 1], t[w, 2] = t[w, 0] * g0 * scale, t[w, 1] * g1 * scale, t[w, 2] * g2 * scale
    for a in range(3):
        walkers.position[w, a] += way * walkers.direction[w, a]
    return max(t[w, 0], t[w, 1], t[w, 2])


@kernel
def wander(active, traversal, medium, walkers, meet):
    """Take walkers on until they meet anything, or are lost: meet.face is -1 then."""
    ray = new_look(traversal)
    for k in range(len(active)):
        w = active[k]
        meet.face[k] = -1
        while walkers.steps[w] < MOST_STEPS:
            way = _next_way(walkers, medium, w)
            if meets(traversal, ray, walkers.position[w], walkers.direction[w], way):
                meet.face[k], meet.instance[k], meet.u[k], meet.v[k] = hit_of(ray)
                meet.way[k] = way
                break
            if _go(walkers, medium, w, way, False) <= _FAINT:
                break


@kernel
def look_on(active, traversal, walkers, starts, meet):
    """Write what walkers meet next on their ways, looking from starts, float32 (m, 3)."""
    ray = new_look(traversal)
    for k in range(len(active)):
        meet.face[k] = -1
        if meets(traversal, ray, starts[k], walkers.direction[active[k]], meet.way[k]):
            meet.face[k], meet.instance[k], meet.u[k], meet.v[k] = hit_of(ray)


@kernel
def go_on(active, ends, way, medium, walkers, alive):
    """Take walkers, whose ways have met something, to their ends: bool (m,), at a surface."""
    for k in range(len(active)):
        left = _go(walkers, medium, active[k], way[k], ends[k])
        alive[k] = left > _FAINT and not ends[k]


@kernel
def sort_ends(points, row, active, walkers, object_of, origins, way, kind, far):
    """Write what points are to the ways of rows: 1 = their end, 2 = in the way, 0 = too far; and
    how far they are."""
    for j in range(len(row)):
        k = row[j]
        w, distance = active[k], ZERO
        for a in range(3):
            d = walkers.direction[w, a]
            distance += (points.position[j, a] - origins[k, a]) * d
        far[j] = max(distance, ZERO)
        if distance >= way[k]:
            kind[j] = 0
            continue
        triangle = points.triangle[j]
        first = walkers.steps[w] == 1 and triangle == walkers.triangle[w]
        kind[j] = 1 if object_of[triangle] == walkers.entered[w] and not first else 2
