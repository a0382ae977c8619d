"""A bumpy ball of any number of triangles under an HDRI of any size: plain arrays, without bpy."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from iwis.core.exr import read_exr_layers
from iwis.core.scene import (
    DIFFUSE,
    GGX,
    PERSPECTIVE,
    Camera,
    EnvironmentMap,
    MaterialParams,
    Scene,
    TriangleMesh,
)

HDRI = Path(__file__).resolve().parent.parent / "sample_blends" / "hdri" / "hall.exr"
DISTANCE, HALF_WINDOW = 4.0, 0.3


def ball(triangles: int) -> TriangleMesh:
    """About so many triangles, smooth, of radius 1 with bumps of several sizes."""
    rows = max(8, round(math.sqrt(triangles / 4.0)))
    columns = 2 * rows
    polar = np.linspace(1e-3, math.pi - 1e-3, rows + 1)[:, None]
    angle = np.arange(columns) * (2.0 * math.pi / columns)
    radius = 1.0 + 0.06 * np.sin(9.0 * polar) * np.cos(8.0 * angle)
    radius += 0.02 * np.sin(31.0 * polar + 1.0) * np.cos(29.0 * angle)
    across = radius * np.sin(polar)
    points = np.stack(
        [across * np.cos(angle), across * np.sin(angle), radius * np.cos(polar)], -1
    ).astype(np.float32)
    down = np.gradient(points, axis=0)
    around = np.roll(points, -1, axis=1) - np.roll(points, 1, axis=1)
    normals = np.cross(down, around)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    index = np.arange((rows + 1) * columns, dtype=np.int32).reshape(rows + 1, columns)
    a, b = index[:-1], index[1:]
    next_a, next_b = np.roll(a, -1, axis=1), np.roll(b, -1, axis=1)
    # Two by two, as Blender makes triangles of quads.
    faces = np.stack([a, b, next_b, a, next_b, next_a], -1).reshape(-1, 3)
    zeros = np.zeros(len(faces), np.int32)
    return TriangleMesh(
        vertices=np.ascontiguousarray(points.reshape(-1, 3)),
        triangles=faces,
        corner_normals=np.ascontiguousarray(normals.reshape(-1, 3)[faces], np.float32),
        material_index=zeros,
        object_index=zeros,
    )


def environment(width: int, seed: int = 0) -> EnvironmentMap:
    """hall.exr at any width that is a power of two from 512 up, with grain down to the texel.

    seed: of the grain: with another the image is another for whatever keeps something of it
    """
    (layers,) = read_exr_layers(HDRI).values()
    small = np.ascontiguousarray(layers[..., :3], np.float32)
    times = width // small.shape[1]
    radiance = small.repeat(times, axis=0).repeat(times, axis=1)
    grain = np.random.default_rng(seed).random(radiance.shape[:2], np.float32)
    radiance *= 0.5 + grain[..., None]
    return EnvironmentMap(radiance=radiance)


def scene(mesh: TriangleMesh, light: EnvironmentMap, side: int) -> Scene:
    """The ball of white stone that fills a square picture of side x side pixels."""
    to_world = np.eye(4)
    to_world[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]  # looks along y
    to_world[1, 3] = -DISTANCE
    return Scene(
        mesh=mesh,
        materials=stone(),
        environment=light,
        camera=Camera(
            kind=PERSPECTIVE,
            camera_to_world=to_world,
            window=(-HALF_WINDOW, HALF_WINDOW, -HALF_WINDOW, HALF_WINDOW),
            width=side,
            height=side,
            region=(0, 0, side, side),
            clip_start=0.1,
            clip_end=100.0,
        ),
        material_pass_index=np.zeros(1, np.float32),
        object_pass_index=np.zeros(1, np.float32),
    )


def stone() -> MaterialParams:
    """One diffuse material."""

    def row(*values):
        return np.array([values if len(values) > 1 else values[0]], np.float32)

    return MaterialParams(
        model=np.array([DIFFUSE], np.int8),
        distribution=np.array([GGX], np.int8),
        base_color=row(0.7, 0.68, 0.63),
        metallic=row(0.0),
        roughness=row(0.5),
        ior=row(1.5),
        specular_level=row(0.5),
        specular_tint=row(1.0, 1.0, 1.0),
        emission=row(0.0, 0.0, 0.0),
        diffuse_roughness=np.zeros(1, np.float32),
    )
