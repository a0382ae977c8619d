"""Microfacets: how normals are distributed, seen and sampled, and what one facet reflects.

[Walter07] for the model, [Heitz14] for the height-correlated Smith term, [Dupuy23] for the visible
normals (a cap of the sphere), [Beckmann63] with Walter's rational fit of its Smith
term, [Kutz21] for the F82 metal. Cycles' constants, so that pictures agree: the fit is cut to zero
below 0.39, and F82 has its edge at cos = 1/7.

All vectors of this file are in the local frame, z = the normal of the microsurface, and float32.
"""

import math

import numpy as np

from .._jit import kernel

PI = np.float32(math.pi)
INV_PI = np.float32(1.0 / math.pi)
ZERO, HALF, ONE, TWO, FOUR = (np.float32(x) for x in (0.0, 0.5, 1.0, 2.0, 4.0))
QUARTER = np.float32(0.25)
# Smaller lobes are widened to this: 0.006 degrees, a texel of a 64k panorama. Below it the float32
# of a direction cannot tell where in the lobe it lies; Cycles calls 1.4e-5 a perfect mirror.
MIN_ALPHA = np.float32(1e-4)
_TINY = np.float32(1e-12)

_F82 = 6.0 / 7.0
F82_SCHLICK = np.float32(_F82**5)
F82_FACTOR = np.float32(7.0 / _F82**6)


@kernel(forceinline=True)
def ggx_d(alpha2, sin2):
    """Density of normals over projected area, sr^-1; sin2: sine squared of the normal's angle."""
    t = sin2 + alpha2 * (ONE - sin2)
    return alpha2 * INV_PI / (t * t)


@kernel(forceinline=True)
def ggx_lambda(alpha2, cos_theta):
    """Smith's Lambda [Heitz14, eq. 72]; 1 / (1 + Lambda) of the facets are seen."""
    tan2 = max(ONE / (cos_theta * cos_theta) - ONE, ZERO)
    return HALF * (math.sqrt(ONE + alpha2 * tan2) - ONE)


@kernel(forceinline=True)
def beckmann_d(alpha2, sin2):
    """As ggx_d, for Gaussian slopes."""
    cos2 = ONE - sin2
    if cos2 <= ZERO:
        return ZERO
    return math.exp(-sin2 / (alpha2 * cos2)) * INV_PI / (alpha2 * cos2 * cos2)


@kernel(forceinline=True)
def beckmann_lambda(alpha2, cos_theta):
    """Smith's Lambda of Gaussian slopes, Walter's rational fit [Walter07, below eq. 25]."""
    tan2 = alpha2 * max(ONE / (cos_theta * cos_theta) - ONE, ZERO)
    if tan2 < np.float32(0.39):
        return ZERO
    a = ONE / math.sqrt(tan2)
    top = (np.float32(0.396) * a - np.float32(1.259)) * a + ONE
    return top / ((np.float32(2.181) * a + np.float32(3.535)) * a)


@kernel(forceinline=True)
def sample_ggx_visible_normal(wo_x, wo_y, wo_z, alpha_x, alpha_y, u1, u2):
    """A facet normal, with the density of those that wo sees: D (wo . h) / (wo_z (1 + Lambda))."""
    x, y, z = alpha_x * wo_x, alpha_y * wo_y, wo_z
    scale = ONE / math.sqrt(x * x + y * y + z * z)
    x, y, z = x * scale, y * scale, z * scale
    phi = TWO * PI * u1
    cap_z = (ONE - u2) * (ONE + z) - z
    cap_r = math.sqrt(max(ONE - cap_z * cap_z, ZERO))
    hx = alpha_x * (cap_r * math.cos(phi) + x)
    hy = alpha_y * (cap_r * math.sin(phi) + y)
    hz = max(cap_z + z, ZERO)
    scale = ONE / math.sqrt(max(hx * hx + hy * hy + hz * hz, np.float32(1e-30)))
    return hx * scale, hy * scale, hz * scale


@kernel(forceinline=True)
def sample_beckmann_normal(alpha_x, alpha_y, u1, u2):
    """A facet normal with density D cos: all facets, whether seen or not."""
    phi = TWO * PI * u1
    slope = math.sqrt(-math.log(max(ONE - u2, np.float32(1e-30))))
    x, y = alpha_x * slope * math.cos(phi), alpha_y * slope * math.sin(phi)
    z = ONE / math.sqrt(ONE + x * x + y * y)
    return x * z, y * z, z


@kernel(forceinline=True)
def f0_of_ior(eta):
    """Reflectance of a smooth dielectric, seen along its normal."""
    r = (eta - ONE) / (eta + ONE)
    return r * r


@kernel(forceinline=True)
def ior_of_f0(f0):
    """The index of refraction, 1 or more, whose f0_of_ior is f0 (no more than 0.99)."""
    root = math.sqrt(min(max(f0, ZERO), np.float32(0.99)))
    return (ONE + root) / (ONE - root)


@kernel(forceinline=True)
def dielectric_blend(cos_theta, eta2_minus_1, f0_real, inv_range):
    """Where the real Fresnel curve stands between its value at the normal (0) and one (1).

    eta2_minus_1: square of the index of refraction, less one; f0_real: f0_of_ior of that index;
    inv_range: 1 / (1 - f0_real). Beyond the critical angle: 1.
    """
    c = cos_theta
    g2 = eta2_minus_1 + c * c
    if g2 <= ZERO:
        return ONE
    g = math.sqrt(g2)
    a = (g - c) / (g + c)
    b = (c * (g + c) - ONE) / (c * (g - c) + ONE)
    reflectance = HALF * a * a * (ONE + b * b)
    return min(max((reflectance - f0_real) * inv_range, ZERO), ONE)


@kernel(forceinline=True)
def dielectric_mean(eta):
    """Cosine-weighted mean reflectance of a smooth dielectric [Kulla17, numerical fit]."""
    if eta < ONE:
        tail = np.float32(0.965241) + eta * np.float32(0.130607)
        return np.float32(0.997118) + eta * (np.float32(0.1014) - eta * tail)
    return (eta - ONE) / (np.float32(4.08567) + np.float32(1.00071) * eta)


@kernel(forceinline=True)
def schlick_weight(cos_theta):
    """(1 - cos)^5."""
    s = min(max(ONE - cos_theta, ZERO), ONE)
    s2 = s * s
    return s2 * s2 * s


@kernel(forceinline=True)
def f82_curve(f0, edge, s, t):
    """The reflectance of a metal [Kutz21]; s: schlick_weight(cos); t: cos (1 - cos)^6."""
    return min(max(f0 + (ONE - f0) * s - edge * t, ZERO), ONE)


@kernel(forceinline=True)
def f82_edge(f0, tint):
    """The factor of cos (1 - cos)^6 that scales Schlick's curve by ``tint`` at cos = 1/7."""
    return (f0 + (ONE - f0) * F82_SCHLICK) * F82_FACTOR * (ONE - tint)


@kernel(forceinline=True)
def f82_mean(f0, edge):
    """Cosine-weighted mean of the F82 curve: 2 int (F0 + (1 - F0) s^5 - edge c s^6) c dc."""
    return f0 + (ONE - f0) * np.float32(1.0 / 21.0) - edge * np.float32(1.0 / 126.0)


@kernel(forceinline=True)
def dot(a, b):
    """Of two triples or rows."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel(forceinline=True)
def dot_xyz(a, x, y, z):
    """a . (x, y, z), of a tuple."""
    return a[0] * x + a[1] * y + a[2] * z


@kernel(forceinline=True)
def cross(a, b):
    """a x b, of tuples."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@kernel(forceinline=True)
def half_vector(wo, wi_x, wi_y, wi_z):
    """The unit vector halfway between wo and wi, and wo . h: (x, y, z, cosine)."""
    hx, hy, hz = wo[0] + wi_x, wo[1] + wi_y, wo[2] + wi_z
    length2 = max(hx * hx + hy * hy + hz * hz, _TINY)
    scale = ONE / math.sqrt(length2)
    return hx * scale, hy * scale, hz * scale, HALF * length2 * scale


@kernel(forceinline=True)
def basis(n):
    """Two unit vectors that make a right-handed frame with the unit vector [Duff17]."""
    x, y, z = n
    sign = math.copysign(ONE, z)
    a = -ONE / (sign + z)
    b = x * y * a
    return (ONE + sign * x * x * a, sign * b, -sign * x), (b, sign + y * y * a, -y)


@kernel(forceinline=True)
def to_world(s, t, n, x, y, z):
    """(x, y, z) of the frame s, t, n."""
    return (
        x * s[0] + y * t[0] + z * n[0],
        x * s[1] + y * t[1] + z * n[1],
        x * s[2] + y * t[2] + z * n[2],
    )
