"""Material fits that come with IWIS: a Lambert and a GGX lobe each, as tables like MERL's.

Their numbers were fitted by us to the reflectance of neural fits of the MERL materials that the
paper shows [Sztrajman21, Matusik03]. They stand in where a user has no MERL files: same character
(matte, glossy, metallic), not the measurement.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core.bsdf.measured import fit_lobes
from ..core.bsdf.merl import SIDES
from ..core.scene import MeasuredBrdfs


class Fit(NamedTuple):
    """diffuse, f0: linear RGB, reflectance of the Lambert lobe, and of GGX facets head on.

    alpha: width of GGX; the Fresnel factor is Schlick's
    """

    diffuse: tuple[float, float, float]
    f0: tuple[float, float, float]
    alpha: float


FITS = {
    "blue-rubber": Fit((0.035, 0.067, 0.133), (0.013, 0.017, 0.030), 0.24),
    "purple-paint": Fit((0.280, 0.032, 0.029), (0.036, 0.034, 0.034), 0.082),
    "alum-bronze": Fit((0.043, 0.034, 0.022), (0.088, 0.063, 0.045), 0.10),
}


def _angles():
    """wi_z, wo_z, cos theta_h, cos theta_d at every sample of a table."""
    theta_h = ((np.arange(SIDES[0]) / 90.0) ** 2 * np.pi / 2.0)[:, None, None]
    theta_d = (np.arange(SIDES[1]) / 90.0 * np.pi / 2.0)[None, :, None]
    phi_d = (np.arange(SIDES[2]) / 180.0 * np.pi)[None, None, :]
    even = np.cos(theta_d) * np.cos(theta_h)
    odd = np.sin(theta_d) * np.cos(phi_d) * np.sin(theta_h)
    shape = np.broadcast_shapes(even.shape, odd.shape)
    cos_h, cos_d = np.broadcast_to(np.cos(theta_h), shape), np.broadcast_to(np.cos(theta_d), shape)
    return even - odd, even + odd, cos_h, cos_d


def table_of(fit: Fit) -> np.ndarray:
    """float32 (90, 90, 180, 3), sr^-1, filled below the horizon as core.merl.read_merl() does."""
    wi_z, wo_z, cos_h, cos_d = _angles()
    wi_z, wo_z = np.maximum(wi_z, 0.02), np.maximum(wo_z, 0.02)
    alpha2 = fit.alpha**2
    density = alpha2 / (np.pi * (1.0 - cos_h**2 * (1.0 - alpha2)) ** 2)

    def hidden(z):
        z = np.minimum(z, 1.0)
        return 0.5 * (np.sqrt(1.0 + alpha2 * (1.0 / z**2 - 1.0)) - 1.0)

    gloss = density / (4.0 * wi_z * wo_z * (1.0 + hidden(wi_z) + hidden(wo_z)))
    schlick = (1.0 - cos_d) ** 5
    values = np.empty((*SIDES, 3), np.float32)
    for c in range(3):
        fresnel = fit.f0[c] + (1.0 - fit.f0[c]) * schlick
        values[..., c] = fit.diffuse[c] / np.pi + gloss * fresnel
    return values


def fitted_material(name: str) -> MeasuredBrdfs:
    """The fit of that name, ready to render."""
    values = table_of(FITS[name])
    return MeasuredBrdfs(values[None], fit_lobes(values)[None], (f"iwis {name} {FITS[name]}",))
