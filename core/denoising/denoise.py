"""The noise of a finished picture taken away, by Open Image Denoise.

The library is told what the surfaces are (Cycles' Denoising Data, out of layers that every picture
has), so that textures and edges stay. Where a pixel shows the world alone there is no noise, and
the picture stays as it is, to the last bit; so does alpha.
"""

from __future__ import annotations

import dataclasses
import math
import threading
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..film import NO_DEPTH
from ..scene import PERSPECTIVE, Camera, Scene
from ..settings import DenoiseSettings, RenderSettings
from .oidn import QUALITIES, Device, as_image

# How soon a denoiser that is not wanted any more is left to itself.
POLL_SECONDS = 0.01
# Pixels around the picture: the library knows less at an edge, and colors its last pixels.
_RIM = 8
# The layers of Denoising Data -> channels: made of a tile's others where they are asked for.
DATA_LAYERS = {"denoising_normal": 3, "denoising_albedo": 3, "denoising_depth": 1}
NOISY = "noisy"  # combined before the noise was taken away


class Denoising(NamedTuple):
    """What is to be done: settings; library: path of Open Image Denoise, problem: why there is
    none, where it is empty."""

    settings: DenoiseSettings
    library: str = ""
    problem: str = ""


class Guided(NamedTuple):
    """A picture, and what the denoiser is told of it; row 0 at the bottom.

    combined: float32 (h, w, 4); albedo, normal: float32 (h, w, 3), of the surfaces, in the world
    exact: bool (h, w), pixels that show the world alone, or a hole
    """

    combined: np.ndarray
    albedo: np.ndarray
    normal: np.ndarray
    exact: np.ndarray

    @classmethod
    def empty(cls, width: int, height: int) -> Guided:
        """A picture of which nothing is known."""
        size = height, width
        arrays = (np.zeros((*size, channels), np.float32) for channels in (4, 3, 3))
        return cls(*arrays, np.zeros(size, np.bool_))

    @classmethod
    def of_layers(cls, layers: dict[str, np.ndarray], scene: Scene) -> Guided:
        """Of the layers of a picture or a tile of the scene."""
        combined, normal = layers["combined"], layers["normal"]
        hole = combined[..., 3:] == 0.0
        exact = (combined[..., :3] == layers["environment"]).all(axis=2) & ~normal.any(axis=2)
        exact = hole[..., 0] if scene.transparent_film else exact | hole[..., 0]
        return cls(combined, albedo_of(layers, scene), np.where(hole, 0.0, normal), exact)

    def take(self, part: Guided, x: int, y: int) -> None:
        """Copy a tile's part into its place, x and y from the lower left corner."""
        height, width = part.exact.shape
        for whole, own in zip(self, part, strict=True):
            whole[y : y + height, x : x + width] = own


def albedo_of(layers: dict[str, np.ndarray], scene: Scene) -> np.ndarray:
    """What surfaces reflect of white light, and the light that is seen itself: (h, w, 3)."""
    light = layers["emission"]
    if not scene.transparent_film:
        light = light + layers["environment"]
    exposure = np.float32(scene.exposure)
    shown = np.divide(light, exposure, out=np.zeros_like(light), where=exposure > 0.0)
    shown += layers["diffuse_color"]
    shown += layers["glossy_color"]
    return np.where(layers["combined"][..., 3:] == 0.0, np.float32(0.0), shown)


def data_layers(layers: dict[str, np.ndarray], scene: Scene) -> dict[str, np.ndarray]:
    """DATA_LAYERS of a picture or a tile, float32 (h, w, channels): as Cycles has them.

    Normals are the camera's, z away from it.
    """
    guided, camera = Guided.of_layers(layers, scene), scene.camera
    axes = np.asarray(camera.camera_to_world, np.float32)[:3, :3] * np.float32([1.0, 1.0, -1.0])
    depth = np.where(layers["depth"] < NO_DEPTH, _ray_lengths(layers, camera), layers["depth"])
    depth[(layers["depth"] < NO_DEPTH) & (guided.combined[..., 3:] == 0.0)] = 0.0
    return {
        "denoising_normal": guided.normal @ axes,
        "denoising_albedo": guided.albedo,
        "denoising_depth": depth,
    }


def _ray_lengths(layers: dict[str, np.ndarray], camera: Camera) -> np.ndarray:
    """Metres from where the camera's view begins (clip_start) to what is hit, (h, w, 1)."""
    along = depth = layers["depth"]
    if camera.kind == PERSPECTIVE:
        away = layers["position"] - np.asarray(camera.camera_to_world, np.float32)[:3, 3]
        along = np.sqrt((away * away).sum(axis=2, keepdims=True))
    return along * (np.float32(1.0) - np.float32(camera.clip_start) / depth)


def exact_guides(scene: Scene, pixel_filter: str) -> bool:
    """Whether albedo and normal have no noise: one point a pixel, and nothing that draws lots."""
    programs = () if scene.shaders is None else scene.shaders.programs
    shown = [program for program in programs if program is not None]
    lots = any(p.transparent is not None or p.holdout is not None for p in shown)
    return pixel_filter == "CENTER" and not lots


def prepared(
    picture: Guided, wanted: DenoiseSettings, scene: Scene, settings: RenderSettings
) -> tuple[Guided, DenoiseSettings]:
    """A whole picture of the scene, sampled by settings, and how it is to be denoised.

    Without a prefilter where it could only blur what has no noise. Pixels beside a silhouette may
    have seen the world alone by chance: they are not exact, unless they are empty.
    """
    if exact_guides(scene, settings.pixel_filter):
        wanted = dataclasses.replace(wanted, denoise_prefilter="NONE")
    exact = picture.exact.copy()
    if scene.camera.lens or scene.camera.motion or scene.motion:
        exact[:] = False  # how far a silhouette is blurred is not known
    elif settings.pixel_filter != "CENTER":
        _shrink(exact, math.ceil(settings.filter_width))
    exact |= picture.combined[..., 3] == 0.0
    return picture._replace(exact=exact), wanted


def _shrink(mask: np.ndarray, pixels: int) -> None:
    """Take away what is so near to the edge of a mask, bool (h, w), in place."""
    for rows in (mask, mask.T):
        before = rows.copy()
        for k in range(1, min(pixels + 1, len(rows))):
            rows[k:] &= before[:-k]
            rows[:-k] &= before[k:]


def denoised(
    picture: Guided,
    settings: DenoiseSettings,
    device: Device,
    told: Callable[[float], bool] = lambda fraction: True,
) -> np.ndarray | None:
    """Combined without its noise, float32 (h, w, 4); None where ``told`` ended it.

    told(fraction): see Device.run. Raises MemoryError or RuntimeError.
    """
    images = {"color": _rimmed(picture.combined)}
    if settings.denoise_passes != "NONE":
        images["albedo"] = _rimmed(picture.albedo)
    if settings.denoise_passes == "ALBEDO_NORMAL":
        images["normal"] = _rimmed(picture.normal)
    guides = [name for name in images if name != "color"]
    prefilter = guides if settings.denoise_prefilter == "ACCURATE" else []
    quality, parts = QUALITIES[settings.denoise_quality], len(prefilter) + 1

    def told_of(part):
        return lambda fraction: told((part + fraction) / parts)

    for part, name in enumerate(prefilter):
        image = device.run({name: images[name]}, {"quality": quality}, told_of(part))
        if image is None:
            return None
        images[name] = image
    options = {"hdr": True, "quality": quality, "cleanAux": settings.denoise_prefilter != "FAST"}
    color = device.run(images, options, told_of(parts - 1))
    return None if color is None else _put_back(picture, color[_RIM:-_RIM, _RIM:-_RIM])


def _rimmed(layer: np.ndarray) -> np.ndarray:
    """A layer as the library takes it, mirrored at its edges."""
    return np.pad(as_image(layer), ((_RIM, _RIM), (_RIM, _RIM), (0, 0)), "symmetric")


def denoise_apart(
    picture: Guided, denoising: Denoising, threads: int, going: Callable[[float], bool]
) -> np.ndarray | None:
    """denoised() in a thread of its own; None where going(fraction), often asked, says no.

    Nobody waits for a picture that is not wanted any more: the library asks seldom (on two cores,
    once in a second of 1920 x 1080 pixels). Raises OSError where there is no library, MemoryError
    or RuntimeError.
    """
    if not denoising.library:
        raise OSError(denoising.problem)
    state = {"fraction": 0.0, "going": True}

    def told(fraction):
        state["fraction"] = fraction
        return state["going"]

    def run():
        try:
            with Device(denoising.library, threads) as device:
                state["result"] = denoised(picture, denoising.settings, device, told)
        except Exception as error:  # raised again in the caller's thread
            state["error"] = error

    # Not a daemon: an interpreter that ends would free what the library works on.
    thread = threading.Thread(target=run, name="iwis-denoise")
    thread.start()
    try:
        while thread.is_alive():
            if not going(state["fraction"]):
                return None
            thread.join(POLL_SECONDS)
    finally:
        state["going"] = False
    if "error" in state:
        raise state["error"]
    return state["result"]


def _put_back(picture: Guided, color: np.ndarray) -> np.ndarray:
    """The picture with other colors where they may have had noise."""
    out = picture.combined.copy()
    noisy = ~picture.exact
    out[noisy, :3] = color[noisy]
    return out
