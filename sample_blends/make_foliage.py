"""Makes foliage.blend: ivy on wrought iron in a meadow, thin occluders all over.

    python sample_blends/make_foliage.py [FOLDER]

All but the ground is instanced, each in another of Blender's ways: the fence is one collection,
instanced panel by panel; ivy leaves sit on points by geometry nodes, daisies are scattered by
geometry nodes, and the grass is a particle system of tufts.
"""

import math
import sys

import bpy
import numpy as np
from common import FOLDER, add_camera, diffuse, light_by_hdri, new_scene, principled, save
from geometry_nodes import Graph
from shapes import add_mesh, box, join, lathe, move, tube

PANEL_WIDTH, BARS = 1.2, 8
SPEAR = ((0.0, 0.115), (0.006, 0.095), (0.017, 0.045), (0.006, 0.015), (0.011, 0.008), (0.011, 0.0))
KNOB = (
    (0.0, 0.095), (0.02, 0.09), (0.036, 0.07), (0.04, 0.05), (0.033, 0.026), (0.018, 0.014),
    (0.036, 0.008), (0.036, 0.0),
)  # fmt: skip


def fence_panel():
    """Bars with spear heads between three rails, rings and scrolls in the upper field."""
    parts = [move(box((PANEL_WIDTH, 0.03, 0.012)), offset=(0, 0, z)) for z in (0.12, 1.12, 1.36)]
    pitch = PANEL_WIDTH / BARS
    for i in range(BARS):
        x = (i + 0.5) * pitch - PANEL_WIDTH / 2
        parts.append(move(box((0.016, 0.016, 1.52)), offset=(x, 0, 0)))
        parts.append(move(lathe(SPEAR, 8), offset=(x, 0, 1.52)))
        parts.append(ring((x + pitch / 2, 0, 1.246), 0.052))
        parts.append(scroll((x, 0, 0.62), 0.062, 1.0))
        parts.append(scroll((x, 0, 0.62), 0.062, -1.0))
    return join(*parts)


def ring(center, radius):
    """A ring of round iron in the plane of the fence."""
    a = np.arange(20) * (2 * math.pi / 20)
    points = np.stack((radius * np.cos(a), 0 * a, radius * np.sin(a)), 1) + center
    return tube(points, [0.0055] * 20, 6, closed=True)


def scroll(center, radius, side):
    """A C of flat-rolled iron that curls in at both ends, against a bar."""
    t = np.linspace(-1, 1, 25)
    angle = side * 4.4 * t
    r = radius * (1.0 - 0.62 * np.abs(t) ** 1.3)
    x = side * (radius - r * np.cos(angle))
    z = 0.115 * np.sin(0.5 * math.pi * np.clip(t * 1.6, -1, 1)) + 0.5 * r * np.sin(side * angle)
    points = np.stack((x + side * 0.006, 0 * t, z), 1) + center
    return tube(points, [0.0045] * 25, 6)


def add_fence(scene, iron):
    """Four panels, each an instance of one collection, and the posts between them."""
    panel = bpy.data.collections.new("Fence panel")
    shape = add_mesh(scene, "Panel", *fence_panel(), iron, smooth=False)
    scene.collection.objects.unlink(shape)
    panel.objects.link(shape)
    for i in range(4):
        empty = bpy.data.objects.new(f"Panel {i + 1}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", panel
        empty.location = ((i - 1.5) * PANEL_WIDTH, 0, 0)
        scene.collection.objects.link(empty)
    post = join(box((0.06, 0.06, 1.7)), move(lathe(KNOB, 16), offset=(0, 0, 1.7)))
    mesh = None
    for i in range(5):
        x = (i - 2) * PANEL_WIDTH
        if mesh is None:
            mesh = add_mesh(scene, "Post", *post, iron, smooth=False, location=(x, 0, 0)).data
            continue
        shape = bpy.data.objects.new("Post", mesh)
        shape.location = (x, 0, 0)
        scene.collection.objects.link(shape)


def ivy_leaf():
    """A leaf of five lobes, creased along its veins, hanging from the origin to -z, facing -y."""
    lobes = ((0, -0.10), (0.30, 0.06), (0.52, -0.16), (0.30, -0.40), (0.40, -0.70), (0.17, -0.68),
             (0.0, -1.08))  # fmt: skip
    outline = [(x, z) for x, z in lobes] + [(-x, z) for x, z in lobes[-2:0:-1]]
    center = (0.0, -0.04, -0.36)
    vertices = [center]
    for k, (x, z) in enumerate(outline):
        y = 0.10 * (x * x + 0.4 * z * z) + (-0.04 if k % 2 else 0.05)
        vertices.append((x, y, z))
    n = len(outline)
    return vertices, [(0, 1 + (k + 1) % n, 1 + k) for k in range(n)]


def vines(rng):
    """Stems that wander up the bars: a list of paths (n, 3)."""
    paths = []
    for i in range(30):
        x = -1.75 + 2.5 * rng.beta(1.0, 1.9) if i < 26 else 0.6 + 0.9 * rng.random()
        height = 0.55 + 1.05 * rng.random() * (1.0 if x < 0.1 else 0.55)
        n = max(6, int(height / 0.05))
        z = np.linspace(0.0, height, n)
        drift = np.cumsum(rng.normal(0.002, 0.021, n))
        side = np.where(rng.random() < 0.7, -1.0, 1.0) * (0.016 + 0.010 * np.sin(9 * z + i))
        paths.append(np.stack((x + drift, side, z), 1))
    return paths


def leaf_points(paths, rng):
    """Points on the stems' twigs where a leaf hangs. float (n, 3)"""
    points = []
    for path in paths:
        count = int(len(path) * 5.5)
        along = rng.random(count) * (len(path) - 1)
        i = along.astype(int)
        on_stem = path[i] + (path[i + 1] - path[i]) * (along - i)[:, None]
        twig = rng.normal(0.0, (0.055, 0.016, 0.04), (count, 3))
        twig[:, 1] = np.sign(on_stem[:, 1]) * (0.012 + np.abs(twig[:, 1]))
        points.append(on_stem + twig)
    return np.concatenate(points)


def add_ivy(scene, leaf_green, bark):
    """Stems as tubes; leaves on a cloud of points, turned and scaled by geometry nodes."""
    rng = np.random.default_rng(7)
    paths = vines(rng)
    stems = [tube(path, np.linspace(0.009, 0.003, len(path)), 6) for path in paths]
    add_mesh(scene, "Ivy stems", *join(*stems), bark)
    leaf = add_source(scene, "Ivy leaf", ivy_leaf(), leaf_green)
    cloud = add_mesh(scene, "Ivy", leaf_points(paths, rng), [], leaf_green)
    nodes = Graph("Ivy leaves")
    turn = nodes.random_vector((-0.75, -0.55, -0.85), (0.45, 0.55, 0.85), seed=1)
    size = nodes.random_float(0.055, 0.105, seed=2)
    instances = nodes.instance(nodes.input, leaf, turn, size)
    nodes.attach(cloud, instances)


def add_source(scene, name, part, material):
    """A mesh that is only ever instanced: no collection shows it."""
    shape = add_mesh(scene, name, *part, material, smooth=False)
    scene.collection.objects.unlink(shape)
    return shape


def grass_tuft():
    """Blades that bend outwards, in a tuft 1 high that grows along +y."""
    rng = np.random.default_rng(3)
    parts = []
    for _ in range(9):
        lean, turn, height = rng.uniform(0.12, 0.55), rng.uniform(0, 360), rng.uniform(0.55, 1.0)
        t = np.linspace(0, 1, 4)
        y, z = lean * t**2, height * (t - 0.22 * lean * t**3)
        half = 0.026 * (1 - t**1.5)
        vertices = [(s * w, b, c) for w, b, c in zip(half, y, z, strict=True) for s in (-1, 1)]
        faces = [(0, 1, 3, 2), (2, 3, 5, 4), (4, 5, 6)]
        vertices.pop()  # both edges end in the tip
        spot = (*rng.normal(0, 0.09, 2), 0.0)
        parts.append(move((vertices, faces), turn_deg=turn, offset=spot))
    vertices, faces = join(*parts)
    return [(x, z, -y) for x, y, z in vertices], faces


def add_grass(scene, ground, green):
    """Tufts by a particle system on the ground, which turns y to the normal, x and z at random."""
    tuft = add_source(scene, "Grass tuft", grass_tuft(), green)
    ground.modifiers.new("Grass", "PARTICLE_SYSTEM")
    system = ground.particle_systems[0]
    system.seed = 5
    hair = system.settings
    hair.name = "Grass"
    hair.type, hair.count, hair.hair_length = "HAIR", 4200, 1.0
    hair.use_advanced_hair = True
    # A collection: an object that nothing but a particle system uses is lost when saving.
    tufts = bpy.data.collections.new("Grass tufts")
    tufts.objects.link(tuft)
    hair.render_type, hair.instance_collection = "COLLECTION", tufts
    hair.particle_size, hair.size_random = 0.24, 0.6
    hair.use_rotations, hair.rotation_mode = True, "NOR"
    hair.phase_factor, hair.phase_factor_random = 0.0, 2.0


def daisy():
    """Stalk, ring of petals and yellow heart of a daisy 1 high, three (vertices, faces)."""
    stalk = tube(
        ((0, 0, 0), (0.02, 0.01, 0.4), (0.03, 0.03, 0.8), (0.02, 0.0, 1.0)), [0.013] * 4, 5
    )
    petals = []
    for k in range(13):
        vertices = [(0.03, 0.01, 0), (0.03, -0.01, 0), (0.12, -0.028, 0.02), (0.17, 0.0, 0.012),
                    (0.12, 0.028, 0.02)]  # fmt: skip
        petals.append(
            move((vertices, [(0, 1, 2, 3, 4)]), turn_deg=k * 360 / 13, offset=(0.02, 0, 1))
        )
    heart = move(lathe(((0.0, 0.045), (0.03, 0.035), (0.045, 0.0)), 8), offset=(0.02, 0, 1.0))
    return stalk, join(*petals), heart


def add_daisies(scene, ground_mesh, materials):
    """Daisies scattered over the ground by geometry nodes."""
    parts = daisy()
    flower = add_source(scene, "Daisy", join(*parts), materials[0])
    for material in materials[1:]:
        flower.data.materials.append(material)
    index = np.repeat(range(3), [len(part[1]) for part in parts]).astype(np.int32)
    flower.data.polygons.foreach_set("material_index", index)
    field = bpy.data.objects.new("Daisies", ground_mesh.copy())
    scene.collection.objects.link(field)
    nodes = Graph("Daisies")
    points = nodes.scatter(nodes.input, 13.0, seed=4)
    turn = nodes.random_vector((-0.3, -0.3, 0.0), (0.5, 0.3, 6.28), seed=5)
    nodes.attach(
        field, nodes.instance(points, flower, turn, nodes.random_float(0.16, 0.34, seed=6))
    )


def main(folder=FOLDER):
    """Build the scene and save it in `folder`."""
    scene = new_scene(size=(480, 320), exposure=0.3, look="AgX - Medium High Contrast")
    light_by_hdri(scene, "sunrise", azimuth_deg=24.0)
    iron = principled("Wrought iron", (0.022, 0.024, 0.027), 0.38, metallic=0.0)
    add_fence(scene, iron)
    leaf_green = principled("Ivy", (0.045, 0.13, 0.022), 0.36)
    add_ivy(scene, leaf_green, diffuse("Bark", (0.10, 0.065, 0.04)))
    corners = [(-3.2, -2.1, 0), (3.2, -2.1, 0), (3.2, 2.4, 0), (-3.2, 2.4, 0)]
    earth = diffuse("Earth", (0.06, 0.055, 0.025))
    ground = add_mesh(scene, "Meadow", corners, [(0, 1, 2, 3)], earth)
    grass = diffuse("Grass", (0.15, 0.23, 0.04))
    white = diffuse("Petal", (0.80, 0.79, 0.74))
    add_daisies(scene, ground.data, (grass, white, diffuse("Pollen", (0.75, 0.42, 0.02))))
    add_grass(scene, ground, grass)
    add_camera(scene, location=(0.75, -2.75, 0.95), target=(-0.22, 0, 0.74), lens_mm=40)
    save("foliage", folder)


if __name__ == "__main__":
    main(*sys.argv[1:])
