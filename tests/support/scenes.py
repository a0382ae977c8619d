"""Small scenes with known answers, as core.scene.Scene, and render() into plain layers.

World space, metres, z up. A part of a mesh is a tuple (vertices, triangles, corner normals).
"""

import numpy as np

from iwis.core.film import Film
from iwis.core.machine.watch import StopFlag
from iwis.core.render import render
from iwis.core.render_cache import RenderCache
from iwis.core.scene import (
    BLACK,
    DIFFUSE,
    GGX,
    GLOSSY,
    ORTHOGRAPHIC,
    PERSPECTIVE,
    PRINCIPLED,
    Camera,
    EnvironmentMap,
    MaterialParams,
    Scene,
    TriangleMesh,
)
from iwis.core.settings import RenderSettings
from iwis.core.tiles.tile_job import Job
from iwis.core.unit_square.sequence import common_points

MATERIAL = {
    "model": DIFFUSE,
    "distribution": GGX,
    "base_color": (0.8, 0.8, 0.8),
    "metallic": 0.0,
    "roughness": 0.5,
    "ior": 1.5,
    "specular_level": 0.5,
    "specular_tint": (1.0, 1.0, 1.0),
    "emission": (0.0, 0.0, 0.0),
    "diffuse_roughness": 0.0,
}
_INT8 = ("model", "distribution")


def diffuse(color=(0.8, 0.8, 0.8), **parameters) -> dict:
    """A Lambert material."""
    return MATERIAL | {"model": DIFFUSE, "base_color": color} | parameters


def glossy(alpha, color=(0.8, 0.8, 0.8), **parameters) -> dict:
    """A Glossy BSDF of width alpha (roughness squared)."""
    return MATERIAL | {"model": GLOSSY, "roughness": alpha**0.5, "base_color": color} | parameters


def principled(**parameters) -> dict:
    """A Principled BSDF."""
    return MATERIAL | {"model": PRINCIPLED} | parameters


def black(**parameters) -> dict:
    """A material that reflects nothing."""
    return MATERIAL | {"model": BLACK} | parameters


def make_materials(*rows: dict) -> MaterialParams:
    """The table of some materials, one row each."""
    columns = {}
    for name, default in MATERIAL.items():
        values = [row[name] for row in rows]
        kind = np.int8 if name in _INT8 else np.float32
        columns[name] = np.array(values, kind).reshape(len(rows), *np.shape(default))
    return MaterialParams(**columns)


def quad(corner, u, v):
    """A parallelogram of two triangles; its front is the side of u x v."""
    corner, u, v = (np.asarray(a, np.float64) for a in (corner, u, v))
    normal = np.cross(u, v)
    normal /= np.linalg.norm(normal)
    vertices = np.stack([corner, corner + u, corner + u + v, corner + v])
    return vertices, np.array([[0, 1, 2], [0, 2, 3]]), np.tile(normal, (2, 3, 1))


def floor(half=1.0, z=0.0):
    """A square that looks up."""
    return quad((-half, -half, z), (2 * half, 0, 0), (0, 2 * half, 0))


def box(low, high):
    """Six quads that look outwards."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    dx, dy, dz = (x1 - x0, 0, 0), (0, y1 - y0, 0), (0, 0, z1 - z0)
    sides = [
        quad((x0, y0, z1), dx, dy),
        quad((x0, y0, z0), dy, dx),
        quad((x1, y0, z0), dy, dz),
        quad((x0, y0, z0), dz, dy),
        quad((x0, y0, z0), dx, dz),
        quad((x0, y1, z0), dz, dx),
    ]
    return join_parts(sides)


def sphere(center=(0.0, 0.0, 0.0), radius=1.0, rings=24, smooth=False):
    """A convex ball of flat (or smooth) faces, its poles on the z axis."""
    theta = np.linspace(0.0, np.pi, rings + 1)
    phi = np.linspace(0.0, 2.0 * np.pi, 2 * rings + 1)[:-1]
    t, p = np.meshgrid(theta, phi, indexing="ij")
    unit = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], -1).reshape(-1, 3)
    n, faces = 2 * rings, []
    for i in range(rings):
        for j in range(n):
            a, b = i * n + j, i * n + (j + 1) % n
            if i > 0:
                faces.append((a, a + n, b))
            if i < rings - 1:
                faces.append((b, a + n, b + n))
    faces = np.array(faces)
    corners = unit[faces]
    if not smooth:
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        flat /= np.linalg.norm(flat, axis=-1, keepdims=True)
        corners = np.repeat(flat[:, None], 3, axis=1)
    return unit * radius + np.asarray(center), faces, corners


def join_parts(parts):
    """One part of several."""
    starts = np.cumsum([0] + [len(vertices) for vertices, _, _ in parts])
    return (
        np.concatenate([vertices for vertices, _, _ in parts]),
        np.concatenate([tris + s for (_, tris, _), s in zip(parts, starts[:-1], strict=True)]),
        np.concatenate([normals for _, _, normals in parts]),
    )


def make_mesh(*parts) -> TriangleMesh:
    """Part k has material k and object k."""
    if not parts:
        parts = [(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3, 3)))]
    vertices, triangles, normals = join_parts(parts)
    rows = np.repeat(np.arange(len(parts)), [len(part[1]) for part in parts])
    return TriangleMesh(
        vertices=vertices.astype(np.float32),
        triangles=triangles.astype(np.int32),
        corner_normals=np.ascontiguousarray(normals, np.float32),
        material_index=rows.astype(np.int32),
        object_index=rows.astype(np.int32),
    )


def constant_world(color=(1.0, 1.0, 1.0), **fields) -> EnvironmentMap:
    """The same radiance from everywhere."""
    return EnvironmentMap(radiance=np.full((2, 4, 3), color, np.float32), **fields)


def gradient_world(height=16, **fields) -> EnvironmentMap:
    """Coloured light that changes smoothly with longitude and latitude, about 1 on average."""
    v, u = np.meshgrid(
        (np.arange(height) + 0.5) / height,
        (np.arange(2 * height) + 0.5) / (2 * height),
        indexing="ij",
    )
    a = 2.0 * np.pi * u
    radiance = np.stack([0.2 + v + 0.5 * np.cos(a), 0.9 + 0.4 * np.sin(a), 1.4 - v], -1)
    return EnvironmentMap(radiance=np.maximum(radiance, 0.05).astype(np.float32), **fields)


def one_texel_world(height=32, row=24, column=40, value=1e5, ground=0.0, **fields):
    """A sun of one texel in a sky of radiance ``ground``."""
    radiance = np.full((height, 2 * height, 3), ground, np.float32)
    radiance[row, column] = value
    return EnvironmentMap(radiance=radiance, **fields)


def camera_above(width=16, height=16, half=0.9, z=10.0, region=None) -> Camera:
    """An orthographic camera that looks straight down at 2 half x 2 half metres; x right, y up."""
    matrix = np.eye(4)
    matrix[2, 3] = z
    return Camera(
        kind=ORTHOGRAPHIC,
        camera_to_world=matrix,
        window=(-half, half, -half, half),
        width=width,
        height=height,
        region=region or (0, 0, width, height),
        clip_start=0.1,
        clip_end=1000.0,
    )


def camera_at(position, target, width=16, height=16, half=0.4, region=None) -> Camera:
    """A perspective camera; ``half`` is the tangent of half its field of view."""
    position, target = np.asarray(position, np.float64), np.asarray(target, np.float64)
    back = (position - target) / np.linalg.norm(position - target)
    right = np.cross((0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :4] = np.stack([right, np.cross(back, right), back, position], -1)
    return Camera(
        kind=PERSPECTIVE,
        camera_to_world=matrix,
        window=(-half, half, -half * height / width, half * height / width),
        width=width,
        height=height,
        region=region or (0, 0, width, height),
        clip_start=0.01,
        clip_end=1000.0,
    )


def make_scene(parts, materials, world, camera, **fields) -> Scene:
    """parts and materials: of equal length; part k has material k."""
    return Scene(
        mesh=make_mesh(*parts),
        materials=make_materials(*materials),
        environment=world,
        camera=camera,
        material_pass_index=np.arange(len(materials), dtype=np.float32) + 10.0,
        object_pass_index=np.arange(len(parts), dtype=np.float32) + 20.0,
        **fields,
    )


def varied_scene(world=None, width=40, height=28, region=None) -> Scene:
    """A room's worth of trouble: five materials, shadows, a curved and a hidden part, some sky.

    All lobes have one width: the tables of mode PAPER are three, not five.
    """
    parts = [
        floor(1.2),
        box((-0.9, -0.5, 0.0), (-0.4, 0.0, 0.7)),
        sphere((0.3, 0.1, 0.35), 0.35, rings=8, smooth=True),
        quad((-0.5, 0.6, 0.0), (1.2, 0.0, 0.0), (0.0, 0.2, 0.9)),
        quad((0.75, -0.6, 0.1), (0.4, 0.0, 0.0), (0.0, 0.4, 0.0)),
    ]
    materials = [
        diffuse((0.6, 0.5, 0.4)),
        glossy(0.4**2, (0.9, 0.7, 0.5)),
        principled(base_color=(0.2, 0.5, 0.8), roughness=0.4),
        principled(base_color=(0.9, 0.8, 0.3), metallic=1.0, roughness=0.4),
        black(emission=(0.5, 0.2, 0.1)),
    ]
    camera = camera_at((1.6, -2.6, 1.7), (0.0, 0.0, 0.3), width, height, 0.55, region)
    return make_scene(parts, materials, world or gradient_world(), camera)


def make_picture(scene: Scene, cache=None, **settings):
    """(layers, stats) of a render by one thread and at pixel centres, unless settings say other."""
    film = Film(scene.camera.region)
    settings = RenderSettings(**({"threads": 1, "pixel_filter": "CENTER"} | settings))
    stats = render(scene, settings, film, cache)
    return film.layers, stats


def make_job(scene: Scene, **settings) -> Job:
    """What a tile of a render with these settings works on; estimator UNBIASED only."""
    settings, cache = RenderSettings(**settings), RenderCache()
    light = cache.light(scene.environment)
    sequence = common_points(settings.max_samples, settings.point_set)
    accel, stop = cache.accel(scene.mesh), StopFlag()
    return Job(scene, settings, accel, light, None, sequence, stop)
