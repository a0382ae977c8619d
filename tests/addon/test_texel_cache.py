"""An animation reads an HDRI once, and never renders an older one."""

import os

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export import ExportCache
from iwis.iwis_addon.export.images import texel_cache
from iwis.iwis_addon.export.worlds.world import read_world
from support.world_render import add, new_image, new_world, save_image, some_texels, textured_world


class Reader:
    """Exports the world with one cache, and counts how often texels are read."""

    def __init__(self, monkeypatch):
        self.cache = ExportCache().texels
        self.reads = 0
        real = texel_cache.read_texels

        def counted(*arguments):
            self.reads += 1
            return real(*arguments)

        monkeypatch.setattr(texel_cache, "read_texels", counted)

    def __call__(self):
        """The radiance, which must be what an export without a cache gives."""
        warnings, fresh_warnings = [], []
        depsgraph = bpy.context.evaluated_depsgraph_get()
        environment = read_world(depsgraph, warnings, self.cache).light
        reads = self.reads
        fresh = read_world(depsgraph, fresh_warnings).light
        self.reads = reads
        np.testing.assert_array_equal(environment.radiance, fresh.radiance)
        assert warnings == fresh_warnings
        return environment.radiance


@pytest.fixture
def tree(scene):
    return new_world(scene)


@pytest.fixture
def texels(rng):
    return some_texels(rng)


@pytest.fixture
def reader(monkeypatch):
    return Reader(monkeypatch)


def saved(texels, path):
    """A file as a .blend opened in background has it: not loaded yet."""
    return save_image(texels, path, "OPEN_EXR", "32")


def generated(texels, _path):
    return bpy.data.images.new("grid", 16, 8)


def packed(texels, path):
    image = saved(texels, path)
    image.pack()
    return image


@pytest.mark.parametrize("make", [saved, packed, generated])
def test_unchanged_image_is_read_once(scene, tree, texels, reader, tmp_path, make):
    """The radiance is the very same array, whatever happens to rotation, strength and frame."""
    _, background = textured_world(tree, make(texels, tmp_path / "map.exr"))
    first = reader()
    for frame in (2, 3):
        scene.frame_set(frame)
        background.inputs["Strength"].default_value = frame
        assert reader() is first
    assert reader.reads == 1


def test_mended_radiance_is_the_same_array(tree, texels, reader, tmp_path):
    """Of a map with NaN as well, and its warning comes with each frame."""
    texels[1, 1] = np.nan
    textured_world(tree, saved(texels, tmp_path / "map.exr"))
    assert reader() is reader()


def test_colour_nodes_are_evaluated_in_each_frame(tree, texels, reader, tmp_path):
    """Equal radiance is the same array; another value of a node gives another one."""
    texture, background = textured_world(tree, saved(texels, tmp_path / "map.exr"))
    gamma = add(tree, "Gamma", Gamma=2.0)
    tree.links.new(texture.outputs[0], gamma.inputs["Color"])
    tree.links.new(gamma.outputs[0], background.inputs["Color"])
    first = reader()
    assert reader() is first
    gamma.inputs["Gamma"].default_value = 1.5
    assert (reader() != first).any()
    assert reader.reads == 1


def paint(image, texels, path):
    image.pixels[0] = 9.0


def paint_and_save(image, texels, path):
    image.pixels[0] = 9.0
    image.save()


def recolour(image, texels, path):
    image.colorspace_settings.name = "sRGB"


def overwrite_and_reload(image, texels, path):
    _overwrite(texels, path)
    image.reload()


def overwrite_and_reload_later(image, texels, path):
    """A frame is rendered while Blender still has the old texels of the new file."""
    _overwrite(texels, path)
    bpy.context.scene.frame_set(7)
    yield
    image.reload()


def choose_another_file(image, texels, path):
    other = path.with_name("other.exr")
    bpy.data.images.remove(saved(texels[::-1], other))
    image.filepath = str(other)


def _overwrite(texels, path):
    """Another picture of the same size and time."""
    state = os.stat(path)
    new = path.with_name("new.exr")
    bpy.data.images.remove(saved(texels[::-1], new))
    os.utime(new, ns=(state.st_atime_ns, state.st_mtime_ns))
    os.replace(new, path)


@pytest.mark.parametrize("loaded_before", [False, True])
@pytest.mark.parametrize(("kind", "depth"), [("OPEN_EXR", "32"), ("PNG", "8")])
def test_file_that_changes_on_disk_is_read_anew(tree, texels, tmp_path, kind, depth, loaded_before):
    """As Cycles does, though nobody has Blender reload it; by the same job and by another."""
    path, other = tmp_path / "map.file", tmp_path / "other.file"
    image = save_image(texels, path, kind, depth)
    textured_world(tree, image)
    if loaded_before:
        assert image.pixels[0] > 0.0
    graph, cache = bpy.context.evaluated_depsgraph_get(), ExportCache().texels
    first = read_world(graph, [], cache).light.radiance
    assert image.has_data == loaded_before
    for k in (1, 2):
        bpy.data.images.remove(save_image(np.roll(texels, k, 1), other, kind, depth))
        os.replace(other, path)
        for own in (cache, ExportCache().texels):
            now = read_world(graph, [], own).light.radiance
            np.testing.assert_array_equal(now, np.roll(first, k, 1))


@pytest.mark.parametrize(
    "change",
    [
        paint,
        paint_and_save,
        recolour,
        overwrite_and_reload,
        overwrite_and_reload_later,
        choose_another_file,
    ],
    ids=lambda change: change.__name__,
)
@pytest.mark.parametrize("loaded_before", [False, True])
def test_every_change_is_seen(tree, texels, reader, tmp_path, change, loaded_before):
    """What the cache gives equals what is there now (the reader compares), and differs."""
    image = saved(texels, tmp_path / "map.exr")
    textured_world(tree, image)
    if loaded_before:
        assert image.pixels[0] > 0.0
    first = reader()
    steps = change(image, texels, tmp_path / "map.exr")
    for _ in steps or ():
        reader()
    assert (reader() != first).any()
    assert reader() is not first


def test_only_the_last_frame_is_kept(tree, texels, reader, tmp_path):
    """A sequence does not fill the memory: back at a frame, its file is read again."""
    for frame in (1, 2):
        bpy.data.images.remove(saved(texels * frame, tmp_path / f"s{frame}.exr"))
    image = bpy.data.images.load(str(tmp_path / "s1.exr"))
    image.source = "SEQUENCE"
    texture, _ = textured_world(tree, image)
    user = texture.image_user
    user.frame_duration, user.frame_start, user.use_auto_refresh = 2, 1, True
    for frame, reads in ((1, 1), (1, 1), (2, 2), (1, 3)):
        bpy.context.scene.frame_set(frame)
        assert reader().max() == pytest.approx(texels.max() * frame)
        assert reader.reads == reads


def test_painted_image_is_read_in_each_frame(tree, texels, reader):
    """Nothing tells whether it has been painted again; equal texels are the same array."""
    textured_world(tree, new_image(texels))
    assert reader() is reader()
    assert reader.reads == 2
