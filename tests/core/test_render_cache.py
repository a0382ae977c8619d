"""core/render_cache.py: what is the same is kept, what changed is not."""

import dataclasses

import numpy as np

from iwis.core.render_cache import RenderCache
from iwis.core.scene import CLOSEST, MIRROR_BALL
from support.scenes import box, floor, gradient_world, make_mesh


def _light(cache, world):
    return cache.light(world, 1, lambda: False)


def test_the_same_mesh_keeps_its_hierarchy():
    """By identity: the exporter hands on the same table while nothing moved."""
    cache, mesh, other = RenderCache(), make_mesh(floor()), make_mesh(floor())
    accel = cache.accel(mesh)
    assert cache.accel(mesh) is accel
    assert cache.accel(other) is not accel
    assert cache.accel(mesh) is not accel  # one is kept, not all


def test_an_equal_world_keeps_its_light():
    """By value: each frame exports the world anew."""
    cache = RenderCache()
    light = _light(cache, gradient_world())
    assert _light(cache, gradient_world()) is light
    assert _light(cache, gradient_world(visible_to_camera=False, name="other")) is light


def test_any_change_of_the_world_makes_new_light():
    """One texel, rotation, strength, projection, interpolation."""
    world = gradient_world()
    radiance = world.radiance.copy()
    radiance[3, 4, 1] += 1.0
    turned = np.float32([[0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0]])
    for change in (
        {"radiance": radiance},
        {"world_to_map": turned},
        {"strength": np.float32([1.0, 1.0, 1.1])},
        {"projection": MIRROR_BALL},
        {"interpolation": CLOSEST},
    ):
        cache = RenderCache()
        light = _light(cache, world)
        assert _light(cache, dataclasses.replace(world, **change)) is not light


def test_a_failed_hierarchy_is_not_kept():
    """The old mesh is forgotten before the new one is built; both work afterwards."""
    cache = RenderCache()
    for mesh in (make_mesh(floor()), make_mesh(box((0, 0, 0), (1, 1, 1)))):
        assert cache.accel(mesh).mesh is mesh
