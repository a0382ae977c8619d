"""core/render_cache.py: what is the same is kept, what changed is not."""

import dataclasses

import numpy as np

import iwis.core.render_cache as render_cache_module
from iwis.core.render_cache import RenderCache
from iwis.core.scene import CLOSEST, MIRROR_BALL
from support.scenes import box, floor, gradient_world, make_mesh


def _light(cache, world):
    return cache.light(world)


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


def test_a_brighter_world_keeps_its_tree(monkeypatch):
    """Only the averages are scaled; the new strength is what is looked up."""
    cache = RenderCache()
    light = _light(cache, gradient_world())
    monkeypatch.setattr(render_cache_module, "build_pyramid", None)  # would raise
    brighter = _light(cache, gradient_world(strength=np.float32([3.0, 3.0, 3.0])))
    assert brighter.pyramid.children is light.pyramid.children
    np.testing.assert_allclose(brighter.pyramid.averages, 3.0 * light.pyramid.averages, rtol=1e-6)
    np.testing.assert_allclose(brighter.cells.light, 3.0 * light.cells.light, rtol=1e-6)
    assert brighter.lookup.strength.tolist() == [3.0, 3.0, 3.0]
    np.testing.assert_array_equal(
        _light(cache, gradient_world()).pyramid.averages, light.pyramid.averages
    )


def test_another_process_finds_the_light_on_disk(tmp_path, monkeypatch):
    """By the pixels; another strength finds the same file. Nothing on disk where none is wanted."""
    folder = tmp_path / "tables"
    light = RenderCache().light(gradient_world(), str(tmp_path))
    assert len(list(folder.iterdir())) == 1
    monkeypatch.setattr(render_cache_module, "build_pyramid", None)  # would raise
    for strength in (1.0, 5.0):
        world = gradient_world(strength=np.full(3, strength, np.float32))
        again = RenderCache().light(world, str(tmp_path))
        np.testing.assert_allclose(
            again.pyramid.averages, strength * light.pyramid.averages, rtol=1e-6
        )
    assert len(list(folder.iterdir())) == 1
    monkeypatch.undo()
    _light(RenderCache(), gradient_world(32))
    assert len(list(folder.iterdir())) == 1


def test_a_cache_folder_that_cannot_be_used_is_a_warning(tmp_path):
    """The light is built all the same; the next render out of memory warns no more."""
    (tmp_path / "tables").write_text("a file")
    cache = RenderCache()
    light = cache.light(gradient_world(), str(tmp_path))
    assert len(cache.light_warnings) == 1 and "cannot keep tables" in cache.light_warnings[0]
    assert cache.light(gradient_world(), str(tmp_path)) is light and cache.light_warnings == []
