"""The Image Texture node: projections, extension, interpolation, tiles."""

from __future__ import annotations

import numpy as np

from .values import as_number, clipped, parts

_MISSING = np.float32([1.0, 0.0, 1.0, 1.0])  # what Cycles shows for an image that is not there


def srgb_decode(encoded):
    """Linear of sRGB."""
    curve = ((np.maximum(encoded, 0.0) + 0.055) / 1.055) ** 2.4
    return np.where(encoded < 0.04045, np.maximum(encoded, 0.0) / 12.92, curve).astype(np.float32)


def _looked_up(image, u, v, interpolation, extension):
    """RGBA float32 (n, 4). image: float32 or uint8 (h, w, 4)"""
    from ..textures.texels import EXTENSIONS, INTERPOLATIONS, look_up  # kernels

    value = np.empty((len(u), 4), np.float32)
    scale = np.float32(1.0 / 255.0 if image.dtype == np.uint8 else 1.0)
    rule = INTERPOLATIONS[interpolation], EXTENSIONS[extension], scale
    u, v = (as_number(a, len(value)) for a in (u, v))
    look_up(np.ascontiguousarray(image), u, v, *rule, value)
    return value


def _sample(settings, u, v):
    """RGBA float32 (n, 4) of the image at (u, v), both (n,), as it is kept."""
    image = settings["image"]
    if image is None:
        return np.broadcast_to(_MISSING, (len(u), 4))
    rule = settings["interpolation"], settings["extension"]
    if len(image.tiles) == 1 and (0, 0) in image.tiles and not settings["tiled"]:
        return _looked_up(image.tiles[0, 0], u, v, *rule)
    value = np.tile(_MISSING, (len(u), 1))
    tile_x, tile_y = np.trunc(u).astype(np.int64), np.trunc(v).astype(np.int64)
    for (i, j), texels in image.tiles.items():
        here = (tile_x == i) & (tile_y == j)
        if here.any():
            value[here] = _looked_up(texels, u[here] - i, v[here] - j, *rule)
    return value


def _color(settings, value):
    """float32 (n, 3): the color of RGBA as it is kept."""
    color, image = value[:, :3], settings["image"]
    if image is None:
        return color
    if settings["unassociate"]:
        alpha = value[:, 3:]
        color = color / np.where((alpha != 0.0) & (alpha != 1.0), alpha, 1.0)
    return srgb_decode(color) if image.encoded else color


def _to_sphere(x, y, z):
    size = np.sqrt(x * x + y * y + z * z)
    safe = np.where(size > 0.0, size, 1.0)
    u = np.where((x == 0.0) & (y == 0.0), 0.0, 0.5 - np.arctan2(x, y) / np.float32(2.0 * np.pi))
    v = 1.0 - np.arccos(np.clip(z / safe, -1.0, 1.0)) / np.float32(np.pi)
    return np.where(size > 0.0, u, 0.0), np.where(size > 0.0, v, 0.0)


def _to_tube(x, y, z):
    size = np.sqrt(x * x + y * y)
    safe = np.where(size > 0.0, size, 1.0)
    u = 0.5 - np.arctan2(x / safe, y / safe) / np.float32(2.0 * np.pi)
    return np.where(size > 0.0, u, 0.0), np.where(size > 0.0, (z + 1.0) * 0.5, 0.0)


def _box_weights(normal, blend):
    """Weights of the projections along x, y and z, float32 (n, 3). normal: of the object"""
    a = np.abs(normal)
    a = a / np.maximum(a.sum(-1, keepdims=True), 1e-20)
    x, y, z = parts(a)
    limit = 0.5 * (1.0 + blend)
    weights = np.zeros_like(a)
    only = [
        (x > limit * (x + y)) & (x > limit * (x + z)),
        (y > limit * (x + y)) & (y > limit * (y + z)),
        (z > limit * (x + z)) & (z > limit * (y + z)),
    ]
    left = ~(only[0] | only[1] | only[2])
    for axis in range(3):
        weights[only[axis], axis] = 1.0
    if blend <= 0.0:
        weights[left, 0] = 1.0
        return weights
    pairs = (
        (z < (1.0 - limit) * (y + x), 0, 1),
        (x < (1.0 - limit) * (y + z), 1, 2),
        (y < (1.0 - limit) * (x + z), 0, 2),
    )
    for near, first, second in pairs:
        near = near & left
        share = a[near, first] / (a[near, first] + a[near, second])
        share = clipped((share - 0.5 * (1.0 - blend)) / blend)
        weights[near, first], weights[near, second] = share, 1.0 - share
        left = left & ~near
    weights[left] = ((2.0 - limit) * a[left] + (limit - 1.0)) / (2.0 * limit - 1.0)
    return weights


def _boxed(context, settings, co):
    normal = context.normal_to_object(context.normal)
    weights = _box_weights(normal, settings["projection_blend"])
    x, y, z = parts(np.broadcast_to(co, (len(context), 3)))
    places = (
        (np.where(normal[:, 0] < 0.0, 1.0 - y, y), z),
        (np.where(normal[:, 1] > 0.0, 1.0 - x, x), z),
        (np.where(normal[:, 2] > 0.0, 1.0 - y, y), x),
    )
    color, alpha = np.zeros((len(context), 3), np.float32), np.zeros(len(context), np.float32)
    for axis, (u, v) in enumerate(places):
        some = np.flatnonzero(weights[:, axis] > 0.0)
        if len(some):
            value, weight = _sample(settings, u[some], v[some]), weights[some, axis]
            color[some] += weight[:, None] * _color(settings, value)
            alpha[some] += weight * value[:, 3]
    return {"Color": color, "Alpha": alpha}


def image_texture(context, settings, inputs):
    """settings: image (program.ImageTiles or None), interpolation, extension, projection,
    projection_blend, tiled, unassociate."""
    n = len(context)
    co = inputs.get("Vector")
    co = context.uv() if co is None else co
    kind = settings["projection"]
    if kind == "BOX":
        return _boxed(context, settings, co)
    x, y, z = (np.broadcast_to(a, (n,)) for a in parts(co))
    if kind in ("SPHERE", "TUBE"):
        to_plane = _to_sphere if kind == "SPHERE" else _to_tube
        x, y = to_plane(x * 2.0 - 1.0, y * 2.0 - 1.0, z * 2.0 - 1.0)
    value = _sample(settings, x, y)
    return {"Color": lambda: _color(settings, value), "Alpha": value[:, 3]}


def _to_map(x, y, z):
    """Where an equirectangular map has a direction."""
    u = 0.5 - np.arctan2(y, x) / np.float32(2.0 * np.pi)
    v = np.arctan2(z, np.sqrt(x * x + y * y)) / np.float32(np.pi) + 0.5
    nowhere = (x == 0.0) & (y == 0.0) & (z == 0.0)
    return np.where(nowhere, 0.0, u), np.where(nowhere, 0.0, v)


def _to_mirror_ball(x, y, z):
    size = np.sqrt(x * x + y * y + z * z)
    x, y, z = (a / np.where(size > 0.0, size, 1.0) for a in (x, y, z))
    across = 2.0 * np.sqrt(np.maximum(-0.5 * (y - 1.0), 0.0))
    across = np.where(across > 0.0, across, 1.0)
    return 0.5 * (x / across + 1.0), 0.5 * (z / across + 1.0)


def environment_texture(context, settings, inputs):
    """An environment image on a surface, looked up by a direction: by default the place.

    settings: as image_texture's, but projection: EQUIRECTANGULAR or MIRROR_BALL
    """
    co = inputs.get("Vector")
    co = context.position if co is None else co
    place = (np.broadcast_to(a, (len(context),)) for a in parts(co))
    ball = settings["projection"] == "MIRROR_BALL"
    u, v = (_to_mirror_ball if ball else _to_map)(*place)
    return {"Color": _color(settings, _sample(settings, u, v))}


FUNCTIONS = {
    "ShaderNodeTexImage": image_texture,
    "ShaderNodeTexEnvironment": environment_texture,
}
