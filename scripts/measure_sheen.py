"""Measure the sheen of Cycles' Sheen BSDF (Microfiber): writes core/bsdf/sheen_numbers.py.

    python scripts/measure_sheen.py

Sheen is a cosine lobe under a linear map of directions [Heitz16, Zeltner22]: with wo in the plane
of x and z,

    f cos_i = R / pi z (a / l)^2,   l = (a x + b z)^2 + (a y)^2 + z^2,   wi = (x, y, z)

Along y = 0, 1 / (z^2 sqrt(pi f)) is a parabola of x / z whose three coefficients give a, b and R:
a sun at a few angles, which has no noise, is all that is needed. A plane is rendered whose
roughness goes from left to right, seen from one angle after another.
"""

from __future__ import annotations

import math
import sys
import tempfile
import textwrap
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from support.cycles_render import render_cycles

N_ROUGH = N_COS = 32
SUNS = np.radians([-75.0, -60.0, -35.0, 0.0, 35.0, 60.0, 75.0])  # towards +x, wo is there


# A table's rows are even in the root of the cosine: sheen changes most where one looks along it.
ROUGHNESSES = np.linspace(0.0, 1.0, N_ROUGH)
COSINES = np.maximum(np.linspace(0.0, 1.0, N_COS) ** 2, 1e-3)


def build():
    """The scene: a square of which a pixel each has its roughness; returns camera and sun."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.world = None
    scene.render.resolution_x, scene.render.resolution_y = N_ROUGH, 4  # the least
    scene.cycles.light_sampling_threshold = 0.0
    scene.view_settings.view_transform = "Standard"
    bpy.ops.mesh.primitive_plane_add(size=2.0)
    bpy.context.object.scale.y = 1e3  # seen from the side, it is as high as a pixel still
    material = bpy.data.materials.new("M")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    bpy.context.object.data.materials.append(material)
    tree = material.node_tree
    tree.nodes.clear()
    image = bpy.data.images.new("R", N_ROUGH, 1, float_buffer=True, is_data=True)
    image.pixels[:] = np.repeat(ROUGHNESSES, 4).tolist()
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image, texture.interpolation = image, "Closest"
    sheen, output = (
        tree.nodes.new("ShaderNodeBsdfSheen"),
        tree.nodes.new("ShaderNodeOutputMaterial"),
    )
    sheen.distribution = "MICROFIBER"
    sheen.inputs["Color"].default_value = (1.0,) * 4
    tree.links.new(texture.outputs["Color"], sheen.inputs["Roughness"])
    tree.links.new(sheen.outputs[0], output.inputs["Surface"])
    camera = bpy.data.objects.new("C", bpy.data.cameras.new("C"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2.0
    camera.data.clip_end = 1e5
    sun = bpy.data.objects.new("S", bpy.data.lights.new("S", "SUN"))
    sun.data.energy, sun.data.angle = math.pi, 0.0  # irradiance pi across the beam
    for obj in (camera, sun):
        scene.collection.objects.link(obj)
    scene.camera = camera
    return scene, camera, sun


def measured() -> np.ndarray:
    """float64 (N_COS, N_ROUGH, 3): a, b and R."""
    scene, camera, sun = build()
    out, misfit = np.zeros((N_COS, N_ROUGH, 3)), np.zeros((N_COS, N_ROUGH))
    with tempfile.TemporaryDirectory() as folder:
        for row, cosine in enumerate(COSINES):
            # The picture's x is the roughness, along world x; wo leans towards +y.
            angle = math.acos(cosine)
            camera.location = (0.0, 1e3 * math.sin(angle), 1e3 * cosine)
            camera.rotation_euler = (-angle, 0.0, 0.0)
            slopes, values = [], []
            for tilt in SUNS:
                sun.rotation_euler = (-tilt, 0.0, 0.0)
                light = render_cycles(scene, Path(folder), ())["Combined"][2, :, 0]
                slopes.append(math.tan(tilt))
                values.append(light)
            s, f = np.array(slopes), np.array(values, np.float64) / math.pi
            z = np.cos(SUNS)[:, None]
            parabola = 1.0 / (z**2 * np.sqrt(math.pi * f / z))
            seen = (f > 1e-12).all(axis=0)
            # Relative errors count: each value by its own size.
            for column in np.flatnonzero(seen):
                own = parabola[:, column]
                c2, c1, c0 = np.polyfit(s, own, 2, w=1.0 / own)
                rest = np.abs(np.polyval([c2, c1, c0], s) / own - 1.0).max()
                k2 = c0 * c2 - c1**2 / 4.0
                k = math.sqrt(max(k2, 1e-30))
                out[row, column] = c2 / k, c1 / (2.0 * k), 1.0 / k2
                misfit[row, column] = rest
            print(
                f"{cosine:.4f}: dark {(~seen).sum()}, misfit {misfit[row].max():.1e}",
                file=sys.stderr,
            )
    return out


def filled(table: np.ndarray) -> np.ndarray:
    """The same, a and b where nothing is reflected as they are nearby."""
    for row in table:
        lit = np.flatnonzero(row[:, 2] > 1e-9)
        for k in range(2):
            row[:, k] = np.interp(np.arange(N_ROUGH), lit, row[lit, k])
    return table


def lines_of(table: np.ndarray) -> list[str]:
    """The numbers in ten-thousandths, as text of at most 98 characters a line."""
    lines = []
    for k in range(3):
        for row in np.rint(table[..., k] * 1e4).astype(int):
            lines += textwrap.wrap(" ".join(map(str, row)), 98)
    return lines


if __name__ == "__main__":
    path = Path(__file__).resolve().parents[1] / "core" / "sheen_numbers.py"
    head = path.read_text().split('NUMBERS = """')[0]
    text = "\n".join(lines_of(filled(measured())))
    path.write_text(f'{head}NUMBERS = """\n{text}\n"""\n')
