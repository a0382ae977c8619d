"""The lobes of a material at a shading point: what every sample of the point shares.

Data alone; lobe_setup.py fills it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.rows import any_in_row, rows_of

# Bits of Lobes.kind
DIFFUSE_LOBE, DIELECTRIC_LOBE, CONDUCTOR_LOBE, MEASURED_LOBE, THIN_FILM = 1, 2, 4, 8, 16
# Rows of Lobes.weight and Lobes.f0
DIELECTRIC, CONDUCTOR = 0, 1


class Lobes(NamedTuple):
    """The BRDF at n shading points. Vectors are unit, in world space, away from the surface.

    brdf * cos = diffuse / pi * max(normal . wi, 0), times a factor where it is rough
               + sum of weight F(wo . h) over both curves * D(h) / (4 cos_o (seen + Lambda(wi)))

    A measured BRDF is tint x its table; its Lambert and conductor lobes are fitted to it for this
    wo, and only say where samples go, and how the light is shared among the passes.

    kind: int8 (n,), which lobes there are: DIFFUSE_LOBE | DIELECTRIC_LOBE | CONDUCTOR_LOBE, and
        MEASURED_LOBE where a table has the value; THIN_FILM: on the gloss, of which tint says
        what film, and which has other curves (thin_film.py)
    distribution: int8 (n,), GGX, MULTI_GGX (the same D and Lambda) or BECKMANN
    alpha: float32 (n,), width of D; narrow: float32 (n,), its width across ``tangent``, float32
        (n, 3), unit, along which it is alpha; 0 = it is round (stretched.py)
    diffuse: float32 (n, 3), reflectance of the Lambert lobe, layers above deducted; at once Cycles'
        Diffuse Color (but of what is glossy there: sheen.diffuse_colors)
    weight, f0: float32 (n, 2, 3), factor of the curve, and its value along the normal:
        DIELECTRIC: F = f0 + (1 - f0) dielectric_blend(cos, *fresnel)
        CONDUCTOR: F = f0 + (1 - f0) (1 - cos)^5 - edge cos (1 - cos)^6, cut to 0 ... 1
    edge: float32 (n, 3); fresnel: float32 (n, 3), what dielectric_blend wants of the index
    normal: float32 (n, 3), shading normal, on the viewer's side of the geometry
    glossy_normal: float32 (n, 3), the same, turned so far that the mirrored wo leaves the geometry
    wo: float32 (n, 3); cos_o, seen: float32 (n,), glossy_normal . wo and 1 + Lambda(wo)
    diffuse_share: float32 (n,), how often sample_at takes the Lambert lobe
    glossy_color: float32 (n, 3), Cycles' Glossy Color; emission: float32 (n, 3), radiance
    smooth: float32 (n, 3), the surface's own normal, where the shading normal is another; bump:
        float32 (n,), tan^2 / 8 of the angle between them, at most 1; 0 = the same (bump_gain)
    rough: float32 (n, 4), rough_diffuse.py: factor of later bounces (r, g, b), and B; 0: Lambert's;
        the last below 0: lambert_kinds.py
    tint: float32 (n, 3); table: int32 (n,), row of ``tables``: of measured BRDFs
    tables: float32 (m, 90, 90, 180, 3), MeasuredBrdfs.values; the one array that is not by point
    """

    kind: np.ndarray
    distribution: np.ndarray
    alpha: np.ndarray
    diffuse: np.ndarray
    weight: np.ndarray
    f0: np.ndarray
    edge: np.ndarray
    fresnel: np.ndarray
    normal: np.ndarray
    glossy_normal: np.ndarray
    wo: np.ndarray
    cos_o: np.ndarray
    seen: np.ndarray
    diffuse_share: np.ndarray
    glossy_color: np.ndarray
    emission: np.ndarray
    smooth: np.ndarray
    bump: np.ndarray
    rough: np.ndarray
    narrow: np.ndarray
    tangent: np.ndarray
    tint: np.ndarray
    table: np.ndarray
    tables: np.ndarray

    def at(self, which) -> Lobes:
        """Those of a slice or of indices."""
        return Lobes(*rows_of(self[:-1], which), self.tables)


def darken_matte(lobes: Lobes, factor: np.ndarray) -> None:
    """Multiply the Lambert lobes of n points by float32 (n, 3), in place."""
    lobes.diffuse[:] *= factor
    black = ~any_in_row(lobes.diffuse)
    lobes.kind[black] &= ~np.int8(DIFFUSE_LOBE)
    lobes.diffuse_share[black] = 0.0


def matte_alone(lobes: Lobes) -> Lobes:
    """The Lambert lobes alone, smooth."""
    names = ("weight", "glossy_color", "rough")
    nothing = {name: np.zeros_like(getattr(lobes, name)) for name in names}
    kind = lobes.kind & np.int8(DIFFUSE_LOBE)
    return lobes._replace(kind=kind, diffuse_share=(kind != 0).astype(np.float32), **nothing)
