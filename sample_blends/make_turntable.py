"""Makes turntable.blend: an armillary sphere that turns, ten frames for one revolution.

    python sample_blends/make_turntable.py [FOLDER]

No mesh changes from frame to frame: the sphere, the globe and the two pointers turn as they are,
the stand, the horizon and the table stay. What a renderer prepares of them can be kept.
"""

import math
import sys

import bpy
import numpy as np
from common import FOLDER, add_camera, diffuse, glossy, light_by_hdri, new_scene, principled, save
from shapes import add_mesh, bevel, box, join, lathe, move, subdivide, tube

FRAMES = 10
CENTER = (0.0, 0.0, 0.335)  # of the sphere, metres
LATITUDE_DEG = 38.0  # the pole's height over the horizon

BASE = (
    (0.0, 0.075), (0.030, 0.075), (0.036, 0.068), (0.036, 0.060), (0.055, 0.046), (0.098, 0.036),
    (0.108, 0.028), (0.108, 0.020), (0.122, 0.014), (0.126, 0.0), (0.0, 0.0),
)  # fmt: skip
STEM = (
    (0.0, 0.128), (0.012, 0.128), (0.013, 0.118), (0.0085, 0.110), (0.0085, 0.100), (0.017, 0.092),
    (0.017, 0.086), (0.009, 0.078), (0.014, 0.074), (0.0, 0.074),
)  # fmt: skip


def band(radius, width, thickness, *, height=0.0, segments=96):
    """A flat ring round z: `width` along z, `thickness` along the radius."""
    inner, outer = radius - thickness / 2, radius + thickness / 2
    low, high = height - width / 2, height + width / 2
    return lathe(((inner, high), (outer, high), (outer, low), (inner, low)), segments, closed=True)


def turned_about_x(part, angle_deg):
    """(vertices, faces) turned about x."""
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    turn = np.array(((1, 0, 0), (0, c, s), (0, -s, c)))
    return list(np.asarray(part[0], float) @ turn), part[1]


def celestial_circles():
    """Equator, tropics, polar circles, two colures and the ecliptic, as one cage round z."""
    radius, tropic, polar = 0.150, math.radians(23.4), math.radians(66.6)
    parts = [band(radius, 0.0085, 0.0032)]
    for latitude in (tropic, -tropic, polar, -polar):
        height = radius * math.sin(latitude)
        parts.append(band(radius * math.cos(latitude), 0.0055, 0.0028, height=height))
    colure = turned_about_x(band(radius + 0.003, 0.006, 0.003), 90.0)
    parts += [colure, move(colure, turn_deg=90.0)]
    parts.append(turned_about_x(band(radius + 0.0065, 0.024, 0.0022), 23.4))
    rod = tube(((0, 0, -0.172), (0, 0, 0.172)), (0.0028, 0.0028), 12)
    return join(*parts, rod)


def horizon():
    """The broad horizontal ring with its marks of degrees, and the meridian ring in it."""
    parts = [band(0.186, 0.0045, 0.030)]
    for k in range(72):
        length = 0.012 if k % 6 == 0 else 0.006
        mark = move(box((length, 0.0012, 0.0012)), offset=(0.199 - length / 2, 0, 0.00225))
        parts.append(move(mark, turn_deg=k * 5.0))
    meridian = move(turned_about_x(band(0.1665, 0.007, 0.005), 90.0), turn_deg=90.0)
    return join(*parts, meridian)


def stand():
    """Four curved arms from the stem to the horizon ring."""
    t = np.linspace(0, 1, 12)
    angle = -0.5 * math.pi + 0.5 * math.pi * t
    path = np.stack((0.184 * np.cos(angle), 0 * t, 0.333 + 0.21 * np.sin(angle)), 1)
    arm = tube(path, 0.0052 + 0.0025 * np.cos(2 * math.pi * t), 10)
    return join(*(move(arm, turn_deg=45.0 + 90.0 * k) for k in range(4)))


def turn_forever(shape, start_deg, per_frame_deg):
    """Keys for a steady turn about the object's own z, from frame 1 on."""
    shape.rotation_mode = "XYZ"
    for frame in (1, FRAMES + 1):
        angle = start_deg + per_frame_deg * (frame - 1)
        shape.rotation_euler = (0.0, 0.0, math.radians(angle))
        shape.keyframe_insert("rotation_euler", index=2, frame=frame)
    for curve in shape.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"


def add_sphere(scene, brass, blue, red):
    """All that turns: cage, globe and pointers, on an axis that points to the pole."""
    axis = bpy.data.objects.new("Polar axis", None)
    axis.location = CENTER
    axis.rotation_euler = (0.0, math.radians(90.0 - LATITUDE_DEG), math.radians(28.0))
    axis.empty_display_size = 0.2
    scene.collection.objects.link(axis)
    cage = add_mesh(scene, "Celestial circles", *celestial_circles(), brass)
    bevel(cage, 0.0005, segments=2)
    ball = [(0.043 * math.sin(a), 0.043 * math.cos(a)) for a in np.linspace(0, math.pi, 9)]
    ball[0], ball[-1] = (0.0, 0.043), (0.0, -0.043)
    globe = subdivide(add_mesh(scene, "Globe", *lathe(ball, 16), blue), 2)
    belt = band(0.0437, 0.0035, 0.003, segments=64)
    meridian = turned_about_x(band(0.0437, 0.002, 0.003, segments=64), 90.0)
    mounts = bevel(
        add_mesh(scene, "Globe mounts", *join(belt, meridian), brass), 0.0004, segments=2
    )
    pointers = []
    for name, reach, size in (("Sun", 0.116, 0.0155), ("Moon", 0.080, 0.0095)):
        bead = [(size * math.sin(a), size * math.cos(a)) for a in np.linspace(0, math.pi, 9)]
        bead[0], bead[-1] = (0.0, size), (0.0, -size)
        part = move(lathe(bead, 16), offset=(reach, 0, 0))
        arm = tube(((0.0, 0, 0), (reach, 0, 0)), (0.0016, 0.0016), 8)
        material = red if name == "Sun" else brass
        pointers.append(subdivide(add_mesh(scene, name, *join(part, arm), material), 1))
    turns = ((cage, 0.0, 36.0), (globe, 20.0, -36.0), (mounts, 20.0, -36.0))
    turns += ((pointers[0], 205.0, 72.0), (pointers[1], 110.0, -108.0))
    for shape, start_deg, per_frame_deg in turns:
        shape.parent = axis
        turn_forever(shape, start_deg, per_frame_deg)


def main(folder=FOLDER):
    """Build the scene and save it in `folder`."""
    scene = new_scene(size=(320, 320), exposure=0.1, look="AgX - Medium High Contrast")
    scene.frame_start, scene.frame_end, scene.render.fps = 1, FRAMES, 10
    light_by_hdri(scene, "hall", azimuth_deg=235.0)
    brass = principled("Brass", (0.86, 0.62, 0.27), 0.3, metallic=1.0)
    walnut = principled("Walnut", (0.115, 0.052, 0.025), 0.3)
    blue = principled("Lapis enamel", (0.012, 0.05, 0.24), 0.18)
    red = glossy("Gilded sun", (0.95, 0.42, 0.10), 0.28)
    add_sphere(scene, brass, blue, red)
    ring = add_mesh(scene, "Horizon", *horizon(), brass, location=CENTER)
    bevel(ring, 0.0004, segments=2)
    add_mesh(scene, "Stand", *stand(), brass)
    bevel(add_mesh(scene, "Stem", *lathe(STEM, 32), brass), 0.0008, angle_deg=35.0)
    bevel(add_mesh(scene, "Base", *lathe(BASE, 64), walnut), 0.0015, angle_deg=35.0)
    cloth = lathe(((0.0, 0.0), (0.60, 0.0), (0.62, -0.01), (0.62, -0.4)), 96)
    table = add_mesh(scene, "Table", *cloth, diffuse("Green baize", (0.045, 0.085, 0.06)))
    bevel(table, 0.01, angle_deg=20.0)
    add_camera(scene, location=(0.25, -1.35, 0.58), target=(0.0, 0, 0.262), lens_mm=86)
    save("turntable", folder)


if __name__ == "__main__":
    main(*sys.argv[1:])
