"""Small synthetic MERL files, and the slow reader of one that eval_merl must agree with."""

import numpy as np

from iwis.core.bsdf.measured import fit_lobes
from iwis.core.scene import MEASURED, MeasuredBrdfs
from support.scenes import MATERIAL

SIDES = (90, 90, 180)
SCALE = np.array([1.0, 1.15, 1.66]) / 1500.0


def measured(tint=(1.0, 1.0, 1.0), row=0) -> dict:
    """A material of row ``row`` of the scene's measured BRDFs."""
    return MATERIAL | {"model": MEASURED, "distribution": row, "base_color": tint}


def node_angles():
    """theta_h, theta_d, phi_d of all samples, radians, broadcastable."""
    h, d, p = (np.arange(n) for n in SIDES)
    theta_h = (h / 90.0) ** 2 * np.pi / 2.0
    return theta_h[:, None, None], np.radians(d)[None, :, None], np.radians(p)[None, None, :]


def lifted():
    """bool (90, 90, 180): the samples whose two directions are above the surface."""
    h, d, p = node_angles()
    even, odd = np.cos(d) * np.cos(h), np.sin(d) * np.cos(p) * np.sin(h)
    return (even - odd > 0.0) & (even + odd > 0.0)


def write_merl(path, values, sides=SIDES):
    """Write float64 (90, 90, 180, 3), sr^-1; negative below the surface, as the originals are."""
    planes = np.where(lifted()[..., None], values / SCALE, -1.0)
    with open(path, "wb") as file:
        file.write(np.array(sides, "<i4").tobytes())
        file.write(planes.transpose(3, 0, 1, 2).astype("<f8").tobytes())
    return path


def lambert_table(albedo=(0.8, 0.5, 0.2)) -> np.ndarray:
    """float32 (90, 90, 180, 3): albedo / pi everywhere."""
    return np.full((*SIDES, 3), np.array(albedo) / np.pi, np.float32)


def glossy_table(color=(0.5, 0.3, 0.1), width=0.15, floor=0.05) -> np.ndarray:
    """A smooth lobe over a matte floor that brightens at grazing theta_d; not any model of ours."""
    h, d, p = node_angles()
    lobe = np.exp(-((np.tan(np.minimum(h, 1.5)) / width) ** 2)) * (1.0 + 2.0 * np.sin(d) ** 4)
    even = 1.0 + 0.1 * np.cos(2.0 * p) * np.sin(d)
    return np.float32((lobe * even)[..., None] * np.array(color) + floor)


def brdfs(*tables) -> MeasuredBrdfs:
    """Tables as the scene has them."""
    fits = np.stack([fit_lobes(table) for table in tables])
    keys = tuple(f"{hash(table.tobytes())}" for table in tables)
    return MeasuredBrdfs(np.stack(tables), fits, keys)


def eval_table(table, wo, wi) -> np.ndarray:
    """The BRDF of directions (n, 3), z up, found as [Matusik03] does: wi is turned about z, then y.

    float64 (n, 3); linear between samples, the last ones go on
    """
    wo, wi = np.broadcast_arrays(np.asarray(wo, np.float64), np.asarray(wi, np.float64))
    half = wo + wi
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    theta_h = np.arccos(np.clip(half[:, 2], -1.0, 1.0))
    phi_h = np.arctan2(half[:, 1], half[:, 0])
    x = wi[:, 0] * np.cos(phi_h) + wi[:, 1] * np.sin(phi_h)
    y = -wi[:, 0] * np.sin(phi_h) + wi[:, 1] * np.cos(phi_h)
    x, z = (
        x * np.cos(theta_h) - wi[:, 2] * np.sin(theta_h),
        x * np.sin(theta_h) + wi[:, 2] * np.cos(theta_h),
    )
    theta_d, phi_d = np.arccos(np.clip(z, -1.0, 1.0)), np.arctan2(y, x)
    at = [np.sqrt(theta_h / (np.pi / 2.0)) * 90.0, np.degrees(theta_d), np.degrees(phi_d) % 180.0]
    low = [np.minimum(np.floor(a).astype(int), n - 1) for a, n in zip(at, SIDES, strict=True)]
    part = [np.clip(a - i, 0.0, 1.0) for a, i in zip(at, low, strict=True)]
    total = np.zeros((len(wo), 3))
    for corner in np.ndindex(2, 2, 2):
        i, j = (np.minimum(low[a] + corner[a], SIDES[a] - 1) for a in range(2))
        k = (low[2] + corner[2]) % SIDES[2]
        weight = np.prod([f if c else 1.0 - f for f, c in zip(part, corner, strict=True)], axis=0)
        total += weight[:, None] * table[i, j, k]
    return total
