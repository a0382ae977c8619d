"""Random scenes whose materials glow in the dark: values of nodes without any noise."""

from __future__ import annotations

import warnings as python_warnings
from pathlib import Path

import bpy
import numpy as np

from iwis.iwis_addon.job import RenderJob
from support.cycles_render import render_cycles
from support.iwis_render import render_iwis

from . import elements, materials, shapes
from .beside import Finding, unforeseen
from .dice import Dice

WIDTH, HEIGHT = 64, 48
# Of the mean: what a pixel may differ by; the share of pixels that may differ by more, for Cycles'
# rays are a hundredth of a pixel aside, and colours have edges.
LEAST, EDGES = 0.02, 0.02


def build(seed: int):
    """Replace the open file by a random scene that glows: (scene, what is in it)."""
    dice = Dice(seed, glows=True)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.render.resolution_percentage = 100
    bpy.ops.object.camera_add(location=(0.3, -6.0, 1.6), rotation=(1.344, 0.0, 0.05))
    scene.camera = bpy.context.object
    scene.camera.data.lens = 45.0
    scene.world = bpy.data.worlds.new("W")
    scene.world.color = (0.0, 0.0, 0.0)
    if scene.world.node_tree is not None:
        scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.0, 0.0, 0.0, 1.0)
    chosen = [materials.material(dice) for _ in range(3)]
    shapes.add_floor(dice, materials.material(dice))
    for _ in range(dice.whole(2, 4)):
        obj = shapes.add_object(dice, [dice.of(*chosen) for _ in range(dice.of(1, 2))])
    if dice.chance(0.5):
        shapes.add_copies(dice, obj)
    if dice.chance(0.5):
        elements.add_elements(dice)
    bpy.context.view_layer.update()
    return scene, dice.told


def compare(scene, folder: Path) -> Finding:
    """One ray a pixel, through its middle; edges that the two see otherwise are left out."""
    own = scene.iwis
    own.pixel_filter, own.max_samples, own.stop_rule = "CENTER", 1, "FIXED"
    layers = render_iwis(scene, folder)
    ours = next(v for k, v in layers.items() if k.endswith("Combined"))
    warnings = RenderJob.get().records[-1].stats.warnings
    with python_warnings.catch_warnings():
        python_warnings.simplefilter("ignore")
        cycles = render_cycles(scene, folder, ())["Combined"]
    a, b = ours[..., :3], cycles[..., :3]
    scale = max(float(np.abs(b).mean()), 1e-4)
    far = ~(np.abs(a - b).max(-1) <= LEAST * (scale + np.abs(b).max(-1)))
    inner = ~far if far.mean() <= EDGES else np.ones_like(far)
    return Finding(
        bias=float(a[inner].mean() - b[inner].mean()) / scale,
        error=0.0,
        difference=float(far.mean()) if far.mean() > EDGES else 0.0,
        alpha=0.0,
        warnings=unforeseen(warnings),
        ours=ours,
        cycles=cycles,
    )
