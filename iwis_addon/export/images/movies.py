"""Frames of movies that are textures.

Blender hands out the pixels of the frame that was looked at last, whoever did: here a texture of
its old kind looks. Measured in 4.5 and 5.2, without a window too: the pixels are Cycles' to 3e-7.
"""

from __future__ import annotations

import bpy

from ...scratch import scratch


def frame_of(image_user, frame: int | None) -> int:
    """The movie's frame, counted from 1, that a node shows at a frame of the scene.

    As Blender works it out for who refreshes by itself, and Cycles for all; None: as worked out
    """
    if frame is None:
        return image_user.frame_current
    length = image_user.frame_duration
    if not length:
        return 0
    place = frame - image_user.frame_start + 1
    if image_user.use_cyclic:
        place = place % length or length
    return min(max(place, 0), length) + image_user.frame_offset


def show_frame(image, frame: int) -> None:
    """Have image.pixels be those of a frame; beyond either end it is the first, or the last."""
    made = bpy.data.textures.new("IWIS frame", "IMAGE")
    with scratch(bpy.data.textures, made) as texture:
        texture.image = image
        texture.image_user.frame_current = frame
        texture.evaluate((0.0, 0.0, 0.0))
