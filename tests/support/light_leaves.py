"""The leaves of a LightPyramid as plain arrays, and worlds whose light is hard to find."""

import numpy as np

from iwis.core._jit import kernel
from iwis.core.light.environment import eval_environment_many
from iwis.core.light.pyramid import level_offset
from iwis.core.scene import EnvironmentMap
from iwis.core.unit_square.sphere_map import square_to_sphere

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def leaves_of(pyramid):
    """(average, size, x, y), float64 (n,): each leaf's light, side and corner in the square."""
    begin = level_offset(pyramid.levels)
    nodes = np.arange(begin, level_offset(pyramid.levels + 1))
    bits = np.arange(pyramid.levels)
    x = (((nodes - begin)[:, None] >> (2 * bits) & 1) << bits).sum(1) / (1 << pyramid.levels)
    y = (((nodes - begin)[:, None] >> (2 * bits + 1) & 1) << bits).sum(1) / (1 << pyramid.levels)
    size, found = np.full(len(nodes), 0.5**pyramid.levels), []
    while len(nodes):
        child = pyramid.children[nodes].astype(np.int64)
        end, split = child == 0, child > 0
        found.append((pyramid.averages[nodes[end]].astype(float), size[end], x[end], y[end]))
        half = size[split] / 2
        nodes = np.concatenate([child[split] + q for q in range(4)])
        x = np.concatenate([x[split] + (q & 1) * half for q in range(4)])
        y = np.concatenate([y[split] + (q >> 1) * half for q in range(4)])
        size = np.tile(half, 4)
    return tuple(np.concatenate(column) for column in zip(*found, strict=True))


@kernel
def _directions(x, y, out):
    for i in range(len(x)):
        out[i, 0], out[i, 1], out[i, 2] = square_to_sphere(x[i], y[i])


def looked_up(lookup, directions):
    """float64 (n,): luminance from float64 (n, 3) directions."""
    radiance = np.empty((len(directions), 3), np.float32)
    eval_environment_many(lookup, directions.astype(np.float32), radiance)
    return radiance.astype(float) @ LUMINANCE


def light_weights(pyramid, lookup, n, rng):
    """float64 (n,): L / (4 pi pdf) of independent samples; their mean is the light's."""
    average, size, x, y = leaves_of(pyramid)
    energy = np.cumsum(average * size * size)
    chosen = np.searchsorted(energy, rng.random(n) * energy[-1], side="right")
    chosen = np.minimum(chosen, len(average) - 1)
    directions = np.empty((n, 3))
    u, v = rng.random((2, n)) * size[chosen]
    _directions(x[chosen] + u, y[chosen] + v, directions)
    return looked_up(lookup, directions) / average[chosen] * energy[-1]


def mean_light(texels):
    """Mean luminance over the sphere of an equirectangular map, LINEAR: exact."""
    height = len(texels)
    rows = texels.mean(1, dtype=np.float64) @ LUMINANCE
    rows = np.concatenate([rows[-1:], rows, rows[:1]])  # the map repeats in v
    step = np.pi / height
    first = ((np.arange(-1, height) + 0.5) / height - 0.5) * np.pi  # latitudes of texel centres
    low = np.maximum(first, -np.pi / 2)
    high = np.minimum(first + step, np.pi / 2)

    def rising(t):  # integral of (t - first) / step cos t
        return ((t - first) * np.sin(t) + np.cos(t)) / step

    upper = rising(high) - rising(low)
    lower = np.sin(high) - np.sin(low) - upper
    return float((rows[:-1] * lower + rows[1:] * upper).sum() / 2.0)


def sun_world(height, latitude, brighter=1e5, diameter=0.5, **values):
    """A sky and a ground with a disc of so many degrees, so many times brighter than the sky."""
    up = ((np.arange(height) + 0.5) / height - 0.5) * np.pi
    around = (0.5 - (np.arange(2 * height) + 0.5) / (2 * height)) * 2.0 * np.pi
    texels = np.empty((height, 2 * height, 3), np.float32)
    texels[:] = np.where(up > 0.0, 1.0, 0.3)[:, None, None]
    at = np.radians(latitude)
    near = np.sin(up)[:, None] * np.sin(at) + np.cos(up)[:, None] * np.cos(at) * np.cos(
        around - 0.6
    )
    texels[near > np.cos(np.radians(diameter / 2))] = brighter
    return EnvironmentMap(radiance=texels, **values)


def texel_world(height, latitude, value=1e6, ground=0.0):
    """One lit texel."""
    texels = np.full((height, 2 * height, 3), ground, np.float32)
    texels[int((latitude / 180.0 + 0.5) * height), int(0.8 * height)] = value
    return EnvironmentMap(radiance=texels)
