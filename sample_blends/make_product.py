"""Makes product.blend: a tea set on a paper sweep in a workshop hall.

    python sample_blends/make_product.py [FOLDER]

Glossy paint, brushed and satin metal, plastic and matt clay beside each other: narrow lobes
under small bright lamps, and soft shadows on the ground they stand on.
"""

import math
import sys

import numpy as np
from common import FOLDER, add_camera, diffuse, light_by_hdri, new_scene, principled, save
from shapes import add_mesh, bevel, box, join, lathe, move, subdivide, tube

POT = (  # radius, height from the lid's knob down to the foot, metres
    (0.0, 0.118), (0.030, 0.1175), (0.052, 0.1125), (0.066, 0.100), (0.079, 0.078),
    (0.083, 0.055), (0.077, 0.030), (0.062, 0.012), (0.048, 0.005), (0.047, 0.0), (0.0, 0.0),
)  # fmt: skip
LID = (
    (0.0, 0.130), (0.018, 0.1285), (0.031, 0.1245), (0.0345, 0.1195), (0.0345, 0.1165),
    (0.0, 0.1165),
)  # fmt: skip
KNOB = (
    (0.0, 0.1575), (0.0085, 0.156), (0.0125, 0.150), (0.0105, 0.143), (0.0055, 0.138),
    (0.0055, 0.127), (0.0, 0.127),
)  # fmt: skip
CUP = (
    (0.0, 0.012), (0.018, 0.013), (0.030, 0.024), (0.0365, 0.044), (0.0385, 0.062),
    (0.0402, 0.0630), (0.0410, 0.062), (0.0390, 0.044), (0.0330, 0.022), (0.022, 0.009),
    (0.0205, 0.0), (0.0, 0.0),
)  # fmt: skip
SAUCER = (
    (0.0, 0.007), (0.030, 0.0075), (0.052, 0.012), (0.068, 0.0175), (0.0692, 0.0165),
    (0.054, 0.0085), (0.032, 0.0), (0.0, 0.0),
)  # fmt: skip
CADDY = (
    (0.0, 0.1), (0.032, 0.1), (0.034, 0.0985), (0.0345, 0.096), (0.0345, 0.004),
    (0.033, 0.0), (0.0, 0.0),
)  # fmt: skip

SUGAR = (
    ((0.055, -0.125, 0.0), 20.0), ((0.074, -0.133, 0.0), -14.0), ((0.064, -0.128, 0.014), 41.0),
)  # fmt: skip


def curve(knots, n):
    """n points along a Catmull-Rom spline through `knots`, ends included."""
    knots = np.asarray(knots, float)
    padded = np.concatenate((2 * knots[:1] - knots[1:2], knots, 2 * knots[-1:] - knots[-2:-1]))
    t = np.linspace(0, len(knots) - 1, n)
    i = np.minimum(t.astype(int), len(knots) - 2)
    f = (t - i)[:, None]
    a, b, c, d = (padded[i + k] for k in range(4))
    return 0.5 * (2 * b + (c - a) * f + (2 * a - 5 * b + 4 * c - d) * f**2
                  + (3 * b - a - 3 * c + d) * f**3)  # fmt: skip


def add_pot(scene, enamel, copper, plastic):
    """Teapot: enamelled body and lid, copper spout tip and knob, a plastic bail handle."""
    turn = {"turn_deg": -38.0, "offset": (0.0, 0.0, 0.0)}
    subdivide(add_mesh(scene, "Pot", *move(lathe(POT, 24), **turn), enamel), 3)
    subdivide(add_mesh(scene, "Lid", *move(lathe(LID, 24), **turn), enamel), 3)
    subdivide(add_mesh(scene, "Knob", *move(lathe(KNOB, 16), **turn), copper), 3)
    path = curve(((0.060, 0, 0.040), (0.094, 0, 0.058), (0.110, 0, 0.088), (0.134, 0, 0.108)), 8)
    spout = tube(path, np.linspace(0.023, 0.0085, 8), 10)
    subdivide(add_mesh(scene, "Spout", *move(spout, **turn), enamel), 2)
    tip = lathe(
        ((0.0088, 0.012), (0.0102, 0.011), (0.0102, 0.0), (0.0088, -0.001)), 16, closed=True
    )
    tip = tilt(tip, 62.0, (0.1325, 0, 0.107))
    subdivide(add_mesh(scene, "Spout tip", *move(tip, **turn), copper), 2)
    bail = ((-0.064, 0, 0.103), (-0.080, 0, 0.150), (-0.042, 0, 0.196))
    bail += tuple((-x, y, z) for x, y, z in bail[::-1])
    subdivide(
        add_mesh(scene, "Bail", *move(tube(curve(bail, 14), [0.0032] * 14, 8), **turn), copper), 2
    )
    grip = curve(((-0.036, 0, 0.199), (0, 0, 0.2045), (0.036, 0, 0.199)), 7)
    radii = (0.005, 0.0078, 0.0088, 0.009, 0.0088, 0.0078, 0.005)
    subdivide(add_mesh(scene, "Grip", *move(tube(grip, radii, 10), **turn), plastic), 2)
    for side in (-1, 1):
        stud = [(x, z) for x, z in ((0.0, 0.006), (0.006, 0.005), (0.0075, 0.0), (0.0, 0.0))]
        stud = tilt(lathe(stud, 12), 55.0 * side, (0.0645 * side, 0, 0.100))
        subdivide(add_mesh(scene, "Stud", *move(stud, **turn), copper), 2)


def tilt(part, angle_deg, offset):
    """(vertices, faces) leant from +z towards +x, then moved."""
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    turn = np.array(((c, 0, -s), (0, 1, 0), (s, 0, c)))
    return list(np.asarray(part[0]) @ turn + offset), part[1]


def add_cup(scene, location, glaze, saucer_material):
    """A cup without a handle on its saucer."""
    subdivide(add_mesh(scene, "Saucer", *lathe(SAUCER, 28), saucer_material, location=location), 3)
    above = (location[0], location[1], location[2] + 0.0075)
    subdivide(add_mesh(scene, "Cup", *lathe(CUP, 24), glaze, location=above), 3)


def add_spoon(scene, steel):
    """A teaspoon, lying."""
    outline = ((0.0, 0.016), (0.010, 0.0155), (0.022, 0.011), (0.030, 0.004), (0.045, 0.0022),
               (0.080, 0.0024), (0.100, 0.0042), (0.110, 0.0035))  # fmt: skip
    rows = []
    for along, half in outline:
        bowl = max(0.0, 1.0 - abs(along - 0.008) / 0.024)
        rise = 0.006 * min(1.0, max(0.0, (along - 0.028) / 0.03))
        for across in (-1.0, -0.5, 0.0, 0.5, 1.0):
            z = 0.0065 - 0.0055 * bowl * (1 - across**2) + rise * (1 - along * 4)
            rows.append((along, across * half, z))
    faces = [
        (5 * i + j, 5 * i + 5 + j, 5 * i + 6 + j, 5 * i + 1 + j)
        for i in range(len(outline) - 1)
        for j in range(4)
    ]
    part = move((rows, faces), turn_deg=9.0, offset=(0.125, -0.135, 0.001))
    spoon = add_mesh(scene, "Spoon", *part, steel)
    solid = spoon.modifiers.new("Solidify", "SOLIDIFY")
    solid.thickness = 0.0014
    subdivide(spoon, 3)


def add_caddy(scene, location, steel, lacquer):
    """A tea caddy: a lacquered tin with a polished lid."""
    tin = add_mesh(scene, "Caddy", *lathe(CADDY, 64), lacquer, location=location)
    bevel(tin, 0.0006, angle_deg=20.0)
    lid = (
        (0.0, 0.034),
        (0.033, 0.034),
        (0.0355, 0.0325),
        (0.0362, 0.030),
        (0.0362, 0.0),
        (0.0, 0.0),
    )
    above = (location[0], location[1], location[2] + 0.088)
    bevel(
        add_mesh(scene, "Caddy lid", *lathe(lid, 64), steel, location=above), 0.0006, angle_deg=20.0
    )


def add_sweep(scene, paper):
    """Floor and background of one sheet, bent where they meet."""
    bend = [(0.75 + 0.45 * math.sin(a), 0.45 - 0.45 * math.cos(a))
            for a in np.linspace(0, math.pi / 2, 9)]  # fmt: skip
    section = [(-1.1, 0.0), (0.2, 0.0), *bend, (1.2, 0.9), (1.2, 1.5)]
    vertices = [(x, y, z) for y, z in section for x in (-2.2, 2.2)]
    faces = [(2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2) for i in range(len(section) - 1)]
    add_mesh(scene, "Paper sweep", vertices, faces, paper)


def main(folder=FOLDER):
    """Build the scene and save it in `folder`."""
    scene = new_scene(size=(640, 360), exposure=0.25, look="AgX - Medium High Contrast")
    light_by_hdri(scene, "workshop", azimuth_deg=30.0)
    copper = principled("Brushed copper", (0.93, 0.52, 0.36), 0.28, metallic=1.0)
    steel = principled("Satin steel", (0.77, 0.78, 0.79), 0.25, metallic=1.0)
    enamel = principled("Teal enamel", (0.010, 0.105, 0.115), 0.14, ior=1.55)
    plastic = principled("Black plastic", (0.018, 0.018, 0.02), 0.42)
    glaze = principled("Cream glaze", (0.72, 0.62, 0.47), 0.22)
    lacquer = principled("Vermilion lacquer", (0.52, 0.045, 0.018), 0.2)
    clay = diffuse("Unglazed clay", (0.30, 0.17, 0.11))
    add_sweep(scene, diffuse("Paper", (0.46, 0.45, 0.43)))
    add_pot(scene, enamel, copper, plastic)
    add_cup(scene, (0.175, 0.005, 0.0), glaze, clay)
    add_cup(scene, (-0.140, -0.085, 0.0), glaze, clay)
    add_spoon(scene, steel)
    add_caddy(scene, (-0.165, 0.095, 0.0), steel, lacquer)
    sugar = join(*(move(box((0.014, 0.014, 0.014)), offset=o, turn_deg=t) for o, t in SUGAR))
    bevel(
        add_mesh(scene, "Sugar", *sugar, diffuse("Sugar", (0.85, 0.84, 0.81)), smooth=False), 0.0015
    )
    add_camera(scene, location=(0.10, -1.02, 0.34), target=(0.012, 0, 0.078), lens_mm=72)
    save("product", folder)


if __name__ == "__main__":
    main(*sys.argv[1:])
