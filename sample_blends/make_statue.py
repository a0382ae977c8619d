"""Makes statue.blend: a robed stone figure on a lotus, as the paper's Buddha a self-occluding one.

    python sample_blends/make_statue.py [FOLDER]

The head sees nearly the whole sky, the pleats of the robe and the feet below its hem nearly none
of it: where the light is blocked, a renderer that counts visible samples has to take more.
"""

import sys

import numpy as np
from common import FOLDER, add_camera, diffuse, light_by_hdri, new_scene, save
from implicit import carve, ellipsoid, limb, melt, mesh_of, mirrored, noise
from shapes import add_mesh, bevel, box, subdivide

STEP = 0.0110  # metres; Catmull-Clark halves it when the file is opened
NECK = np.float32((0.0, 0.0, 1.56))
HEAD_SCALE = np.float32(1.1)


def head(points):
    """Face, ears, hair and the bun on top; bowed a little."""
    bow = np.float32(np.deg2rad(9.0))
    x, y, z = (points - NECK).T / HEAD_SCALE
    y, z = y * np.cos(bow) + z * np.sin(bow), z * np.cos(bow) - y * np.sin(bow)
    p = np.stack((x, y, z), 1) + NECK
    solid = ellipsoid(p, (0, 0.005, 1.765), (0.094, 0.112, 0.128))
    solid = melt(solid, ellipsoid(p, (0, -0.03, 1.695), (0.066, 0.074, 0.082)), 0.05)
    solid = melt(solid, mirrored(face)(p), 0.014)
    solid = melt(solid, limb(p, (0, -0.112, 1.782), (0, -0.132, 1.722), 0.009, 0.0155), 0.016)
    solid = melt(solid, ellipsoid(p, (0, -0.1, 1.683), (0.026, 0.014, 0.010)), 0.012)
    hair = ellipsoid(p, (0, 0.026, 1.79), (0.108, 0.112, 0.124))
    curls = np.sin(p[:, 0] * 190) * np.sin(p[:, 1] * 190) * np.sin(p[:, 2] * 190)
    above_hairline = p[:, 2] - 1.80 + 0.62 * p[:, 1] + 0.02
    hair = np.maximum(hair - 0.004 * curls, -above_hairline)
    bun = ellipsoid(p, (0, 0.04, 1.925), (0.052, 0.052, 0.046)) - 0.003 * curls
    return melt(melt(solid, hair, 0.008), bun, 0.03) * HEAD_SCALE


def face(p):
    """Brow, eyelid and ear of one side; p[:, 0] >= 0."""
    brow = limb(p, (0.012, -0.106, 1.79), (0.066, -0.078, 1.79), 0.011, 0.008)
    lid = ellipsoid(p, (0.036, -0.088, 1.757), (0.023, 0.017, 0.0115))
    cheek = ellipsoid(p, (0.042, -0.068, 1.712), (0.032, 0.03, 0.03))
    ear = ellipsoid(p, (0.097, 0.012, 1.735), (0.013, 0.026, 0.062))
    return np.minimum(melt(melt(brow, lid, 0.006), cheek, 0.02), ear)


def robe(points):
    """The long robe: pleats that deepen from the waist to the hem, and swags across the chest."""
    x, y, z = points.T
    heights = (0.22, 0.30, 0.60, 0.95, 1.12, 1.32, 1.46, 1.53, 1.58)
    width = np.interp(z, heights, (0.335, 0.320, 0.265, 0.220, 0.200, 0.226, 0.215, 0.130, 0.060))
    depth = np.interp(z, heights, (0.250, 0.240, 0.205, 0.170, 0.150, 0.165, 0.135, 0.090, 0.060))
    angle = np.arctan2(y / depth, x / width)
    low = np.clip((1.10 - z) / 0.85, 0.0, 1.0)
    sweep = 0.55 * np.sin(2.2 * z) + 0.18 * np.sin(5.0 * z + 2 * angle)
    pleats = 0.5 + 0.5 * np.cos(17 * (angle + sweep * low) + 1.3 * np.sin(2 * angle))
    fold = 0.085 * low**0.8 * pleats
    from_shoulder = np.sqrt((x - 0.26) ** 2 + (z - 1.60) ** 2)
    swag = 0.5 + 0.5 * np.cos(from_shoulder * (2 * np.pi / 0.062) + 1.5 * np.sin(9 * x))
    front = np.clip((0.02 - y) / 0.08, 0, 1) * np.clip((z - 1.02) / 0.12, 0, 1)
    front *= np.clip((1.50 - z) / 0.06, 0, 1)
    fold += 0.020 * front * swag
    rho = np.sqrt((x / width) ** 2 + (y / depth) ** 2)
    wall = (rho - 1.0) * np.minimum(width, depth) + fold
    return np.maximum(np.maximum(wall * 0.8, 0.235 - z), z - 1.585)


def arms(p):
    """Upper arm, forearm and the sleeve that hangs from it; the hands meet before the chest."""
    solid = limb(p, (0.190, 0.01, 1.43), (0.265, 0.01, 1.17), 0.070, 0.078)
    solid = melt(solid, limb(p, (0.265, 0.01, 1.17), (0.055, -0.205, 1.245), 0.078, 0.050), 0.05)
    x, y, z = p.T
    hang = np.clip((1.2 - z) / 0.45, 0, 1)
    folds = 0.026 * hang * np.cos(95 * (x * 0.75 - y * 0.65) + 6 * z)
    sleeve = ellipsoid(p, (0.225, -0.085, 0.97), (0.090, 0.125, 0.32)) + folds
    return melt(solid, np.maximum(sleeve, 0.74 - z), 0.06)


def hands(p):
    """Palm and fingers of one side."""
    palm = limb(p, (0.030, -0.215, 1.255), (0.021, -0.236, 1.335), 0.030, 0.026)
    fingers = limb(p, (0.016, -0.240, 1.34), (0.009, -0.236, 1.43), 0.021, 0.011)
    thumb = limb(p, (0.022, -0.205, 1.30), (0.010, -0.205, 1.36), 0.014, 0.010)
    return melt(melt(palm, fingers, 0.02), thumb, 0.008)


def feet(p):
    """A foot with its toes, under the hem."""
    foot = limb(p, (0.085, -0.02, 0.215), (0.110, -0.235, 0.190), 0.055, 0.030)
    for toe in range(5):
        x = 0.075 + 0.018 * toe
        tip = limb(p, (x, -0.225, 0.186), (x + 0.006, -0.272 + 0.007 * toe, 0.18), 0.014, 0.0125)
        foot = melt(foot, tip, 0.008)
    return melt(foot, limb(p, (0.085, 0.0, 0.2), (0.09, 0.0, 0.5), 0.05, 0.06), 0.04)


def lotus(points):
    """Two rings of petals, the upper one opening, the lower one hanging, and the seat on them."""
    seat = ellipsoid(points, (0, 0, 0.135), (0.34, 0.34, 0.032))
    upper = _petals(points, count=14, lean=0.75, radius=0.325, height=0.10, turn=0.0)
    lower = _petals(points, count=14, lean=-0.75, radius=0.335, height=0.055, turn=0.5)
    base = np.maximum(np.hypot(points[:, 0], points[:, 1]) - 0.33, np.abs(points[:, 2]) - 0.02)
    solid = melt(melt(seat, upper, 0.008), lower, 0.006)
    core = np.maximum(
        np.hypot(points[:, 0], points[:, 1]) - 0.28, np.abs(points[:, 2] - 0.07) - 0.07
    )
    return melt(melt(solid, base, 0.008), core, 0.01)


def _petals(points, *, count, lean, radius, height, turn):
    x, y, z = points.T
    sector = np.float32(2 * np.pi / count)
    angle = np.arctan2(y, x) / sector + turn
    angle = (angle - np.round(angle)) * sector
    out = np.hypot(x, y)
    across, along, up = out * np.sin(angle), out * np.cos(angle) - radius, z - height
    along, up = along * np.cos(lean) - up * np.sin(lean), up * np.cos(lean) + along * np.sin(lean)
    petal = np.stack((along, across * (1.0 + 3.0 * np.maximum(up, -0.03)), up), 1)
    return ellipsoid(petal, (0, 0, 0), (0.022, 0.070, 0.090))


def figure(points):
    """The whole statue."""
    solid = melt(robe(points), mirrored(arms)(points), 0.030)
    solid = melt(solid, limb(points, (0, 0.01, 1.5), (0, 0, 1.70), 0.062, 0.052), 0.05)
    solid = np.minimum(solid, head(points))
    solid = melt(solid, mirrored(hands)(points), 0.010)
    inside_hem = ellipsoid(points, (0, 0, 0.235), (0.215, 0.165, 0.09))
    solid = melt(carve(solid, inside_hem, 0.02), mirrored(feet)(points), 0.008)
    hewn = 0.0022 * noise(points, 0.031) + 0.0014 * noise(points, 0.017, seed=1)
    return np.minimum(solid, lotus(points)) + hewn


def add_figure(scene, stone):
    """The statue's mesh; a Subdivision modifier smooths it when the file is opened."""
    vertices, faces = mesh_of(figure, (-0.46, -0.44, -0.04), (0.46, 0.44, 2.02), STEP)
    vertices = np.round(vertices * 4096) / 4096  # a quarter of a millimetre; packs better
    subdivide(add_mesh(scene, "Figure", vertices, faces, stone, location=(0, 0, 1.52)), 1)


def main(folder=FOLDER):
    """Build the scene and save it in `folder`."""
    scene = new_scene(size=(200, 400), exposure=0.15, look="AgX - Medium High Contrast")
    light_by_hdri(scene, "sunset", azimuth_deg=52.0)
    stone = diffuse("Limestone", (0.58, 0.53, 0.46))
    add_figure(scene, stone)
    dark = diffuse("Basalt", (0.12, 0.12, 0.125))
    bevel(add_mesh(scene, "Plinth", *box((0.92, 0.92, 1.5)), dark, smooth=False), 0.02)
    add_camera(scene, location=(1.1, -5.4, 1.9), target=(0, 0, 2.42), lens_mm=80)
    save("statue", folder)


if __name__ == "__main__":
    main(*sys.argv[1:])
