"""Shadow catchers and holdouts: surfaces of which the picture shows their shadow, or a hole.

A catcher shows the world behind it, times s: of the light that it reflects, the part that arrives
where the other objects stand (Cycles' Shadow Catcher pass), and more than 1 where these shine; the
picture takes the mean of s over its colours, up to 1, as Cycles' does. In a transparent film it is
black with the opacity 1 - s. What it is made of says only how light from different sides counts. A
holdout is black, with the opacity of what its ray has gone through, in any film; but beside a
catcher, in an opaque film, all is opaque, as in Cycles.

Passes of what a surface is made of have a catcher as any other; so has Environment, in an opaque
film, the world that it shows. Where the pass Shadow Catcher is asked for, that alone has the
shadow, and the picture a hole, in any film: to be laid over a photograph times the pass.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.channels import LUMINANCE
from ..geometry.shading import ShadingPoints
from ..sampling.incremental import PixelSums
from ..scene import HOLDOUT, SHADOW_CATCHER, Scene
from ..see_through.cutouts import hole_shares, in_holes, opacity_of
from ..surfaces.backdrop import Backdrop
from .pass_sums import PassSums, add_background, add_seen, new_pass_sums

_ALL = np.float32(0.9999)
_DIRECT = {"diffuse_color": "diffuse_direct", "glossy_color": "glossy_direct"}


def has_role(scene: Scene, role: int) -> bool:
    """Whether any object is a HOLDOUT, or a SHADOW_CATCHER."""
    return scene.object_flags is not None and bool((scene.object_flags & role).any())


def plays(scene: Scene, points: ShadingPoints, role: int) -> np.ndarray:
    """bool (n,): the points on objects of a role; of a HOLDOUT, or of a material that is one. What
    is a HOLDOUT too is no SHADOW_CATCHER to the camera, as in Cycles."""
    found = np.zeros(len(points.pixel), np.bool_)
    if has_role(scene, role):
        flags = scene.object_flags[scene.mesh.object_index[points.triangle]]
        found = (flags & role) != 0
        if role == SHADOW_CATCHER:
            found &= (flags & HOLDOUT) == 0
    return found | in_holes(scene, points) if role == HOLDOUT else found


def are_whole_holes(scene: Scene, points: ShadingPoints) -> np.ndarray:
    """bool (n,): the points on HOLDOUT objects and on what a Holdout shader alone stops."""
    found = hole_shares(scene, points) > _ALL
    if has_role(scene, HOLDOUT):
        found |= (scene.object_flags[scene.mesh.object_index[points.triangle]] & HOLDOUT) != 0
    return found


def arriving(seen: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """s: float64, of light with and without the other objects, (n, 3); 1 of none."""
    return np.divide(seen, whole, out=np.ones(seen.shape), where=whole > 0.0)


def _gray(share: np.ndarray) -> np.ndarray:
    """float64 (n,), 0 to 1: what of the world behind a catcher is seen."""
    return np.minimum(share.mean(axis=1), 1.0)


class CaughtPasses:
    """What the passes of n pixels saw of catchers."""

    def __init__(self, n: int):
        self._sums = new_pass_sums(n)

    def add(
        self, scene: Scene, world: Backdrop, seen, normal, sums: PixelSums, state: PassSums
    ) -> None:
        """Add passes.

        seen, sums: of points on catchers; normal: float32 (n, 3), for the pass of that name
        state: learns how noisy the pixels are
        """
        points = seen.points
        behind = world.radiance(-points.wo) * points.through
        behind *= np.float32(scene.environment.visible_to_camera)
        add_seen(points.pixel, normal, seen.lobes, sums, self._sums)
        add_background(points.pixel, behind, False, self._sums)
        np.add.at(self._sums.opaque, points.pixel, opacity_of(points.through))
        if scene.transparent_film:
            behind = np.ones_like(behind)
        share = arriving(sums.diffuse + sums.glossy, sums.unoccluded)
        light = _gray(share) * (behind @ LUMINANCE)
        own = (light, light**2, sums.count, sums.visible)
        for name, value in zip(("light", "light_squared", "count", "visible"), own, strict=True):
            np.add.at(getattr(state, name), points.pixel, value)

    def show(self, scene: Scene, rows: np.ndarray, passes: np.ndarray, layers: dict) -> None:
        """Add to developed layers. rows: of the pixels that the layers show; passes: theirs."""
        hits, sums = self._sums.hits[rows, None], self._sums
        share = arriving((sums.diffuse + sums.glossy)[rows], sums.unoccluded[rows])
        passes = np.maximum(passes, 1)[:, None]
        behind = sums.environment[rows] / passes * scene.exposure
        opaque = sums.opaque[rows] / passes[:, 0]
        _write(scene, layers, slice(None), share, behind, hits / passes, opaque)
        for name in ("normal", "diffuse_color", "glossy_color"):
            _add_to_layer(layers, name, getattr(sums, name)[rows] / passes)
        if not (scene.transparent_film or scene.asked.catcher):
            layers["combined"][..., 3] = 1.0


def _add_to_layer(layers, name, own) -> None:
    """Add to a layer of what surfaces are made of; direct light is that over the color's sum."""
    flat = layers[name].reshape(-1, 3)
    direct = _DIRECT.get(name)
    if direct is not None:
        part = np.divide(flat, flat + own, out=np.zeros_like(flat), where=flat > 0.0)
        layers[direct].reshape(-1, 3)[:] *= part
    flat += own


class Roles(NamedTuple):
    """Of points whose pixels are shown: int (k,), those on catchers, and those on holdouts."""

    caught: np.ndarray
    hidden: np.ndarray

    @property
    def any(self) -> bool:
        return bool(len(self.caught) or len(self.hidden))


def hide_roles(roles: Roles, points: ShadingPoints, place, layers: dict) -> None:
    """Take out what a picture of one point a pixel shows of catchers and holdouts.

    place: int (n,), pixels of the layers, -1 = outside
    """
    if not roles.any:
        return
    for name in ("normal", "diffuse_color", "glossy_color"):
        layers[name].reshape(-1, 3)[place[roles.hidden]] = 0.0
    for rows in roles:
        for name in ("combined", "diffuse_direct", "glossy_direct", "emission"):
            flat = layers[name].reshape(-1, layers[name].shape[2])
            flat[place[rows]] = 0.0
    combined = layers["combined"].reshape(-1, 4)
    combined[place[roles.hidden], 3] = _panes(points)[roles.hidden]


def _panes(points: ShadingPoints) -> np.ndarray:
    """float32 (n,): what panes before them have taken of the light."""
    return np.maximum(opacity_of(points.through), 0.0)


def show_caught(
    scene: Scene,
    world: Backdrop,
    roles: Roles,
    points: ShadingPoints,
    place,
    sums: PixelSums,
    layers: dict,
) -> None:
    """Show catchers in layers where they are hidden, and what else they change.

    place: as of hide_roles; sums: of the points
    """
    if not roles.any:
        return
    caught, panes = roles.caught, _panes(points)
    share = arriving((sums.diffuse + sums.glossy)[caught], sums.unoccluded[caught])
    behind = world.radiance(-points.wo[caught]) * points.through[caught] * scene.exposure
    behind = behind * np.float32(scene.environment.visible_to_camera)
    _write(scene, layers, place[caught], share, behind, np.ones((len(caught), 1)), panes[caught])
    opaque = not (scene.transparent_film or scene.asked.catcher)
    if opaque and has_role(scene, SHADOW_CATCHER):
        for rows in roles:
            layers["combined"].reshape(-1, 4)[place[rows], 3] = 1.0


def _write(scene, layers, where, share, behind, part, opaque) -> None:
    """Add a share of what is behind and opacity, of a part of pixels; write the layer there.

    opaque: of the pixels, what panes before the catchers have taken of the light
    """
    layers["shadow_catcher"].reshape(-1, 3)[where] = share
    if not scene.transparent_film:
        layers["environment"].reshape(-1, 3)[where] += behind
    if scene.asked.catcher:
        return
    combined = layers["combined"].reshape(-1, 4)
    gray = _gray(share)
    if scene.transparent_film:
        combined[where, 3] += part[:, 0] * (1.0 - gray) + opaque * gray
    else:
        combined[where, :3] += behind * gray[:, None]
        combined[where, 3] += part[:, 0]
