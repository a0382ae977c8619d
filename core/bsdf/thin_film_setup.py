"""Thin films, written to the lobes of their points (thin_film.py has what they reflect).

As in Cycles, what is under a film gets what a mirror with it does not reflect to the viewer, and
later bounces between facets are those of a surface without one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..data.rows import rows_of
from ..scene import PRINCIPLED, MaterialParams
from .albedo_tables import AlbedoTables, albedo_tables, read_2d
from .lobe_setup import METAL_CUTOFF, facet_albedos, later_gain, set_kind
from .lobes import CONDUCTOR, CONDUCTOR_LOBE, DIELECTRIC, DIELECTRIC_LOBE, THIN_FILM, Lobes
from .microfacet import F82_FACTOR, F82_SCHLICK, ONE, ZERO, f82_mean
from .thin_film import (
    INDEXED,
    conductor_reflectance,
    dielectric_film,
    metal_film,
    triple,
)
from .thin_film_tables import GAUSSIANS, THINNEST

_EDGE = np.float32(1.0 / 7.0)  # the cosine where a metal's edge tint counts
_LEAST_IOR, _MOST_IOR = np.float32(1e-5), np.float32(1e6)
_THICKEST = np.float32(1e9)  # nm


class FilmValues(NamedTuple):
    """A program.ThinFilm at m points: float32 (m,), of colours (m, 3); None as there."""

    space: int
    thickness: np.ndarray
    ior: np.ndarray
    index: np.ndarray | None
    extinction: np.ndarray | None

    def at(self, which) -> FilmValues:
        """Those of a slice, a mask or indices."""
        metal = (self.index, self.extinction)
        metal = metal if self.index is None else rows_of(metal, which)
        return FilmValues(self.space, *rows_of(self[1:3], which), *metal)


def set_film(lobes: Lobes, params: MaterialParams, rows: np.ndarray, film: FilmValues) -> None:
    """Put a film on the gloss of some points: Lobes of n points as setup_lobes left them, written.

    params: one row a point; rows: int (m,), of the points, those of model PRINCIPLED
    """
    code, metal = film.space, (np.zeros((len(rows), 3), np.float32),) * 2
    if film.index is not None:
        code, metal = code | INDEXED, (film.index, film.extinction)
    numbers = (film.thickness, film.ior, *metal)
    numbers = (np.ascontiguousarray(column, dtype=np.float32) for column in numbers)
    _set_film(params, np.int64(rows), tuple(numbers), code, albedo_tables(), lobes)


@kernel
def _set_film(params, rows, film, code, tables: AlbedoTables, out):
    thickness, ior, index, extinction = film
    for i in range(len(rows)):
        p = rows[i]
        if params.model[p] != PRINCIPLED or not thickness[i] > THINNEST:
            continue
        out.tint[p, 0] = min(thickness[i], _THICKEST)
        out.tint[p, 1] = min(ior[i], _MOST_IOR) if ior[i] > _LEAST_IOR else _LEAST_IOR
        out.tint[p, 2] = code
        metallic = min(max(params.metallic[p], ZERO), ONE)
        if metallic <= METAL_CUTOFF:
            metallic = ZERO
        for c in range(3):
            out.glossy_color[p, c] = ZERO
        if metallic > ZERO:
            _set_metal(params, p, metallic, triple(index, i), triple(extinction, i), tables, out)
        _set_dielectric(params, p, ONE - metallic, tables, out)
        set_kind(p, out)
        if out.kind[p] & (DIELECTRIC_LOBE | CONDUCTOR_LOBE):
            out.kind[p] |= THIN_FILM


@kernel
def _set_metal(params, p, metallic, index, extinction, tables, out):
    """Write what film_color asks of the metal under a film, and its color."""
    code, cos_o = int(out.tint[p, 2]), out.cos_o[p]
    albedo, mean_albedo = facet_albedos(params, p, tables, cos_o)
    if code & INDEXED:
        for c in range(3):
            n, k = max(index[c], ZERO), max(extinction[c], ZERO)
            f0, edge = conductor_reflectance(n, k, ONE), conductor_reflectance(n, k, _EDGE)
            bend = (f0 + (ONE - f0) * F82_SCHLICK - edge) * F82_FACTOR
            mean = min(max(f82_mean(f0, bend), ZERO), ONE)
            out.f0[p, CONDUCTOR, c], out.edge[p, c] = n, k
            out.weight[p, CONDUCTOR, c] = metallic * later_gain(albedo, mean_albedo, mean)
    elif code != GAUSSIANS:
        for c in range(3):
            f0 = out.f0[p, CONDUCTOR, c]
            tint = min(max(params.specular_tint[p, c], ZERO), ONE)
            out.edge[p, c] = (f0 + (ONE - f0) * F82_SCHLICK) * tint
    f0, edge = triple(out.f0[p], CONDUCTOR), triple(out.edge, p)
    color = metal_film(triple(out.tint, p), f0, edge, cos_o)
    blend = read_2d(tables.metal, cos_o, min(max(params.roughness[p], ZERO), ONE))
    for c in range(3):
        own = f0[c] + (ONE - f0[c]) * blend if code == GAUSSIANS else color[c]
        out.glossy_color[p, c] += out.weight[p, CONDUCTOR, c] * albedo * own


@kernel
def _set_dielectric(params, p, rest, tables, out):
    """Write the color of the layer under a film, and what it leaves for the Lambert lobe.

    rest: light that the metal leaves for both
    """
    cos_o = out.cos_o[p]
    albedo, _ = facet_albedos(params, p, tables, cos_o)
    if out.fresnel[p, 2] == ZERO:  # of index 1: it is there by its film alone
        out.fresnel[p, 2] = ONE
        for c in range(3):
            out.weight[p, DIELECTRIC, c] = rest
    fresnel, f0 = triple(out.fresnel, p), triple(out.f0[p], DIELECTRIC)
    color = dielectric_film(triple(out.tint, p), fresnel, f0, cos_o)
    layer = ZERO
    for c in range(3):
        own = out.weight[p, DIELECTRIC, c] * albedo * color[c]
        out.glossy_color[p, c] += own
        layer = max(layer, own)
    left = min(max(rest - layer, ZERO), ONE)
    for c in range(3):
        out.diffuse[p, c] = max(params.base_color[p, c], ZERO) * left
