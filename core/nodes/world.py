"""What a node may ask of a direction in which nothing is: the shading points of a world.

As Cycles has it, a world's point is its direction d from the origin; its normal is -d, towards the
viewer; it has no UV map, no object and no attributes.
"""

from __future__ import annotations

import numpy as np

from .context import ShadeContext
from .values import as_vector, length, normalized

ENVIRONMENT = "world_environment"
# What the operations of worlds ask of the direction; all others but textures know their inputs.
DIRECTION = "world_direction"


class WorldContext(ShadeContext):
    """n directions. directions: float32 (n, 3), unit, C-contiguous"""

    def __init__(self, directions: np.ndarray):
        self.position = directions

    def __len__(self):
        return len(self.position)

    @property
    def normal(self):
        """float32 (n, 3): also the geometric one, and the way to the viewer."""
        return -self.position

    wo = geometric_normal = normal

    @property
    def generated(self):
        return self.position

    @property
    def backfacing(self):
        """float32 (n,): a world has no back."""
        return np.zeros(len(self), np.float32)

    def attribute(self, name):
        """A world has none."""
        return None

    def normal_to_object(self, vectors):
        """Without an object its space is the world's."""
        return vectors

    normal_to_world = vector_to_world = vector_to_object = normal_to_object


def direction(context, settings, inputs):
    """The direction, and the normal that looks back along it."""
    return {"": context.position, "Normal": -context.position}


def transform(context, settings, inputs):
    """A vector through a matrix. settings: matrix float32 (3, 4)"""
    matrix = settings["matrix"]
    moved = inputs["Vector"] @ matrix[:, :3].T + matrix[:, 3]
    return {"": moved.astype(np.float32)}


def camera_data(context, settings, inputs):
    """Of a place in camera space, as Cycles takes a direction."""
    place = inputs["Vector"]
    return {
        "View Vector": normalized(place),
        "View Z Depth": np.abs(place[..., 2]),
        "View Distance": length(place),
    }


def window(context, settings, inputs):
    """Where a direction in camera space is in the frame. settings: window, of core.scene.Camera"""
    place, (left, right, low, high) = inputs["Vector"], settings["window"]
    depth = place[..., 2]
    depth = np.where(depth != 0.0, depth, np.float32(1.0))
    across = (place[..., 0] / depth - np.float32(left)) / np.float32(right - left)
    up = (place[..., 1] / depth - np.float32(low)) / np.float32(high - low)
    return {"": np.stack([across, up, np.zeros_like(up)], -1)}


def environment(context, settings, inputs):
    """An Environment Texture. settings: map (EnvironmentMap), lookup (of that)"""
    # Here and not above: the add-on imports the nodes before numba is known to be there.
    from ..light.environment import eval_environment_many

    places = as_vector(inputs.get("Vector", context.position), len(context))
    color = np.empty_like(places)
    eval_environment_many(settings["lookup"], places, color)
    return {"Color": color}


FUNCTIONS = {
    DIRECTION: direction,
    ENVIRONMENT: environment,
    "world_transform": transform,
    "world_camera_data": camera_data,
    "world_window": window,
}
