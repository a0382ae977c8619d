"""A direction from a point to a lamp, its density, and which lamp a direction meets.

Spheres and the sun by the solid angle of their cone, discs by their area, areas by lamp_areas.py,
meshes by lamp_meshes.py.
All of it in float64: a sun of half a degree is a difference of numbers close to one.
"""

from __future__ import annotations

import math

import numpy as np

from .._jit import kernel
from ..data.lamps import BEAM, DISC, MESH, ROUND_BEAM, SPHERE, SUN
from .lamp_areas import meet_area, sample_area, sample_beam
from .lamp_cones import cone_factor
from .lamp_meshes import meet_mesh, sample_mesh

_TWO_PI = 2.0 * math.pi


@kernel(forceinline=True)
def _one_minus_cos(sin2):
    """1 - cos of an angle whose squared sine is given; no digits are lost where it is small."""
    return sin2 / (1.0 + math.sqrt(max(1.0 - sin2, 0.0)))


@kernel(forceinline=True)
def _around(x, y, z, a, b, c):
    """The local vector (a, b, c) in the frame whose third axis is the unit vector (x, y, z)."""
    sign = math.copysign(1.0, z)
    s = -1.0 / (sign + z)
    t = x * y * s
    return (
        a * (1.0 + sign * x * x * s) + b * t + c * x,
        a * sign * t + b * (sign + y * y * s) + c * y,
        -a * sign * x - b * y + c * z,
    )


@kernel(forceinline=True)
def _in_cone(x, y, z, spread, u, v):
    """A direction within a cone about (x, y, z); spread: 1 - cos of the cone's half angle."""
    height = u * spread
    radius, phi = math.sqrt(max(height * (2.0 - height), 0.0)), _TWO_PI * v
    return _around(x, y, z, radius * math.cos(phi), radius * math.sin(phi), 1.0 - height)


@kernel(forceinline=True)
def _center(lamps, i, px, py, pz):
    """Unit vector from a point to the lamp's centre, and the squared distance."""
    x = np.float64(lamps.position[i, 0]) - px
    y = np.float64(lamps.position[i, 1]) - py
    z = np.float64(lamps.position[i, 2]) - pz
    squared = max(x * x + y * y + z * z, 1e-30)
    scale = 1.0 / math.sqrt(squared)
    return x * scale, y * scale, z * scale, squared


@kernel(forceinline=True)
def _sun_spread(lamps, i):
    """1 - cos of half a sun's angle."""
    sine = math.sin(0.5 * np.float64(lamps.size[i, 0]))
    return 2.0 * sine * sine


@kernel
def _sample_sun(lamps, i, a, b):
    x = -np.float64(lamps.forward[i, 0])
    y = -np.float64(lamps.forward[i, 1])
    z = -np.float64(lamps.forward[i, 2])
    if lamps.size[i, 0] == 0.0:
        return x, y, z, np.inf, 1.0, 1.0
    spread = _sun_spread(lamps, i)
    dx, dy, dz = _in_cone(x, y, z, spread, a, b)
    return dx, dy, dz, np.inf, 1.0, 1.0 / (_TWO_PI * spread)


@kernel(forceinline=True)
def _to_sphere(cosine, squared, radius2):
    """Distance along a ray to a sphere; cosine: between the ray and the centre; < 0: it misses."""
    inside = radius2 - squared * (1.0 - cosine * cosine)
    if inside < 0.0:
        return -1.0
    near, half = math.sqrt(squared) * cosine, math.sqrt(inside)
    return near - half if squared > radius2 else near + half


@kernel
def _sample_sphere(lamps, i, px, py, pz, nx, ny, nz, a, b):
    cx, cy, cz, squared = _center(lamps, i, px, py, pz)
    radius = np.float64(lamps.size[i, 0])
    if radius == 0.0:
        factor = cone_factor(lamps, i, cx, cy, cz) / squared
        return cx, cy, cz, math.sqrt(squared), factor, 1.0
    radius2 = radius * radius
    if squared <= radius2:
        dx, dy, dz = _around(nx, ny, nz, *_on_hemisphere(a, b))
        pdf = max(dx * nx + dy * ny + dz * nz, 1e-9) / math.pi
    else:
        spread = _one_minus_cos(radius2 / squared)
        dx, dy, dz = _in_cone(cx, cy, cz, spread, a, b)
        pdf = 1.0 / (_TWO_PI * spread)
    far = _to_sphere(dx * cx + dy * cy + dz * cz, squared, radius2)
    if far < 0.0:  # the rim of the cone, by rounding
        far = math.sqrt(max(squared - radius2, 0.0))
    factor = 1.0 if squared <= radius2 else cone_factor(lamps, i, dx, dy, dz)
    return dx, dy, dz, far, factor, pdf


@kernel(forceinline=True)
def _on_hemisphere(a, b):
    """A direction with density cos / pi about (0, 0, 1)."""
    radius, phi = math.sqrt(a), _TWO_PI * b
    return radius * math.cos(phi), radius * math.sin(phi), math.sqrt(max(1.0 - a, 0.0))


@kernel
def _sample_disc(lamps, i, px, py, pz, a, b):
    cx, cy, cz, squared = _center(lamps, i, px, py, pz)
    radius, height = np.float64(lamps.size[i, 0]), math.sqrt(squared)
    if radius == 0.0:
        return cx, cy, cz, height, cone_factor(lamps, i, cx, cy, cz) / squared, 1.0
    r, phi = radius * math.sqrt(a), _TWO_PI * b
    far = math.sqrt(squared + r * r)
    scale = 1.0 / far
    dx, dy, dz = _around(
        cx, cy, cz, scale * r * math.cos(phi), scale * r * math.sin(phi), scale * height
    )
    pdf = far * far * far / (height * math.pi * radius * radius)
    return dx, dy, dz, far, cone_factor(lamps, i, dx, dy, dz), pdf


@kernel
def sample_lamp(lamps, i, px, py, pz, nx, ny, nz, a, b):
    """A direction from a point to lamp i: (dx, dy, dz, distance, factor, pdf in sr^-1, face).

    The light from there is the lamp's radiance times factor; 0: none, whatever the rest. Of a lamp
    without size pdf is 1 and its intensity or irradiance takes the place of radiance x solid angle.
    face: row of its radiance in lamps.faces, of a MESH; else -1
    px, py, pz; nx, ny, nz: float64, of the point and its normal; a, b: numbers in [0, 1)
    """
    if lamps.kind[i] == MESH:
        return sample_mesh(lamps, i, px, py, pz, nx, ny, nz, a, b)
    dx, dy, dz, far, factor, pdf = _sample_shape(lamps, i, px, py, pz, nx, ny, nz, a, b)
    return dx, dy, dz, far, factor, pdf, -1


@kernel
def _sample_shape(lamps, i, px, py, pz, nx, ny, nz, a, b):
    kind = lamps.kind[i]
    if kind == SUN:
        return _sample_sun(lamps, i, a, b)
    if kind == SPHERE:
        return _sample_sphere(lamps, i, px, py, pz, nx, ny, nz, a, b)
    if kind == DISC:
        return _sample_disc(lamps, i, px, py, pz, a, b)
    if kind == BEAM or kind == ROUND_BEAM:
        return sample_beam(lamps, i, px, py, pz)
    return sample_area(lamps, i, px, py, pz, a, b)


@kernel
def _meet_sun(lamps, i, dx, dy, dz):
    x = dx + np.float64(lamps.forward[i, 0])
    y = dy + np.float64(lamps.forward[i, 1])
    z = dz + np.float64(lamps.forward[i, 2])
    spread = _sun_spread(lamps, i)
    if 0.5 * (x * x + y * y + z * z) > spread:  # half the squared chord is 1 - cos
        return 0.0, 0.0, 0.0
    return np.inf, 1.0, 1.0 / (_TWO_PI * spread)


@kernel
def _meet_ball(lamps, i, px, py, pz, nx, ny, nz, dx, dy, dz):
    """meet_lamp of a SPHERE or a DISC."""
    cx, cy, cz, squared = _center(lamps, i, px, py, pz)
    radius = np.float64(lamps.size[i, 0])
    radius2, cosine = radius * radius, dx * cx + dy * cy + dz * cz
    if lamps.kind[i] == DISC:
        if cosine <= 1e-9 or squared * (1.0 / (cosine * cosine) - 1.0) > radius2:
            return 0.0, 0.0, 0.0
        height = math.sqrt(squared)
        far = height / cosine
        pdf = far * far * far / (height * math.pi * radius2)
        return far, cone_factor(lamps, i, dx, dy, dz), pdf
    far = _to_sphere(cosine, squared, radius2)
    if far <= 0.0:
        return 0.0, 0.0, 0.0
    if squared <= radius2:
        return far, 1.0, max(dx * nx + dy * ny + dz * nz, 1e-9) / math.pi
    pdf = 1.0 / (_TWO_PI * _one_minus_cos(radius2 / squared))
    return far, cone_factor(lamps, i, dx, dy, dz), pdf


@kernel
def meet_lamp(lamps, i, px, py, pz, nx, ny, nz, dx, dy, dz, beyond):
    """Where a ray meets lamp i, which has a size: (distance, factor, pdf, face as of sample_lamp).

    (0, 0, 0, -1): it does not. The rest as for sample_lamp; dx, dy, dz: float64, unit
    beyond: of a MESH, a distance: the nearest face that is farther than that is met
    """
    if lamps.kind[i] == MESH:
        return meet_mesh(lamps, i, px, py, pz, nx, ny, nz, dx, dy, dz, beyond)
    far, factor, pdf = _meet_shape(lamps, i, px, py, pz, nx, ny, nz, dx, dy, dz)
    return far, factor, pdf, -1


@kernel
def _meet_shape(lamps, i, px, py, pz, nx, ny, nz, dx, dy, dz):
    kind = lamps.kind[i]
    if kind == SUN:
        return _meet_sun(lamps, i, dx, dy, dz)
    if kind == SPHERE or kind == DISC:
        return _meet_ball(lamps, i, px, py, pz, nx, ny, nz, dx, dy, dz)
    return meet_area(lamps, i, px, py, pz, dx, dy, dz)
