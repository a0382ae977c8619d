"""Images and skies in a world's tree. A handler is as in program_nodes.py."""

from __future__ import annotations

import numpy as np

from ....core.data.program import Ref
from ....core.scene import (
    CLOSEST,
    EQUIRECTANGULAR,
    LINEAR,
    LINEAR_SRGB,
    MIRROR_BALL,
    EnvironmentMap,
)
from ..images.image import ImageError
from ..images.sky import SkyError
from ..images.smooth_texels import smooth_texels
from ..radiance import mend_radiance
from ..shaders.seen_tree import name_of
from .world_mapping import NotAMatrix, lookup_matrix, own_matrix

_MISSING = np.float32([1.0, 0.0, 1.0])  # Cycles' colour of an image that is not there
# Mean radiance over the sphere of the Sky Texture as Blender adds it, rendered with Cycles.
_SKY_MEAN = {
    "PREETHAM": (0.60, 0.68, 1.00),
    "HOSEK_WILKIE": (0.083, 0.155, 0.219),
    "NISHITA": (2.1, 2.1, 2.0),
    "SINGLE_SCATTERING": (2.1, 2.1, 2.0),
    "MULTIPLE_SCATTERING": (1.9, 2.5, 3.5),
}


def _sky(builder, node, groups):
    mean = _SKY_MEAN.get(node.sky_type, (1.0, 1.0, 1.0))
    try:
        sky = builder.cache.skies.read(node)
    except SkyError as error:
        builder.reader.warn(
            node,
            f"the sky cannot be rendered ({error}): one colour, {tuple(mean)}; for the sky itself, "
            "use Convert World to HDRI in the world's properties",
        )
        sky = None
    if sky is None:
        return {node.outputs[0].identifier: np.float32(mean)}
    if "Vector" in node.inputs:
        matrix, inputs = _lookup(builder, node, groups)
    else:  # Blender takes the socket away where there is a sun's disc
        matrix, inputs = own_matrix(node, builder.reader.warn), {}
    environment = EnvironmentMap(
        radiance=sky,
        world_to_map=np.ascontiguousarray(matrix, np.float32),
        name=name_of(node),
    )
    row = builder.texture(environment, inputs)
    return {node.outputs[0].identifier: Ref(row, "Color")}


def _image_texture(builder, node, groups):
    if not node.inputs["Vector"].is_linked and node.image is not None:
        text = "an Image Texture without a vector is one colour, as in Cycles: link Generated to it"
        builder.reader.warn(node, f"{text}, or use an Environment Texture")
    return builder.made_as_in_materials(node, groups)


def _environment_texture(builder, node, groups):
    image, warn = node.image, builder.reader.warn
    rgb, encoded = _texels(builder, node)
    if rgb.size == 3:
        return {socket.identifier: rgb[0, 0] for socket in node.outputs}
    slot = "mended", image.session_uid, node.image_user.frame_current
    rgb, notes = builder.cache.kept(slot, rgb, lambda: mend_radiance(rgb))
    for note in notes:
        warn(node, f'image "{image.name}": {note}')
    interpolation = LINEAR_SRGB if encoded else LINEAR
    if node.interpolation == "Closest":
        interpolation = CLOSEST
    elif node.interpolation != "Linear":  # Cubic, and Smart, which is the same
        slot, before = ("smooth", *slot[1:]), rgb
        rgb = builder.cache.kept(slot, before, lambda: smooth_texels(before, encoded))
    matrix, inputs = _lookup(builder, node, groups)
    environment = EnvironmentMap(
        radiance=rgb,
        world_to_map=np.ascontiguousarray(matrix, np.float32),
        projection=MIRROR_BALL if node.projection == "MIRROR_BALL" else EQUIRECTANGULAR,
        interpolation=interpolation,
        name=image.name,
    )
    return builder.texture(environment, inputs)


def _lookup(builder, node, groups):
    """(matrix, inputs) of an Environment Texture; no inputs where the matrix says all."""

    def constant(socket, groups):
        value = builder.behind(socket, groups, "VECTOR")
        if isinstance(value, Ref):
            raise NotAMatrix
        return value

    try:
        return lookup_matrix(node, groups, constant, builder.camera, builder.reader.warn), {}
    except NotAMatrix:
        vector = builder.behind(node.inputs["Vector"], groups, "VECTOR")
        return own_matrix(node, builder.reader.warn), {"Vector": vector}


def _texels(builder, node):
    """(rgb, srgb interpolation) of a texture node; one pink texel where it cannot be read."""
    image = node.image
    try:
        if image is not None and image.source == "TILED":
            told = "has UDIM tiles: only the first is used"
            builder.reader.warn(node, f'image "{image.name}" {told}')
        return builder.cache.read(image, node.image_user)
    except ImageError as error:
        builder.reader.warn(node, f"{error}. Pink instead, as in Cycles")
        return _MISSING.reshape(1, 1, 3), False


HANDLERS = {
    "ShaderNodeTexSky": _sky,
    "ShaderNodeTexImage": _image_texture,
    "ShaderNodeTexEnvironment": _environment_texture,
}
