"""Shading points of one material, and integrals over directions by quadrature."""

import numpy as np

from iwis.core._jit import kernel
from iwis.core.bsdf.brdf import (
    eval_at,
    pdf_at,
    pdf_narrowest_at,
    sample_at,
    sample_narrowest_at,
)
from iwis.core.bsdf.lobe_setup import setup_lobes
from iwis.core.bsdf.lobes import Lobes
from iwis.core.bsdf.lobes_at import lobes_at
from iwis.core.scene import GGX, PRINCIPLED, MaterialParams


def material(n=1, **values) -> MaterialParams:
    """n equal rows of parameters: white Principled of roughness 0.5, but for what is given."""
    defaults = {
        "model": PRINCIPLED,
        "distribution": GGX,
        "base_color": (1.0, 1.0, 1.0),
        "metallic": 0.0,
        "roughness": 0.5,
        "ior": 1.5,
        "specular_level": 0.5,
        "specular_tint": (1.0, 1.0, 1.0),
        "emission": (0.0, 0.0, 0.0),
        "diffuse_roughness": 0.0,
    }
    columns = {}
    for name, value in (defaults | values).items():
        dtype = np.int8 if name in ("model", "distribution") else np.float32
        columns[name] = np.repeat(np.array([value], dtype), n, axis=0)
    return MaterialParams(**columns)


def directions(cosines) -> np.ndarray:
    """float32 (n, 3) in the plane y = 0, with the given cosines to +z."""
    cosines = np.asarray(cosines, np.float64)
    return np.stack([np.sqrt(1 - cosines**2), 0 * cosines, cosines], -1).astype(np.float32)


def points(wo, normal=None, geometric_normal=None, **values) -> Lobes:
    """Lobes of one material seen from directions wo (n, 3); normals (n, 3), +z unless given."""
    wo = np.ascontiguousarray(wo, np.float32)
    up = np.tile(np.float32([0, 0, 1]), (len(wo), 1))
    normal = up if normal is None else np.ascontiguousarray(normal, np.float32)
    geometric_normal = normal if geometric_normal is None else np.float32(geometric_normal)
    return setup_lobes(material(len(wo), **values), normal, geometric_normal, wo)


def sphere_quadrature(n_cos=256, n_phi=512):
    """float32 directions (n, 3) and solid angles (n,) of the sphere: Gauss in z, even in phi."""
    nodes, weights = np.polynomial.legendre.leggauss(n_cos)
    # Half a sphere has its own nodes: the BRDF has its edge at the horizon.
    z = np.concatenate([0.5 * nodes - 0.5, 0.5 * nodes + 0.5])
    weights = np.concatenate([weights, weights]) * np.pi / n_phi
    phi = (np.arange(n_phi) + 0.5) * (2.0 * np.pi / n_phi)
    r = np.sqrt(1.0 - z * z)[:, None]
    xyz = np.stack([r * np.cos(phi), r * np.sin(phi), np.repeat(z[:, None], n_phi, 1)], -1)
    return xyz.reshape(-1, 3).astype(np.float32), np.repeat(weights, n_phi).astype(np.float32)


@kernel
def eval_all(lobes, p, wi, out):
    """Write eval_at of point p and each wi (n, 3) to out, float32 (n, 6)."""
    at = lobes_at(lobes, p)
    for i in range(wi.shape[0]):
        value = eval_at(at, wi[i, 0], wi[i, 1], wi[i, 2])
        for c in range(6):
            out[i, c] = value[c]


@kernel
def pdf_all(lobes, p, wi, out):
    """Write pdf_at of point p and each wi (n, 3) to out, float32 (n,)."""
    at = lobes_at(lobes, p)
    for i in range(wi.shape[0]):
        out[i] = pdf_at(at, wi[i, 0], wi[i, 1], wi[i, 2])


@kernel
def sample_all(lobes, p, u, out):
    """Write sample_at of point p and each pair u (n, 2) to out, float32 (n, 4)."""
    at = lobes_at(lobes, p)
    for i in range(u.shape[0]):
        sample = sample_at(at, u[i, 0], u[i, 1])
        for c in range(4):
            out[i, c] = sample[c]


@kernel
def sample_narrowest_all(lobes, p, u, out):
    """Write sample_narrowest_at of point p and each pair u (n, 2), and its density, to out,
    float32 (n, 4)."""
    at = lobes_at(lobes, p)
    for i in range(u.shape[0]):
        x, y, z = sample_narrowest_at(at, u[i, 0], u[i, 1])
        out[i, 0], out[i, 1], out[i, 2] = x, y, z
        out[i, 3] = pdf_narrowest_at(at, x, y, z)


def evaluated(lobes, p, wi) -> np.ndarray:
    """float32 (n, 6): brdf * cos of the Lambert lobe and of the gloss."""
    out = np.empty((len(wi), 6), np.float32)
    eval_all(lobes, p, wi, out)
    return out


def densities(lobes, p, wi) -> np.ndarray:
    """float32 (n,), sr^-1."""
    out = np.empty(len(wi), np.float32)
    pdf_all(lobes, p, wi, out)
    return out


def sampled(lobes, p, u):
    """Directions float32 (n, 3) and their densities (n,)."""
    out = np.empty((len(u), 4), np.float32)
    sample_all(lobes, p, np.ascontiguousarray(u, np.float32), out)
    return np.ascontiguousarray(out[:, :3]), out[:, 3]


def narrowest(lobes, p, rng, n):
    """n directions by the narrowest lobe, float32 (n, 3), and their densities (n,)."""
    out = np.empty((n, 4), np.float32)
    sample_narrowest_all(lobes, p, rng.random((n, 2), np.float32), out)
    return np.ascontiguousarray(out[:, :3]), out[:, 3]


def reflected(lobes, p, radiance=None, quadrature=None) -> np.ndarray:
    """Light from the sphere that point p sends to wo: float64 (6,); radiance (n, 3) or white."""
    wi, solid_angle = sphere_quadrature() if quadrature is None else quadrature
    value = evaluated(lobes, p, wi).astype(np.float64)
    if radiance is not None:
        value *= np.tile(radiance, 2)
    return solid_angle.astype(np.float64) @ value
