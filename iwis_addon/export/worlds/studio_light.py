"""A view's studio HDRI to maps, as Cycles' window has it: of its light, and of what is seen of it.

Before the camera it is mixed with the color of the world that it stands for, nodes or not. It is
turned about z as a Mapping node of type Vector turns it; it does not turn with the view.
"""

from __future__ import annotations

import math

import bpy
import numpy as np

from ....core.scene import LINEAR, LINEAR_SRGB, EnvironmentMap
from ..images.color_spaces import working_space
from ..images.image import ImageError, Texels, texels_of
from ..images.image_files import file_state
from ..images.texel_cache import TexelCache
from ..images.texture_size import TextureSize, smaller_texels
from ..radiance import mend_radiance
from ..view_shading import StudioLight
from .world import WorldExport, is_visible_to_camera, world_of

_PINK = np.float32([[[1.0, 0.0, 1.0]]])  # Cycles' color of images that are missing
_BLACK = np.zeros(3, np.float32)


def read_studio_light(
    depsgraph, light: StudioLight, warnings: list[str], cache: TexelCache
) -> WorldExport:
    """What stands for the world of the graph's view layer. A file that cannot be read is pink, and
    warned of. cache: as for read_world"""
    name = bpy.path.basename(light.path) or "none"
    source = light.path, file_state(light.path), working_space(), cache.size
    texels, problem = cache.kept("studio", source, lambda: _read(light.path, cache.size))
    radiance, notes = cache.kept(
        ("mended", "studio"), texels.rgb, lambda: mend_radiance(texels.rgb)
    )
    if problem:
        notes = [f"{problem}: pink; choose another one in the view's shading menu, Lighting"]
    warnings += [f"Studio light {name!r}: {note}" for note in notes]
    world = world_of(depsgraph)
    strength = np.full(3, light.strength, np.float32)
    own = {
        "world_to_map": _turned(light.rotation),
        "interpolation": LINEAR_SRGB if texels.srgb_interpolation else LINEAR,
        "visible_to_camera": world is None or is_visible_to_camera(world),
        "name": name,
    }
    export = WorldExport(EnvironmentMap(radiance=radiance, strength=strength, **own))
    if light.opacity >= 1.0:
        return export
    color = _BLACK if world is None else np.array(world.color, np.float32)
    mixed = cache.kept(
        "studio backdrop",
        (radiance, strength, light.opacity, color),
        lambda: color + np.float32(light.opacity) * (radiance * strength - color),
    )
    return export._replace(backdrop=EnvironmentMap(radiance=mixed, **own))


def _turned(angle: float) -> np.ndarray:
    """EnvironmentMap.world_to_map."""
    c, s = math.cos(angle), math.sin(angle)
    return np.float32([[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])


def _read(path: str, size: TextureSize) -> tuple[Texels, str]:
    """The file's texels, and what is wrong with it."""
    # Not among the user's images: they are saved, and a new one would begin the view anew.
    with bpy.data.temp_data() as data:
        try:
            image = data.images.load(path)
            texels = texels_of(image)
        except (ImageError, RuntimeError):
            there = "cannot be read" if file_state(path) else "has no file"
            return Texels(_PINK, False), there
        plain = texels.srgb_interpolation or image.colorspace_settings.is_data
        return smaller_texels(texels, size, plain and not image.is_float), ""
