"""Shading points as the camera has them: where they are, how large a pixel is there, how far.

place: float32 (n, 3), of from_camera
"""

from __future__ import annotations

import numpy as np

from ..camera.panorama_places import space_axes
from ..scene import Camera


def from_camera(camera: Camera, position: np.ndarray) -> np.ndarray:
    """float32 (n, 3): right, up, away from the camera; of a panorama as space_axes has it.

    position: float32 (n, 3), world space
    """
    matrix = np.linalg.inv(camera.camera_to_world @ space_axes(camera))
    return (position @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32)


def footprint_at(camera: Camera, place: np.ndarray) -> np.ndarray:
    """float32 (n,), metres that a pixel covers at the places, seen straight on."""
    if camera.kind == "PANORAMIC":
        from ..camera.panorama import pixel_angle  # a kernel: the exporters load without numba

        distance = np.linalg.norm(place, axis=1)
        return np.maximum(distance * pixel_angle(camera), 1e-6).astype(np.float32)
    left, right, _, _ = camera.window
    width = abs(right - left) / camera.width
    if camera.kind == "ORTHOGRAPHIC":
        return np.full(len(place), width, np.float32)
    return np.maximum(np.abs(place[:, 2]) * width, 1e-6).astype(np.float32)


def ray_length_at(camera: Camera, place: np.ndarray) -> np.ndarray:
    """float32 (n,), metres from where the ray began: as in Cycles, on the near clip plane."""
    if camera.kind == "PANORAMIC":
        beyond = np.linalg.norm(place, axis=1) - camera.clip_start
        return np.maximum(beyond, 0.0).astype(np.float32)
    depth = np.abs(place[:, 2])
    beyond = np.maximum(depth - np.float32(camera.clip_start), 0.0)
    if camera.kind == "ORTHOGRAPHIC":
        return beyond
    slant = np.linalg.norm(place, axis=1) / np.maximum(depth, 1e-20)
    return (beyond * slant).astype(np.float32)
