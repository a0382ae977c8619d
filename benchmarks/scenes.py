"""Builds the scenes of the benchmarks: self-occluding, thin, and lit through a window.

    python benchmarks/scenes.py [--out FOLDER] [NAME ...]

Lit by the HDRIs of sample_blends/hdri (CC0). The shadow terminator offset, a feature of Cycles that
bends shadow rays near the horizon of coarse smooth meshes, is off: it is not what is compared.
"""

from __future__ import annotations

import argparse
import functools
import math
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

ROOT = Path(__file__).resolve().parent.parent
FOLDER, HDRIS = ROOT / "out" / "benchmarks", ROOT / "sample_blends" / "hdri"
STONE, SOIL, LEAF, STEEL = (0.7, 0.68, 0.63), (0.30, 0.22, 0.14), (0.22, 0.42, 0.12), (0.5,) * 3


def new_scene(hdri: str, turn_deg: float, size: tuple[int, int]):
    """An empty file under an HDRI of HDRIS, turned about z; returns its scene."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0):
        scene.world.use_nodes = True
    tree = scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(str(HDRIS / f"{hdri}.exr"))
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value[2] = math.radians(turn_deg)
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    return scene


def add_camera(scene, location, target, angle_deg: float) -> None:
    """The scene's camera; angle_deg: the field of view across the picture."""
    data = bpy.data.cameras.new("Camera")
    data.sensor_fit, data.angle = "HORIZONTAL", math.radians(angle_deg)
    camera = bpy.data.objects.new("Camera", data)
    camera.location = location
    direction = Vector(target) - Vector(location)
    camera.rotation_euler = direction.to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera


def material(name: str, node: str, **inputs):
    """A material of one shader; inputs: socket names with _ for blanks, and distribution."""
    made = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0):
        made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new(f"ShaderNode{node}")
    tree.links.new(shader.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    for key, value in inputs.items():
        if key == "distribution":
            shader.distribution = value
        else:
            color = isinstance(value, tuple)
            shader.inputs[key.replace("_", " ")].default_value = (*value, 1.0) if color else value
    return made


def diffuse(color):
    """A Diffuse BSDF."""
    return material("diffuse", "BsdfDiffuse", Color=color)


def principled(color, roughness, metallic=0.0, distribution="GGX"):
    """A Principled BSDF."""
    return material(
        "principled",
        "BsdfPrincipled",
        Base_Color=color,
        Roughness=roughness,
        Metallic=metallic,
        distribution=distribution,
    )


def sheet(points, *, ring=False):
    """Quads between the rows of a grid of points (rows, columns, 3); ring: columns close.

    Returns vertices (n, 3) and quads (m, 4).
    """
    rows, columns = points.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    if ring:
        index = np.concatenate([index, index[:, :1]], axis=1)
    quads = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], -1)
    return points.reshape(-1, 3), quads.reshape(-1, 4)


def turned(radius, height, columns: int, *, flat: float = 1.0):
    """Surface of revolution about z. radius, height: (rows,) or (rows, columns); flat: y over x."""
    angle = np.arange(columns) * (2.0 * np.pi / columns)
    radius, height = (
        np.broadcast_to(np.atleast_2d(a.T).T, (len(a), columns)) for a in (radius, height)
    )
    points = np.stack([radius * np.cos(angle), flat * radius * np.sin(angle), height], -1)
    return sheet(points, ring=True)


def joined(parts):
    """One (vertices, quads) of several."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    quads = [faces + start for (_, faces), start in zip(parts, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(quads)


def add_mesh(scene, name, part, surface, *, smooth=False):
    """A new object of quads."""
    vertices, quads = part
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(vertices, np.float32).ravel())
    mesh.loops.add(quads.size)
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(quads, np.int32).ravel())
    mesh.polygons.add(len(quads))
    mesh.polygons.foreach_set("loop_start", np.arange(0, quads.size, 4, dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh.validate()
    (mesh.shade_smooth if smooth else mesh.shade_flat)()
    mesh.materials.append(surface)
    shape = bpy.data.objects.new(name, mesh)
    shape.shadow_terminator_geometry_offset = 0.0
    scene.collection.objects.link(shape)


def add_monkey(surface, location, size, levels: int, turn_deg=(0.0, 0.0, 0.0)):
    """Suzanne, smooth, subdivided when it is rendered."""
    bpy.ops.mesh.primitive_monkey_add(
        size=2.0 * size, location=location, rotation=[math.radians(a) for a in turn_deg]
    )
    monkey = bpy.context.object
    modifier = monkey.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 0, levels
    monkey.data.shade_smooth()
    monkey.data.materials.append(surface)
    monkey.shadow_terminator_geometry_offset = 0.0
    return monkey


def box(low, high):
    """Six faces, outside out, between two corners."""
    corners = np.array([[(low, high)[(k >> a) & 1][a] for a in range(3)] for k in range(8)], float)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return corners, np.array(quads)


def robe(rows: int, columns: int):
    """A long robe, pleated and swagged, deepest towards the hem."""
    t = np.linspace(0.0, 1.0, rows)[:, None]
    a = np.arange(columns) * (2.0 * np.pi / columns)
    body = np.interp(t, (0, 0.08, 0.3, 0.5, 0.7, 0.9, 1), (1.2, 1.25, 0.95, 0.75, 0.8, 0.5, 0.25))
    pleats = np.abs(np.sin(8 * a + 4 * t + 1.2 * np.sin(3 * a + 5 * t))) ** 0.7
    swags = np.abs(np.sin(15 * np.pi * t + 1.8 * np.sin(2 * a) + 0.5 * np.cos(5 * a))) ** 0.6
    radius = body * (0.66 + 0.28 * pleats * (1.0 - 0.5 * t) + 0.18 * swags * (1.0 - 0.4 * t))
    return turned(radius, 0.95 + 2.35 * t[:, 0], columns, flat=0.8)


def colonnade(rings, columns: int, rows: int):
    """Rings of thin pillars between z = .12 and .72. rings: (radius, number, thickness)"""
    parts = []
    height = np.linspace(0.12, 0.72, rows)
    swell = 1.0 - 0.25 * np.sin(np.pi * np.linspace(0.0, 1.0, rows))
    for radius, number, thickness in rings:
        for angle in np.arange(number) * (2.0 * np.pi / number) + radius:
            vertices, quads = turned(thickness * swell, height, columns)
            place = (radius * np.cos(angle), 0.85 * radius * np.sin(angle), 0.0)
            parts.append((vertices + place, quads))
    return joined(parts)


def statue(make_surface, *, hdri: str = "hall", detail: float = 1.0, size=(200, 400)):
    """A robed figure on a colonnade: the head sees the sky, the feet hardly. A million triangles
    at detail 1. make_surface: makes its material, in the new file."""
    scene = new_scene(hdri, 70.0, size)
    surface = make_surface()
    levels = 4 if detail >= 1.0 else 2
    rows, columns = round(420 * detail), round(520 * detail)
    add_mesh(scene, "robe", robe(rows, columns), surface, smooth=True)
    add_monkey(surface, (0.0, -0.12, 3.62), 0.8, levels, (-8.0, 0.0, 0.0))
    for x, y, z, turn in (
        (-0.72, -0.74, 1.42, 28.0),
        (0.72, -0.74, 1.42, -28.0),
        (0, -0.98, 1.2, 0),
    ):
        add_monkey(surface, (x, y, z), 0.36, max(levels - 1, 1), (-12.0, 0.0, turn))
    rings = ((1.30, 34, 0.045), (1.02, 26, 0.05), (0.7, 16, 0.06))
    pillars = colonnade(rings, round(24 * detail) + 6, round(36 * detail) + 4)
    add_mesh(scene, "pillars", pillars, surface, smooth=True)
    slab = np.array([0.01, 1.4, 1.45, 1.4, 0.01]), np.array([0.72, 0.72, 0.85, 0.98, 0.98])
    add_mesh(scene, "slab", turned(*slab, 180, flat=0.85), surface)
    base = np.array([0.01, 2.2, 2.2, 1.7, 1.7, 0.01]), np.array([-0.1, -0.1, 0.0, 0.0, 0.12, 0.12])
    add_mesh(scene, "base", turned(*base, 180), surface)
    add_camera(scene, (0.9, -8.6, 2.9), (0.0, -0.1, 2.02), 21.5)
    return scene


def blades(count: int, spread: float, rng):
    """Curved blades of grass, each of four quads, on a square of side 2 spread."""
    root = rng.uniform(-spread, spread, (count, 2))
    height, width = rng.uniform(0.22, 0.6, count), rng.uniform(0.006, 0.014, count)
    angle, lean = rng.uniform(0.0, 2.0 * np.pi, count), rng.uniform(0.1, 0.9, count)
    t = np.linspace(0.0, 1.0, 5)[:, None]
    along = np.stack([np.cos(angle), np.sin(angle)], -1)
    across = np.stack([-np.sin(angle), np.cos(angle)], -1)
    middle = root + (t**2 * lean * height)[..., None] * along
    edge = (width * (1.0 - 0.95 * t))[..., None] * across
    z = np.repeat((t * (1.0 - 0.25 * t) * height)[..., None], 2, axis=-1)[..., None]
    points = np.concatenate([np.stack([middle - edge, middle + edge], 2), z], -1)
    return joined([sheet(points[:, k]) for k in range(count)])


def foliage(*, size=(256, 256)):
    """Grass below a canopy of loose leaves and a grille of thin bars, glossy all."""
    scene, rng = new_scene("sunrise", 40.0, size), np.random.default_rng(3)
    ground = sheet(np.array([[(-12, -12, 0), (12, -12, 0)], [(-12, 12, 0), (12, 12, 0)]], float))
    add_mesh(scene, "ground", ground, principled(SOIL, 0.3))
    leaf = principled(LEAF, 0.3)
    add_mesh(scene, "grass", blades(26000, 3.4, rng), leaf)
    centre = rng.uniform((-2.6, -1.6, 2.1), (2.6, 2.6, 2.9), (9000, 3))
    long = rng.normal(size=(9000, 3))
    long *= rng.uniform(0.05, 0.1, (9000, 1)) / np.linalg.norm(long, axis=1, keepdims=True)
    wide = np.cross(long, rng.normal(size=(9000, 3))) * 0.4
    corners = np.stack([centre - long, centre + wide, centre + long, centre - wide], 1)
    add_mesh(scene, "leaves", (corners.reshape(-1, 3), np.arange(36000).reshape(-1, 4)), leaf)
    bars = [box((x - 0.012, 0.5, 0.9), (x + 0.012, 0.524, 2.3)) for x in np.linspace(-1.9, 1.9, 30)]
    bars += [box((-1.95, 0.49, z), (1.95, 0.534, z + 0.02)) for z in np.linspace(0.95, 2.25, 10)]
    add_mesh(scene, "grille", joined(bars), principled(STEEL, 0.3))
    add_camera(scene, (0.0, -4.1, 1.75), (0.0, 0.35, 0.38), 44.0)
    return scene


def interior(*, size=(256, 192)):
    """A room with one window, a table and figures: most of the light is blocked everywhere."""
    scene, wall = new_scene("sunset", 200.0, size), diffuse((0.75, 0.72, 0.66))
    walls = [
        box((-3.2, -4.2, -0.2), (3.2, 4.2, 0.0)),  # floor
        box((-3.2, -4.2, 3.0), (3.2, 4.2, 3.2)),  # ceiling
        box((-3.2, 4.0, 0.0), (3.2, 4.2, 3.0)),
        box((-3.2, -4.2, 0.0), (3.2, -4.0, 3.0)),
        box((-3.2, -4.0, 0.0), (-3.0, 4.0, 3.0)),
        box((3.0, -4.0, 0.0), (3.2, 4.0, 0.7)),  # the window's wall, in four pieces
        box((3.0, -4.0, 2.6), (3.2, 4.0, 3.0)),
        box((3.0, -4.0, 0.7), (3.2, -1.6, 2.6)),
        box((3.0, 2.6, 0.7), (3.2, 4.0, 2.6)),
    ]
    walls += [box((3.05, y, 0.7), (3.1, y + 0.04, 2.6)) for y in (-0.76, 0.08, 0.92, 1.76)]
    add_mesh(scene, "walls", joined(walls), wall)
    legs = [box((x, y, 0.0), (x + 0.08, y + 0.08, 0.8)) for x in (-0.7, 0.9) for y in (0.2, 1.7)]
    table = joined([box((-0.8, 0.1, 0.8), (1.1, 1.9, 0.86)), *legs])
    add_mesh(scene, "table", table, principled((0.35, 0.2, 0.1), 0.35))
    add_monkey(principled(STEEL, 0.3, 1.0), (0.2, 1.0, 1.22), 0.42, 3, (-15, 0, 40))
    add_monkey(diffuse(STONE), (-1.6, 2.6, 0.6), 0.7, 3, (-20, 0, 20))
    add_camera(scene, (-1.4, -3.4, 1.7), (0.4, 1.2, 1.0), 62.0)
    return scene


gold = functools.partial(principled, (0.8, 0.55, 0.3), 0.3, 1.0)
SCENES = {
    "statue_diffuse": lambda **given: statue(lambda: diffuse(STONE), **given),
    "statue_glossy": lambda **given: statue(gold, hdri="workshop", **given),
    "foliage": foliage,
    "interior": interior,
}


def save(name: str, folder: Path = FOLDER, **given) -> Path:
    """Build a scene and save it as folder/NAME.blend. given: arguments of its function"""
    folder.mkdir(parents=True, exist_ok=True)
    SCENES[name](**given)
    path = folder / f"{name}.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path.resolve()), compress=False)
    return path


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Build the scenes of the benchmarks.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(SCENES))
    parser.add_argument("--out", type=Path, default=FOLDER, metavar="FOLDER")
    options = parser.parse_args()
    unknown = set(options.names) - set(SCENES)
    if unknown:
        parser.error(f"no scene {', '.join(sorted(unknown))}; there are {', '.join(SCENES)}")
    for wanted in options.names or SCENES:
        print(save(wanted, options.out))
