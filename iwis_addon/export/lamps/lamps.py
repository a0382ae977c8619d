"""Blender's lights to core.data.lamps.Lamps, in Cycles' units.

Strength is colour (times that of the temperature) x energy x 2^exposure x what the light's own
nodes say. Normalised, it is watts for all but the sun, and of a lamp's area nothing is left but
softness: radiance = W / (pi area), of a point W / 4 pi in W/sr; not normalised, it is pi times the
radiance. A sun's strength is its irradiance, or its radiance. Rendered and compared: docs/parity.md
"""

from __future__ import annotations

import math

import numpy as np

from ....core.data.lamps import (
    BEAM,
    BY_CAMERA,
    BY_DIFFUSE,
    BY_GLOSSY,
    DISC,
    ELLIPSE,
    NOT_BY_BSDF,
    RECTANGLE,
    ROUND_BEAM,
    SPHERE,
    SUN,
)
from ....core.nodes.falloff import INFINITELY_FAR, asks_for_distance
from ....core.nodes.typical import mean_value
from ..objects.object_properties import Asked
from ..shaders.seen_tree import seen_tree
from ..shaders.surface_parts import is_constant
from .lamp_nodes import LampLight, LampReader, read_light
from .lamp_pictures import asks_for_place, color_of, ops_of, places_of

_ONE_WAY = "its nodes vary with the direction, which a sun or a beam has one of: mean"
_STEEPEST = 1e30  # of a spot's edge: float32 has no infinity that times zero is zero
_SQUARE = 1e-4  # cosine of axes that are taken to be at right angles: matrices are float32


def read_lamp(asked: Asked, matrix_world, warnings: list[str], images, layer) -> dict | None:
    """A row for core.lamps.make_lamps of an evaluated light object; None: it gives no light.

    Where the light's nodes vary over it, the row has them for with_pictures.
    asked: the object, and what made an instance of it; matrix_world: of the instance
    warnings: get what is not as in Cycles, by object and light
    images: the ImageStore of what its nodes show; layer: the evaluated view layer, scene and world
    """
    obj = asked.own
    light, matrix = obj.data, np.array(matrix_world, np.float64)
    if light.type == "AREA" and _cycles(light, "is_portal", False):
        return None  # a portal shows Cycles where the world is
    nodes, varying = LampReader(obj.name, light.name, warnings), None
    strength = np.array(light.color, np.float64) * light.energy * 2.0**light.exposure
    if light.use_temperature:
        strength *= np.array(light.temperature_color)
    seen = seen_tree(light)
    if seen is not None:
        own = read_light(seen.tree, nodes, images, asked, layer)
        if own is None:
            return None
        if is_constant(own.value):
            strength *= own.value
        else:
            varying = own
    if not (np.isfinite(strength).all() and np.isfinite(matrix).all()):
        nodes.warn(None, "its strength or transform is not finite: it is left out")
        return None
    if (strength < 0.0).any():
        nodes.warn(None, "negative light is not supported: it is left out")
        return None
    row = _ROWS[light.type](light, matrix, strength)
    if row is None or not strength.any():
        return None
    if varying is not None:
        row |= _varying(light, row, matrix, varying, nodes)
    seen_by = BY_DIFFUSE * obj.visible_diffuse | BY_GLOSSY * obj.visible_glossy
    seen_by |= BY_CAMERA * obj.visible_camera
    seen_by |= NOT_BY_BSDF * (not _cycles(light, "use_multiple_importance_sampling", True))
    frame = {"position": matrix[:3, 3], "seen_by": seen_by, "shadow": light.use_shadow}
    return _sides(light, matrix) | frame | row


def _sides(light, matrix) -> dict:
    """forward, right, up and axis of Lamps; those of an area at right angles, whatever the matrix.

    As Cycles: a rectangle stays in its plane, and is seen from where its axis points; an ellipse
    lies across the axis
    """
    right, up, back = (_unit(matrix[:3, k]) for k in range(3))
    sides = {"forward": -back, "right": right, "up": up, "axis": -back}
    if light.type != "AREA" or max(abs(right @ up), abs(right @ back), abs(up @ back)) < _SQUARE:
        return sides
    across = np.cross(right, up)
    angular = light.shape in ("SQUARE", "RECTANGLE") and light.spread > 0.0
    if angular and abs(across @ back) > _SQUARE:
        sides["forward"] = -_unit(across) * np.sign(across @ back)
    # The two directions at right angles nearest to both.
    flat = np.stack([right, up], axis=1)
    flat -= np.outer(sides["forward"], sides["forward"] @ flat)
    turn, _, other = np.linalg.svd(flat, full_matrices=False)
    sides["right"], sides["up"] = (turn @ other).T
    return sides


def _varying(light, row, matrix, own: LampLight, nodes) -> dict:
    """What a row has of a light whose nodes vary over it."""
    places = places_of(light, row["kind"], matrix, own)
    on_ball = places.by_direction and row["kind"] == SPHERE and row["size"][0] > 0.0
    if light.type == "SPOT" and on_ball and any(map(asks_for_place, ops_of(own))):
        told = "its UV map is by direction: other coordinates are those of its middle"
        nodes.warn(None, told)
    varying = {"light": own, "places": places, "named": (nodes.object_name, light.name)}
    if row["kind"] not in (SUN, BEAM, ROUND_BEAM):
        return varying
    color = color_of(own, places, INFINITELY_FAR if row["kind"] == SUN else 1.0)
    if color is None:
        nodes.warn(None, _ONE_WAY)
        color = mean_value(own.program, own.value)
    elif row["kind"] != SUN and asks_for_distance(ops_of(own)):
        return varying
    return {"radiance": row["radiance"] * color}


def _cycles(light, name, otherwise):
    """A setting of Cycles' own, there as long as its add-on is enabled."""
    return getattr(light.cycles, name, otherwise) if hasattr(light, "cycles") else otherwise


def _unit(vector):
    length = np.linalg.norm(vector)
    return vector / length if length > 0.0 else vector


def _point(light, _matrix, strength):
    radius = light.shadow_soft_size
    area = 4.0 * math.pi * radius**2 if radius > 0.0 else 4.0
    return {
        "kind": DISC if light.use_soft_falloff else SPHERE,
        "size": (radius, 0.0),
        "radiance": strength / (math.pi * (area if light.normalize else 1.0)),
    }


def _spot(light, matrix, strength):
    edge = math.cos(0.5 * light.spot_size)
    soft = (1.0 - edge) * light.spot_blend
    return _point(light, matrix, strength) | {
        "to_cone": np.linalg.pinv(matrix[:3, :3]),
        "cone": (edge, min(1.0 / soft, _STEEPEST) if soft > 0.0 else _STEEPEST),
    }


def _sun(light, matrix, strength):
    half = 0.5 * light.angle
    area = math.pi * math.sin(half) ** 2 if half > 0.0 else 1.0
    if not matrix[:3, 2].any():
        return None
    radiance = strength / area if light.normalize else strength
    return {"kind": SUN, "size": (half, 0.0), "radiance": radiance}


def _area(light, matrix, strength):
    is_round = light.shape in ("DISK", "ELLIPSE")
    height = light.size if light.shape in ("SQUARE", "DISK") else light.size_y
    size = np.linalg.norm(matrix[:3, 0]) * light.size, np.linalg.norm(matrix[:3, 1]) * height
    if size[0] * size[1] == 0.0 or not matrix[:3, 2].any():
        return None
    area = size[0] * size[1] * (0.25 * math.pi if is_round else 1.0)
    radiance = strength / (math.pi * (area if light.normalize else 1.0))
    if light.spread <= 0.0:
        beam = {"kind": ROUND_BEAM if is_round else BEAM, "radiance": math.pi * radiance}
        return {"size": size} | beam
    kind = ELLIPSE if is_round else RECTANGLE
    return {"kind": kind, "size": size, "radiance": radiance, "spread": _spread(light.spread)}


def _spread(angle):
    """Lamps.spread, of which the whole light stays the same."""
    half = 0.5 * angle
    if angle >= math.pi * (1.0 - 1e-6):
        return math.inf, 1.0
    # Below, a difference of the third order has no digits left.
    return math.tan(half), 1.0 / (math.tan(half) - half) if half > 0.05 else 3.0 / half**3


_ROWS = {"POINT": _point, "SPOT": _spot, "SUN": _sun, "AREA": _area}
