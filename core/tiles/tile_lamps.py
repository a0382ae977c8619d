"""The light of lamps in a tile: beside the light of the world, by samples of its own.

It is kept apart from the sums of the world's samples: what those know of visibility (I_s, the
passes Unoccluded and Visibility) is about the HDRI.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit import kernel
from ..data.channels import LUMINANCE
from ..data.lamps import MESH, Lamps, is_soft
from ..embree.accel import Accel
from ..lamplight.lamp_light import LampSamples, add_lamp_light
from ..lamplight.lamp_rays import COLUMNS, UNOCCLUDED
from ..passes.pass_sums import PassSums
from ..sampling.incremental import PixelSums
from ..scene import Scene
from ..settings import RenderSettings
from ..surfaces.seen_points import ClosureLayer, SeenPoints

# Shadow rays to lamps with a size that one shading point takes in a pass, while they are few: to
# all, and to one. A mesh is many lamps, of which each sample takes another.
_RAYS_OF_A_PASS, _MOST_OF_A_PASS, _MOST_OF_A_MESH = 8, 4, 8
# Samples of each such lamp where a pixel has one shading point: so many, and so many in all where
# the standard error of the mean is a greater part of it than this. Of a mesh more.
_FIRST, _MOST, _SURE = 16, 64, 0.05
_TIMES_OF_A_MESH = 4


class _Layers(NamedTuple):
    """Layers of film.LAYERS, float32 (pixels, channels)."""

    combined: np.ndarray
    diffuse_direct: np.ndarray
    diffuse_color: np.ndarray
    glossy_direct: np.ndarray
    glossy_color: np.ndarray


class _Group(NamedTuple):
    """Lamps that are about the same objects. link: row of Scene.lamp_links, -1 = about all."""

    lamps: Lamps
    link: int


class _Lit(NamedTuple):
    """Points that some lamps light. blocking: the Accel of what throws shadows of these lamps;
    of: int64 (n,), the points' rows in the first layer"""

    lamps: Lamps
    blocking: Accel
    seen: SeenPoints
    of: np.ndarray


def _few(lamps: int) -> int:
    """Of _RAYS_OF_A_PASS, a power of two for each of so many lamps, one at the least."""
    return 1 << (max(_RAYS_OF_A_PASS // max(int(lamps), 1), 1).bit_length() - 1)


def _groups(lamps: Lamps) -> list[_Group]:
    links = np.unique(lamps.link)
    return [_Group(lamps.at(lamps.link == link), int(link)) for link in links]


class _Soft(NamedTuple):
    """Lamps with a size, of which a round takes a sample each, and meshes, of which several."""

    others: list
    meshes: list


class TileLamps:
    """What lamps bring to n pixels of one tile (none: costs nothing); 60 bytes a pixel.

    traced: shadow rays so far
    """

    def __init__(self, scene: Scene, settings: RenderSettings, accel: Accel, n: int):
        soft = is_soft(scene.lamps)
        self._any, self._accel, self._settings = len(soft) > 0, accel, settings
        self._links, self._object_of = scene.lamp_links, scene.mesh.object_index
        self._groups = scene.asked.groups.layers
        self._columns = COLUMNS + 3 * len(self._groups)
        self._take(scene.lamps)
        self._light = np.zeros((n if self._any else 0, self._columns))
        self._count = np.zeros(len(self._light), np.int32)
        # Powers of two: blocks of the sequence that fill a lamp evenly.
        count, meshes = soft.sum(), (scene.lamps.kind == MESH).sum()
        most = _MOST_OF_A_MESH if meshes == count else _MOST_OF_A_PASS
        self._of_a_pass = min(_few(count), _MOST_OF_A_PASS), min(_few(meshes), most)
        self.traced = 0

    def look_at(self, accel: Accel, lamps: Lamps) -> None:
        """Trace shadow rays there, to these lamps, from now on."""
        self._accel = accel
        if lamps is not self._lamps:
            self._take(lamps)

    def _take(self, lamps: Lamps) -> None:
        self._lamps = lamps
        if self._any:
            soft, mesh = is_soft(lamps), lamps.kind == MESH
            kinds = soft & ~mesh, mesh, ~soft
            others, meshes, self._hard = (_groups(lamps.at(own)) for own in kinds)
            self._soft = _Soft(others, meshes)

    def add_pass(self, layers: list[ClosureLayer], places, number, sums) -> None:
        """Add points of passes to their pixels, and their light to what the stop rule sees of it.

        layers: of the points; places: column and row in the frame of each; number: int64 (n,), of
        each its pass; sums: PixelSums of the points, whose ``seen`` and ``seen_squared`` are of the
        world before
        """
        if not self._any:
            return
        pixel = layers[0].seen.points.pixel
        light = np.zeros((len(pixel), self._columns))
        soft = self._soft_lit(layers, self._soft, self._accel)
        self._add_soft(soft, places, number, self._of_a_pass, light)
        self._add(self._lit(layers, self._hard, self._accel), places, number, light)
        own = (n for n, lit in zip(self._of_a_pass, soft, strict=True) if lit)
        count = min(own, default=self._of_a_pass[0])
        _add_to_pixels(pixel, light, count, self._light, self._count)
        _show(light, sums)

    def known(self, sums: PassSums) -> PassSums:
        """The sums as the stop rule is to see them, lamps and all; their other arrays are the same.

        Else nobody would go on looking for the light in a pixel that has not seen its lamp yet.
        """
        if not self._any:
            return sums
        whole = self._light[:, UNOCCLUDED, None].astype(np.float32)
        return sums._replace(count=sums.count + self._count, unoccluded=sums.unoccluded + whole)

    def settle(self, layers: list[ClosureLayer], places) -> None:
        """Have the light of points, once and for all; row k of the tile is point k."""
        if not self._any:
            return
        most = min(max(self._settings.max_samples, 1), _MOST)
        light = self._settled(layers, places, 0, min(_FIRST, most))
        mean, squared = light[:, :-1], light[:, -1]
        count = np.full(len(light), min(_FIRST, most))
        if most > _FIRST:
            total = _squared(mean)
            spread = np.maximum(squared * _FIRST - total, 0.0) / (_FIRST - 1)
            hidden = (total == 0.0) & (mean[:, UNOCCLUDED] > 0.0)
            unsure = np.flatnonzero(hidden | (spread > _SURE**2 * total))
            some, where = [layer.at(unsure) for layer in layers], [p[unsure] for p in places]
            mean[unsure] += self._settled(some, where, _FIRST, most)[:, :-1]
            count[unsure] = most
        self._light[:] = mean / count[:, None]
        self._add(self._lit(layers, self._hard, self._accel), places, 0, self._light)

    def _settled(self, layers, places, first, end) -> np.ndarray:
        """float64 (n, columns + 1): sums of samples first ... end - 1, last their _squared."""
        sums = np.zeros((len(places[0]), self._columns + 1))
        soft = self._soft_lit(layers, self._soft, self._accel)
        for k in range(first, end):
            light = np.zeros((len(sums), self._columns))
            self._add_soft(soft, places, k, (1, _TIMES_OF_A_MESH), light)
            sums[:, :-1] += light
            sums[:, -1] += _squared(light)
        return sums

    def _lit(self, layers: list[ClosureLayer], groups: list[_Group], accel) -> list[_Lit]:
        """What the lamps of each group light, and what throws shadows of them."""
        found = []
        for lamps, link in groups:
            receivers, blockers = (None, None) if link < 0 else self._links[link]
            blocking = accel if blockers is None else accel.linked(link)
            for layer in layers:
                seen, of = layer.seen, layer.of
                if receivers is not None:
                    which = receivers[self._object_of[seen.points.triangle]]
                    seen, of = seen.at(which), of[which]
                found.append(_Lit(lamps, blocking, seen, of))
        return found

    def _soft_lit(self, layers, soft: _Soft, accel) -> _Soft:
        return _Soft(*(self._lit(layers, groups, accel) for groups in soft))

    def _add_soft(self, soft: _Soft, places, number, counts, light) -> None:
        """Add the means of samples. counts: of a lamp with a size, and of a mesh"""
        for every, count in zip(soft, counts, strict=True):
            if every:
                own = np.zeros_like(light)
                self._add(every, places, number, own, count)
                light += own / count

    def _add(self, every: list[_Lit], places, number, light, count: int = 1) -> None:
        apart = 0 if self._settings.decorrelation == "NONE" else 1
        for lamps, blocking, seen, of in every:
            columns, rows = (apart * place[of].astype(np.int64) for place in places)
            own = np.broadcast_to(number, len(places[0]))[of].astype(np.int64)
            samples = LampSamples(columns, rows, own, self._settings.seed, count)
            part = np.zeros((len(of), light.shape[1]))
            given = seen.points, seen.lobes, lamps, blocking, samples, part
            self.traced += add_lamp_light(*given)
            light[of] += part

    def caught(self, layers, places, number, accel: Accel, sums: PixelSums) -> PixelSums:
        """The sums of points of passes on shadow catchers, with the lamps' light in all of them.

        accel: what throws shadows on catchers. The rest as for add_pass
        """
        return self._caught(layers, places, number, self._of_a_pass, accel, sums)

    def caught_at_once(self, layers, places, sums: PixelSums) -> PixelSums:
        """The same, once and for all, of pixels with one shading point."""
        most = min(max(self._settings.max_samples, 1), _MOST)
        return self._caught(layers, places, 0, (most, most), self._accel, sums)

    def _caught(self, layers, places, number, counts, accel, sums) -> PixelSums:
        if not self._any or not len(sums.count):
            return sums
        found = []
        for others in (True, False):  # with the same numbers: a share of 1 has no noise
            light = np.zeros((len(sums.count), COLUMNS))
            alone = _Soft(*(_alone(own, others) for own in self._soft))
            soft = self._soft_lit(layers, alone, accel)
            hard = self._lit(layers, _alone(self._hard, others), accel)
            self._add_soft(soft, places, number, counts, light)
            self._add(hard, places, number, light)
            found.append(light[:, :UNOCCLUDED] * np.maximum(sums.count, 1)[:, None])
        lit, whole = found
        return sums._replace(
            diffuse=sums.diffuse + lit[:, :3],
            glossy=sums.glossy + lit[:, 3:],
            unoccluded=sums.unoccluded + whole[:, :3] + whole[:, 3:],
        )

    def add_to_layers(self, layers, rows, place, weight) -> None:
        """Add the light to a tile's developed layers, in which colours and groups stand already.

        rows: of the light; place: pixels of the layers, -1 = outside; weight: float64, of each
        """
        if not self._any:
            return
        flat = {name: layers[name].reshape(-1, layers[name].shape[2]) for name in _Layers._fields}
        light = self._light[rows] * np.reshape(weight, (-1, 1))
        _add_to_flat(place, light, _Layers(*(flat[name] for name in _Layers._fields)))
        for k, name in enumerate(self._groups):
            first = COLUMNS + 3 * k
            layers[name].reshape(-1, 3)[place[place >= 0]] += light[place >= 0, first : first + 3]


@kernel
def _add_to_flat(place, light, layers):
    for k in range(len(place)):
        p = place[k]
        if p < 0:
            continue
        for a in range(3):
            diffuse, glossy = light[k, a], light[k, 3 + a]
            layers.combined[p, a] += diffuse + glossy
            if layers.diffuse_color[p, a] > 0.0:
                layers.diffuse_direct[p, a] += diffuse / np.float64(layers.diffuse_color[p, a])
            if layers.glossy_color[p, a] > 0.0:
                layers.glossy_direct[p, a] += glossy / np.float64(layers.glossy_color[p, a])


@kernel
def _add_to_pixels(pixel, light, count, out, counts):
    for k in range(len(pixel)):
        counts[pixel[k]] += count
        for c in range(light.shape[1]):
            out[pixel[k], c] += light[k, c]


def _alone(groups: list[_Group], others: bool) -> list[_Group]:
    """The lamps with or without the other objects: without them meshes do not shine either."""
    if others:
        return groups
    kept = [(lamps.at(lamps.kind != MESH), link) for lamps, link in groups]
    return [_Group(own._replace(shadow=np.zeros_like(own.shadow)), link) for own, link in kept]


def _squared(light) -> np.ndarray:
    """Sum of the squares of the three channels: luminance alone would not see specks of colour."""
    return ((light[:, :3] + light[:, 3:6]) ** 2).sum(axis=1)


def _luminance(light) -> np.ndarray:
    return (light[:, :3] + light[:, 3:6]) @ LUMINANCE


def _show(light, sums: PixelSums) -> None:
    """Add light to the mean that sums have of their samples, and leave their spread as it is."""
    count = np.maximum(sums.count, 1)
    before = sums.seen.copy()
    sums.seen[:] += _luminance(light) * count
    sums.seen_squared[:] += (sums.seen**2 - before**2) / count
