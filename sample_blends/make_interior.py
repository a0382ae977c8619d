"""Makes interior.blend: a room at daybreak, lit through its windows and by nothing else.

    python sample_blends/make_interior.py [FOLDER]

From most points the window is a small part of the sphere: nearly every sample that is drawn by
light and material alone ends on a wall. The low sun throws the glazing bars across the room; a
second window, out of the picture to the right, keeps the window wall from being black.
"""

import math
import sys

import numpy as np
from common import FOLDER, add_camera, diffuse, light_by_hdri, new_scene, principled, save
from shapes import add_mesh, bevel, box, join, lathe, move, subdivide, tube

WEST, EAST, SOUTH, NORTH, HEIGHT = -2.1, 2.3, -2.7, 2.1, 2.65  # inner faces of the walls, metres
THICK = 0.22

JUG = (
    (0.0, 0.012), (0.058, 0.014), (0.066, 0.06), (0.062, 0.13), (0.038, 0.195), (0.036, 0.23),
    (0.046, 0.262), (0.050, 0.262), (0.041, 0.23), (0.043, 0.197), (0.068, 0.132), (0.073, 0.06),
    (0.060, 0.004), (0.0, 0.0),
)  # fmt: skip
BOWL = (
    (0.0, 0.018), (0.05, 0.022), (0.10, 0.048), (0.132, 0.092), (0.136, 0.0935), (0.139, 0.091),
    (0.108, 0.042), (0.058, 0.012), (0.05, 0.0), (0.0, 0.0),
)  # fmt: skip
FRUIT = (
    (0.0, 0.064), (0.012, 0.0665), (0.028, 0.060), (0.0385, 0.036), (0.030, 0.010), (0.0, 0.0),
)  # fmt: skip
POT = (
    (0.0, 0.30), (0.15, 0.30), (0.155, 0.32), (0.172, 0.32), (0.175, 0.27), (0.158, 0.262),
    (0.125, 0.0), (0.0, 0.0),
)  # fmt: skip


def wall_with_opening(length, opening):
    """A wall along x from 0 to `length`, its inner face on y = 0. opening: (x0, x1, z0, z1)"""
    x0, x1, z0, z1 = opening

    def slab(left, right, low, high):
        size = (right - left, THICK, high - low)
        return move(box(size), offset=((left + right) / 2, THICK / 2, low))

    return join(
        slab(-THICK, x0, 0, HEIGHT),
        slab(x1, length + THICK, 0, HEIGHT),
        slab(x0, x1, 0, z0),
        slab(x0, x1, z1, HEIGHT),
    )


def casement(opening, columns, rows):
    """Frame, mullion and glazing bars in an opening of a wall; no glass."""
    x0, x1, z0, z1 = opening
    mid = THICK * 0.6
    parts = []
    for i in range(columns + 1):
        heavy = i in (0, columns // 2, columns)
        size = (0.075 if heavy else 0.024, 0.07 if heavy else 0.04, z1 - z0)
        parts.append(move(box(size), offset=(x0 + (x1 - x0) * i / columns, mid, z0)))
    for i in range(rows + 1):
        heavy = i in (0, rows)
        thick = 0.075 if heavy else 0.024
        size = (x1 - x0, 0.068 if heavy else 0.038, thick)
        z = z0 + (z1 - z0) * i / rows - thick / 2
        parts.append(move(box(size), offset=((x0 + x1) / 2, mid, z)))
    sill = move(box((x1 - x0 + 0.2, 0.2, 0.04)), offset=((x0 + x1) / 2, 0.0, z0 - 0.04))
    return join(*parts, sill)


def add_room(scene, plaster, trim, boards):
    """Floor boards, four walls with two windows, beamed ceiling, skirting."""
    depth, width = NORTH - SOUTH, EAST - WEST
    west = {"turn_deg": 90.0, "offset": (WEST, SOUTH, 0)}
    east = {"turn_deg": -90.0, "offset": (EAST, NORTH, 0)}
    view, fill = (1.75, 4.15, 0.62, 2.42), (1.6, 4.2, 0.7, 2.4)
    walls = join(
        move(wall_with_opening(depth, view), **west),
        move(wall_with_opening(depth, fill), **east),
        move(box((width, THICK, HEIGHT)), offset=((WEST + EAST) / 2, NORTH + THICK / 2, 0)),
        move(box((width, THICK, HEIGHT)), offset=((WEST + EAST) / 2, SOUTH - THICK / 2, 0)),
        move(
            box((width + 1, depth + 1, 0.2)),
            offset=((WEST + EAST) / 2, (SOUTH + NORTH) / 2, HEIGHT),
        ),
    )
    add_mesh(scene, "Walls", *walls, plaster, smooth=False)
    windows = join(move(casement(view, 6, 4), **west), move(casement(fill, 4, 4), **east))
    bevel(add_mesh(scene, "Windows", *windows, trim, smooth=False), 0.004, segments=2)
    skirting = move(box((width, 0.02, 0.13)), offset=((WEST + EAST) / 2, NORTH - 0.01, 0))
    west_skirting = move(box((0.02, depth, 0.13)), offset=(WEST + 0.01, (SOUTH + NORTH) / 2, 0))
    skirtings = add_mesh(scene, "Skirting", *join(skirting, west_skirting), trim, smooth=False)
    bevel(skirtings, 0.005, segments=2)
    beams = [move(box((0.16, depth, 0.17)), offset=(x, (SOUTH + NORTH) / 2, HEIGHT - 0.17))
             for x in (-1.3, -0.1, 1.1)]  # fmt: skip
    bevel(add_mesh(scene, "Beams", *join(*beams), boards[1], smooth=False), 0.012, segments=2)
    add_floor(scene, boards)


def add_floor(scene, materials):
    """Boards along y of three tones, with dark joints."""
    rng = np.random.default_rng(11)
    pitch = 0.155
    per_material = [[] for _ in materials]
    for x in np.arange(WEST - 0.1, EAST + 0.1, pitch):
        ends = np.sort(rng.uniform(SOUTH, NORTH, 2))
        for low, high in zip((SOUTH - 0.1, *ends), (*ends, NORTH + 0.1), strict=True):
            if high - low < 0.05:
                continue
            board = move(box((pitch - 0.004, high - low - 0.004, 0.02)),
                         offset=(x, (low + high) / 2, -0.02))  # fmt: skip
            per_material[rng.integers(len(materials))].append(board)
    for material, parts in zip(materials, per_material, strict=True):
        floor = add_mesh(scene, f"Floor, {material.name}", *join(*parts), material, smooth=False)
        bevel(floor, 0.003, segments=1)
    under = move(box((5.2, 5.6, 0.1)), offset=(0.1, -0.3, -0.125))
    add_mesh(scene, "Floor, below", *under, materials[1], smooth=False)


def add_table(scene, wood, location):
    """A farm table with turned legs."""
    x, y = 0.62, 0.38
    top = move(box((1.5, 0.92, 0.035)), offset=(0, 0, 0.715))
    aprons = [move(box((1.28, 0.022, 0.09)), offset=(0, s * (y - 0.01), 0.625)) for s in (-1, 1)]
    aprons += [move(box((0.022, 0.74, 0.09)), offset=(s * (x + 0.01), 0, 0.625)) for s in (-1, 1)]
    table = add_mesh(scene, "Table", *join(top, *aprons), wood, smooth=False, location=location)
    bevel(table, 0.006)
    profile = (
        (0.0, 0.715),
        (0.036, 0.715),
        (0.036, 0.60),
        (0.024, 0.585),
        (0.030, 0.56),
        (0.034, 0.45),
        (0.021, 0.12),
        (0.027, 0.10),
        (0.021, 0.08),
        (0.019, 0.0),
        (0.0, 0.0),
    )
    legs = [move(lathe(profile, 16), offset=(i * x, j * y, 0)) for i in (-1, 1) for j in (-1, 1)]
    legs = add_mesh(scene, "Table legs", *join(*legs), wood, location=location)
    bevel(legs, 0.002, angle_deg=50.0)


def add_chair(scene, wood, location, turn_deg):
    """A ladder-back chair."""
    parts = [move(box((0.44, 0.42, 0.03)), offset=(0, 0, 0.44))]
    for x in (-0.19, 0.19):
        parts.append(tube(((x, -0.18, 0.0), (x, -0.18, 0.44)), (0.016, 0.02), 10))
        back = ((x, 0.19, 0.0), (x, 0.18, 0.44), (x, 0.20, 0.75), (x, 0.245, 1.04))
        parts.append(tube(back, (0.016, 0.02, 0.018, 0.014), 10))
        parts.append(tube(((x, -0.18, 0.22), (x, 0.18, 0.22)), (0.011, 0.011), 8))
    for z, y in ((0.60, 0.188), (0.76, 0.202), (0.93, 0.228)):
        parts.append(move(box((0.37, 0.014, 0.065)), offset=(0, y, z)))
    parts.append(tube(((-0.19, -0.18, 0.26), (0.19, -0.18, 0.26)), (0.011, 0.011), 8))
    part = move(join(*parts), turn_deg=turn_deg)
    bevel(add_mesh(scene, "Chair", *part, wood, smooth=False, location=location), 0.004)


def add_still_life(scene, at, materials):
    """Jug, bowl of oranges, books: on the table's top, round the point `at`."""
    glaze, brass, orange, *covers, pages = materials

    def place(name, part, material, x, y, z=0.0, levels=2):
        spot = (at[0] + x, at[1] + y, at[2] + z)
        return subdivide(add_mesh(scene, name, *part, material, location=spot), levels)

    place("Jug", lathe(JUG, 20), glaze, -0.36, 0.16)
    handle = (
        (0.040, 0, 0.235),
        (0.085, 0, 0.245),
        (0.112, 0, 0.20),
        (0.105, 0, 0.14),
        (0.066, 0, 0.10),
    )
    place("Jug handle", move(tube(handle, [0.0095] * 5, 8), turn_deg=-35.0), glaze, -0.36, 0.16)
    place("Bowl", lathe(BOWL, 24), brass, 0.02, 0.03)
    spots = ((-0.05, 0.0, 0.026), (0.035, 0.042, 0.026), (0.03, -0.047, 0.026), (0.0, 0.0, 0.078),
             (0.22, -0.17, 0.0))  # fmt: skip
    for x, y, z in spots:
        place("Orange", lathe(FRUIT, 12), orange, 0.02 + x, 0.03 + y, z)
    z = at[2]
    books = ((0.24, 0.17, 0.038, 12.0), (0.22, 0.155, 0.028, -7.0), (0.19, 0.135, 0.03, 23.0))
    for cover, (length, width, height, turn) in zip(covers, books, strict=True):
        spot = (at[0] + 0.46, at[1] + 0.14, z)
        board, spine = box((length, width, 0.004)), box((length, 0.004, height))
        lid = move(board, offset=(0, 0, height - 0.004))
        sides = join(board, lid, move(spine, offset=(0, width / 2, 0)))
        add_mesh(scene, "Book", *move(sides, turn_deg=turn), cover, smooth=False, location=spot)
        block = move(box((length - 0.012, width - 0.008, height - 0.008)), offset=(0, 0, 0.004))
        add_mesh(scene, "Pages", *move(block, turn_deg=turn), pages, smooth=False, location=spot)
        z += height


def add_picture(scene, frame, canvas):
    """A framed canvas on the back wall."""
    x, z, w, h = -0.02, 1.32, 0.56, 0.72
    sides = [move(box((w + 0.1, 0.04, 0.05)), offset=(x, NORTH - 0.02, z + d)) for d in (-0.05, h)]
    sides += [move(box((0.05, 0.04, h)), offset=(x + d, NORTH - 0.02, z))
              for d in (-w / 2 - 0.025, w / 2 + 0.025)]  # fmt: skip
    bevel(add_mesh(scene, "Frame", *join(*sides), frame, smooth=False), 0.012)
    add_mesh(
        scene, "Canvas", *move(box((w, 0.01, h)), offset=(x, NORTH - 0.01, z)), canvas, smooth=False
    )


def add_plant(scene, location, clay, green):
    """A rubber plant in a clay pot: broad leaves before the window wall."""
    rng = np.random.default_rng(23)
    bevel(add_mesh(scene, "Pot", *lathe(POT, 40), clay, location=location), 0.004, angle_deg=25.0)
    parts = [tube(((0, 0, 0.28), (0.02, 0.01, 0.7), (0.0, 0.03, 1.28)), (0.014, 0.012, 0.005), 8)]
    for k in range(17):
        turn, height = math.radians(137.5 * k), 0.42 + 0.053 * k
        length = 0.30 * (1.0 - 0.025 * k) * rng.uniform(0.85, 1.1)
        rise = rng.uniform(0.25, 0.7)
        t = np.linspace(0, 1, 6)
        out, up = 0.05 + length * t, height + rise * length * t - 0.75 * length * t**2
        half = 0.30 * length * np.sin(np.pi * np.clip(t, 0.04, 0.985)) ** 0.75
        rows = [(o, s * h, u + 0.25 * abs(s) * h) for o, u, h in zip(out, up, half, strict=True)
                for s in (-1, 0, 1)]  # fmt: skip
        faces = [
            (3 * i + j, 3 * i + 3 + j, 3 * i + 4 + j, 3 * i + 1 + j)
            for i in range(5)
            for j in (0, 1)
        ]
        stalk = tube(((0, 0, height), (0.055, 0, up[0])), (0.005, 0.004), 5)
        parts.append(move(join((rows, faces), stalk), turn_deg=math.degrees(turn)))
    subdivide(add_mesh(scene, "Rubber plant", *join(*parts), green, location=location), 1)


def main(folder=FOLDER):
    """Build the scene and save it in `folder`."""
    scene = new_scene(size=(480, 320), exposure=2.1, look="AgX - Base Contrast")
    light_by_hdri(scene, "sunrise", azimuth_deg=108.0)
    oak = principled("Oak", (0.38, 0.22, 0.11), 0.38)
    walnut = principled("Walnut", (0.24, 0.125, 0.06), 0.36)
    ash = principled("Ash", (0.46, 0.30, 0.165), 0.4)
    plaster, trim = diffuse("Plaster", (0.66, 0.60, 0.50)), diffuse("Trim", (0.78, 0.77, 0.74))
    add_room(scene, plaster, trim, (oak, walnut, ash))
    table = (-0.62, 0.55, 0.0)
    add_table(scene, walnut, table)
    add_chair(scene, oak, (0.30, 0.78, 0.0), -72.0)
    materials = (
        principled("Blue glaze", (0.05, 0.13, 0.33), 0.2),
        principled("Brass", (0.85, 0.62, 0.28), 0.3, metallic=1.0),
        principled("Orange peel", (0.78, 0.25, 0.02), 0.42),
        diffuse("Green cloth", (0.05, 0.13, 0.085)),
        diffuse("Red cloth", (0.30, 0.04, 0.035)),
        diffuse("Ochre cloth", (0.45, 0.28, 0.07)),
        diffuse("Pages", (0.74, 0.69, 0.57)),
    )
    add_still_life(scene, (table[0], table[1], 0.75), materials)
    add_picture(scene, principled("Gilt", (0.83, 0.60, 0.27), 0.35, metallic=1.0),
                diffuse("Canvas", (0.10, 0.17, 0.20)))  # fmt: skip
    add_plant(scene, (0.95, 1.62, 0.0), diffuse("Clay", (0.42, 0.19, 0.10)),
              principled("Rubber leaf", (0.035, 0.12, 0.03), 0.28))  # fmt: skip
    add_camera(scene, location=(0.72, -1.55, 1.36), target=(-0.52, 0.95, 1.02), lens_mm=26)
    save("interior", folder)


if __name__ == "__main__":
    main(*sys.argv[1:])
