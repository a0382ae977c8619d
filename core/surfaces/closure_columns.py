"""Closures that programs have been evaluated to, written to the columns of points: their lobes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..bsdf.ashikhmin_shirley import set_ashikhmin_shirley
from ..bsdf.bump import turns
from ..bsdf.hair import ALL_ROUND, LAMPS_ALONE
from ..bsdf.hair_setup import HairValues, set_hair, set_starts
from ..bsdf.lobe_setup import setup_lobes
from ..bsdf.lobes import THIN_FILM, Lobes, darken_matte
from ..bsdf.sheen import set_sheen
from ..bsdf.stretched import mean_roughness, stretch_lobes
from ..bsdf.thin_film_setup import FilmValues, set_film
from ..bsdf.toon import set_toon
from ..data.rows import any_in_row, rows_of
from ..geometry.round_points import beyond, circles, is_round, normals_of_strands
from ..geometry.shading import ShadingPoints, params_at
from ..nodes.values import dot
from ..scene import (
    ASHIKHMIN_SHIRLEY,
    BECKMANN,
    DIFFUSE,
    GLOSSY_TOON,
    SHEEN,
    TOON,
    TRANSLUCENT,
    VELVET_SHEEN,
    MaterialParams,
    Scene,
)
from ..walks.subsurface import Media

_FACTORS = (SHEEN, VELVET_SHEEN, TOON, GLOSSY_TOON)  # models that change a Lambert lobe's shape


class ClosureValues(NamedTuple):
    """A closure at m points, as its program has been evaluated.

    which: int (m,), rows of the points; weight: float32 (m, 3); normal: float32 (m, 3), 0 where it
    is the surface's own, or None; params: column of MaterialParams -> values at the points; grain:
    float32 (m, 3), as Closure.grain, or None; matte: float32 (m, 3), factor of its Lambert lobe, or
    None; media: what that lobe's light comes out of, and nothing else is there; or None; hair: what
    that lobe is, or None; film: what is on its gloss, or None
    """

    closure: tuple
    which: np.ndarray
    weight: np.ndarray
    normal: np.ndarray | None
    params: dict[str, np.ndarray]
    grain: np.ndarray | None
    shadows: bool  # light on a turned normal
    corrects: bool  # Program.corrects_bumps
    matte: np.ndarray | None = None
    media: Media | None = None
    hair: HairValues | None = None
    film: FilmValues | None = None

    def at(self, some) -> ClosureValues:
        which, weight, *values = rows_of((self.which, self.weight, *self.params.values()), some)
        params = dict(zip(self.params, values, strict=True))
        vectors = {
            name: rows_of((own,), some)[0]
            for name in ("normal", "grain", "matte")
            if (own := getattr(self, name)) is not None
        }
        own = {
            name: values.at(some)
            for name in ("media", "hair", "film")
            if (values := getattr(self, name)) is not None
        }
        return self._replace(which=which, weight=weight, params=params, **vectors, **own)


class Columns:
    """What setup_lobes wants of n points, to be overwritten by layers."""

    def __init__(self, scene: Scene, points: ShadingPoints):
        self.points, self._scene = points, scene
        self.params = params_at(scene.materials, scene.mesh.material_index[points.triangle])
        self.normal = points.normal.copy()
        self._through = points.reflecting
        self.weight = self._through.copy()
        self._maps_normals = False
        self._turned = np.zeros(len(points.pixel), np.bool_)  # the normal, by a map, and shadowed
        self._as_turned = np.zeros(len(points.pixel), np.bool_)  # Program.corrects_bumps is off
        self._grain = np.zeros((len(points.pixel), 3), np.float32)
        self._shape = np.zeros(len(points.pixel), np.int8)  # one of _FACTORS, or 0
        self._behind = np.zeros(len(points.pixel), np.bool_)  # TRANSLUCENT
        self._phong = np.zeros(len(points.pixel), np.bool_)  # ASHIKHMIN_SHIRLEY
        self._matte: np.ndarray | None = None
        self._hair: list[tuple[np.ndarray, HairValues]] = []
        self._films: list[tuple[np.ndarray, FilmValues]] = []

    def write(self, layer: ClosureValues, rows: np.ndarray) -> None:
        """Give rows the layer's closure."""
        params: MaterialParams = self.params
        model, distribution = layer.closure
        self._phong[rows] = distribution == ASHIKHMIN_SHIRLEY
        params.distribution[rows] = BECKMANN if distribution == ASHIKHMIN_SHIRLEY else distribution
        lambert = model == TRANSLUCENT or model in _FACTORS
        params.model[rows] = DIFFUSE if lambert else model
        self._shape[rows] = model if model in _FACTORS else 0
        self._behind[rows] = model == TRANSLUCENT
        for name, values in layer.params.items():
            getattr(params, name)[rows] = values
        self.weight[rows] = layer.weight * self._through[rows]
        self._as_turned[rows] = not layer.corrects
        if layer.grain is not None:
            self._grain[rows] = layer.grain
        if layer.matte is not None:
            if self._matte is None:
                self._matte = np.ones_like(self.weight)
            self._matte[rows] = layer.matte
        if layer.hair is not None:
            self._hair.append((rows, layer.hair))
        if layer.film is not None:
            self._films.append((rows, layer.film))
        if layer.normal is not None:
            self._maps_normals = True
            kept = any_in_row(layer.normal)
            self.normal[rows[kept]] = layer.normal[kept]
            self._turned[rows[kept]] = layer.shadows

    def made(self) -> tuple[ShadingPoints, Lobes]:
        """The points, on the side that their closure shines from, and its lobes."""
        lobes, behind = self._lobes(), self._behind
        if not behind.any() and not self._hair:
            return self.points, lobes
        points = self._beyond_strands(self.points.from_behind(behind), lobes)
        side = np.where(behind, np.float32(-1.0), np.float32(1.0))[:, None]
        return points, lobes._replace(normal=lobes.normal * side, smooth=lobes.smooth * side)

    def _beyond_strands(self, points: ShadingPoints, lobes: Lobes) -> ShadingPoints:
        """Points of hair, and light from behind, on the outside of what is round."""
        some, normal = self._behind.copy(), self.points.normal
        if self._hair:
            hair = np.concatenate([rows for rows, _ in self._hair])
            some[hair], normal = True, normal.copy()
            normal[hair] = lobes.normal[hair]
        rows = np.flatnonzero(some & is_round(self._scene, points.triangle))
        if not len(rows):
            return points
        behind = self._behind[rows]
        at = points.triangle[rows], points.position[rows]
        way = set_starts(lobes, rows, circles(self._scene.mesh, *at), behind)
        return beyond(points, rows, normal[rows], way, behind)

    def _set_hair(self, lobes: Lobes) -> None:
        points = self.points
        for rows, hair in self._hair:
            tube = is_round(self._scene, points.triangle[rows])
            on_tube = normals_of_strands(points.normal[rows], hair.tangent)
            own = np.where(tube[:, None], on_tube, points.geometric_normal[rows])
            lobes.normal[rows] = own
            front, behind = (
                np.where(tube, on_tube, on_mesh)
                for on_tube, on_mesh in ((ALL_ROUND, 1.0), (LAMPS_ALONE, -1.0))
            )
            set_hair(lobes, rows, hair, np.where(self._behind[rows], behind, front))

    def _set_shape(self, lobes: Lobes) -> None:
        """Make sheen and toon of the Lambert lobes that are to be."""
        fibers, velvet, matte, glossy = (self._shape == model for model in _FACTORS)
        roughness = self.params.roughness
        set_sheen(lobes, fibers, velvet, roughness)
        set_toon(lobes, matte, glossy, roughness, self.params.diffuse_roughness)

    def _lobes(self) -> Lobes:
        points, weight = self.points, self.weight
        params, brushed = self.params, self._grain.any()
        if brushed:
            params = params._replace(roughness=mean_roughness(params.roughness, self._grain))
        own = params, self.normal, points.geometric_normal, points.wo
        lobes = setup_lobes(*own, self._scene.measured, self._as_turned)
        for rows, film in self._films:
            set_film(lobes, params, rows, film)
        if self._maps_normals:  # below the surface: lit by what no light comes from, as in Cycles
            lobes.diffuse[dot(points.normal, lobes.normal) < 0.0] = 0.0
        if self._matte is not None:
            darken_matte(lobes, self._matte)
        if self._shape.any():
            self._set_shape(lobes)
        self._set_hair(lobes)
        if brushed:
            stretch_lobes(lobes, self.params.roughness, self._grain)
        if self._phong.any():
            set_ashikhmin_shirley(lobes, self._phong)
        if self._turned.any():
            bump = np.where(self._turned, turns(points.normal, lobes.normal), np.float32(0.0))
            lobes = lobes._replace(smooth=points.normal, bump=bump)
        if (weight == 1.0).all():
            return lobes
        filmed = (lobes.kind & THIN_FILM) != 0  # whose numbers stand there
        return lobes._replace(
            diffuse=lobes.diffuse * weight,
            glossy_color=lobes.glossy_color * weight,
            weight=lobes.weight * weight[:, None],
            tint=np.where(filmed[:, None], lobes.tint, lobes.tint * weight),
        )
