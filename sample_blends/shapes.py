"""Meshes out of code: surfaces of revolution, tubes, boxes, sheets; and the modifiers on them.

Shapes are coarse: a Subdivision or Bevel modifier makes the rest when the file is opened.
"""

import math

import bpy
import numpy as np


def add_mesh(scene, name, vertices, faces, material, *, smooth=True, location=(0, 0, 0)):
    """A new object of the given polygons. vertices: (n, 3), metres; faces: lists of indices"""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(map(float, v)) for v in vertices], [], [list(f) for f in faces])
    mesh.validate()
    mesh.materials.append(material)
    mesh.polygons.foreach_set("use_smooth", np.full(len(mesh.polygons), smooth))
    shape = bpy.data.objects.new(name, mesh)
    shape.location = location
    scene.collection.objects.link(shape)
    return shape


def lathe(profile, segments, *, closed=False):
    """Surface of revolution about z. profile: (n, 2) radius and height, the outside to its right
    when walking along it downwards; closed: the profile is a ring. Returns vertices, faces.

    A radius of 0 becomes a single vertex, a pole.
    """
    vertices, rings = [], []
    for radius, height in profile:
        rings.append(len(vertices))
        angles = [0.0] if radius == 0 else np.arange(segments) * (2 * math.pi / segments)
        vertices += [(radius * math.cos(a), radius * math.sin(a), height) for a in angles]
    sizes = np.diff([*rings, len(vertices)])
    faces = []
    n = len(rings)
    for i in range(n if closed else n - 1):
        k = (i + 1) % n
        faces += _band(rings[i], sizes[i], rings[k], sizes[k], segments)
    return vertices, faces


def _band(first, n_first, second, n_second, segments):
    """Faces between two rings, each of `segments` vertices or of 1."""
    faces = []
    for j in range(segments):
        k = (j + 1) % segments
        corners = [first + j % n_first, second + j % n_second]
        corners += [second + k % n_second, first + k % n_first]
        faces.append(list(dict.fromkeys(corners)))
    return faces


def tube(points, radii, segments, *, closed=False):
    """Tube along a path, as vertices and faces. points: (n, 3); radii: (n,); closed: ends meet"""
    points = np.asarray(points, float)
    n = len(points)
    tangents = np.roll(points, -1, 0) - np.roll(points, 1, 0) if closed else np.gradient(points)[0]
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    normal = np.cross(tangents[0], (0.31, 0.2, 0.93))
    vertices = []
    for point, tangent, radius in zip(points, tangents, radii, strict=True):
        normal = normal - tangent * (normal @ tangent)  # carried along, so that it does not twist
        normal /= np.linalg.norm(normal)
        binormal = np.cross(tangent, normal)
        for a in np.arange(segments) * (2 * math.pi / segments):
            vertices.append(point + radius * (math.cos(a) * normal + math.sin(a) * binormal))
    faces = []
    for i in range(n if closed else n - 1):
        k = (i + 1) % n
        faces += _band(k * segments, segments, i * segments, segments, segments)
    if not closed:
        faces += [list(range(segments))[::-1], list(range((n - 1) * segments, n * segments))]
    return vertices, faces


def box(size):
    """Box on the plane z = 0, centred in x and y. size: (x, y, z). Returns vertices, faces."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    vertices = [(i * x, j * y, k * z) for k in (0, 1) for j in (-1, 1) for i in (-1, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return vertices, faces


def join(*parts):
    """One (vertices, faces) of several."""
    vertices, faces = [], []
    for part_vertices, part_faces in parts:
        faces += [[i + len(vertices) for i in face] for face in part_faces]
        vertices += list(part_vertices)
    return vertices, faces


def move(part, *, offset=(0, 0, 0), turn_deg=0.0, scale=1.0):
    """(vertices, faces) scaled, turned about z, then moved."""
    c, s = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    turn = np.array(((c, s, 0), (-s, c, 0), (0, 0, 1)))
    return list(np.asarray(part[0], float) * scale @ turn + offset), part[1]


def subdivide(shape, levels):
    """Catmull-Clark on load, the same in the window and in the render."""
    modifier = shape.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = levels
    # The limit surface costs the statue 4.6 s of CPU each time it is evaluated, without it .16.
    modifier.use_limit_surface = False
    return shape


def bevel(shape, width, *, segments=3, angle_deg=30.0):
    """Rounded edges on load: an edge without a highlight looks like a drawing."""
    modifier = shape.modifiers.new("Bevel", "BEVEL")
    modifier.width, modifier.segments = width, segments
    modifier.limit_method, modifier.angle_limit = "ANGLE", math.radians(angle_deg)
    modifier.harden_normals = True
    return shape
