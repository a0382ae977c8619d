"""The Vector pass beside Cycles', and what is read for it."""

import functools

import bpy
import numpy as np
import pytest

from iwis.core.exr import read_exr_layers
from iwis.iwis_addon.export import export_scene
from iwis.iwis_addon.export.motion.pixel_motion import export_with_vectors, wants_vectors
from support.compositor import sockets_by_engine
from support.cycles_render import use_cycles
from support.frames import engine_of
from support.iwis_render import by_pass, render_iwis


def _keyed(owner, **values):
    """Keys of properties at frames 4, 5 and 6."""
    for name, three in values.items():
        for frame, value in zip((4, 5, 6), three, strict=True):
            setattr(owner, name, value)
            owner.keyframe_insert(name, frame=frame)


@pytest.fixture
def moving(cube_scene):
    """A cube that moves and turns, a plane whose key bends it, an instancer that turns, a cone that
    motion blur leaves out, before a camera that stands; at frame 5."""
    scene = cube_scene
    cube = bpy.data.objects["Cube"]
    _keyed(
        cube,
        location=((0.0, 0.0, 0.5), (0.2, 0.1, 0.5), (0.6, 0.0, 0.5)),
        rotation_euler=((0.0, 0.0, -0.1), (0.0, 0.0, 0.0), (0.0, 0.0, 0.3)),
    )
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=8, y_subdivisions=8, size=0.9)
    bent = bpy.context.object
    bent.location = (-1.2, -0.8, 0.4)
    bent.shape_key_add(name="Basis")
    key = bent.shape_key_add(name="Bent")
    for corner in key.data:
        corner.co.z += corner.co.x**2
    _keyed(key, value=(0.0, 0.4, 1.0))
    bpy.ops.mesh.primitive_cone_add(radius1=0.3, depth=0.8, location=(1.3, -1.0, 0.4))
    cone = bpy.context.object
    cone.cycles.use_motion_blur = False
    _keyed(cone, location=((1.2, -1.0, 0.4), (1.3, -1.0, 0.4), (1.3, -0.8, 0.4)))
    copies = bpy.data.collections.new("Copies")
    bpy.ops.mesh.primitive_cube_add(size=0.4, location=(0.5, 0.0, 0.0))
    small = bpy.context.object
    scene.collection.objects.unlink(small)
    copies.objects.link(small)
    maker = bpy.data.objects.new("Maker", None)
    maker.instance_type, maker.instance_collection = "COLLECTION", copies
    maker.location = (-1.0, 1.0, 0.3)
    scene.collection.objects.link(maker)
    _keyed(maker, rotation_euler=((0.0, 0.0, 0.0), (0.0, 0.0, 0.2), (0.0, 0.0, 0.5)))
    scene.frame_set(5)
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    scene.view_layers[0].use_pass_vector = True
    scene.iwis.stop_rule, scene.iwis.max_samples = "FIXED", 16
    scene.iwis.filter_width = 0.01
    return scene


def both(scene, folder):
    """The pass of IWIS and of Cycles, at the pixels' centres, and which of these see an object."""
    scene.view_layers[0].use_pass_z = True
    layers = by_pass(render_iwis(scene, folder))
    use_cycles(scene, samples=4, filter_width=0.01)
    scene.render.filepath = str(folder / "cycles.exr")
    bpy.ops.render.render(write_still=True)
    theirs = by_pass(read_exr_layers(folder / "cycles.exr"))["Vector"]
    return layers["Vector"], theirs, layers["Depth"][..., 0] < 1e9


def test_vectors_are_those_of_cycles(moving, tmp_path):
    """But for pixels that an edge crosses within a hundredth of a pixel of their centre."""
    ours, theirs, _ = both(moving, tmp_path)
    off = np.abs(ours - theirs).max(axis=-1)
    assert (off > 0.01).mean() < 0.003
    assert np.ptp(theirs, axis=(0, 1)).min() > 1.0
    assert moving.frame_current == 5 and moving.frame_subframe == 0.0


def test_a_panning_panorama_moves_the_world(moving, tmp_path):
    """Its background too, as in Cycles of Blender 5; that of 4.5 has another one there."""
    camera = moving.camera
    camera.data.type = "PANO"
    owner = camera.data if hasattr(camera.data, "panorama_type") else camera.data.cycles
    owner.panorama_type = "FISHEYE_EQUIDISTANT"
    x, y, z = camera.rotation_euler
    _keyed(camera, rotation_euler=((x, y, z - 0.02), (x, y, z), (x, y, z + 0.05)))
    moving.frame_set(5)
    ours, theirs, hit = both(moving, tmp_path)
    off = np.abs(ours - theirs).max(axis=-1)
    assert (off[hit] > 0.02).mean() < 0.01
    assert bpy.app.version < (5, 0) or (off > 0.02).mean() < 0.01
    assert (np.abs(ours).max(axis=-1) > 0.1).mean() > 0.7  # within the fisheye's circle


def test_with_motion_blur_there_are_none(moving, tmp_path):
    """0, as in Cycles."""
    moving.render.use_motion_blur = True
    assert not wants_vectors(bpy.context.evaluated_depsgraph_get())
    ours, theirs, _ = both(moving, tmp_path)
    assert not ours.any() and not theirs.any()


def test_sockets_are_those_of_cycles(cube_scene):
    """Vector, of four channels."""
    cube_scene.view_layers[0].use_pass_vector = True
    found = sockets_by_engine(cube_scene)
    assert found["IWIS"]["Vector"] == found["CYCLES"]["Vector"] == "VECTOR"


def exported(scene):
    graph = bpy.context.evaluated_depsgraph_get()
    export = functools.partial(export_scene, graph, warnings=[])
    return export_with_vectors(engine_of(scene), graph, [], export).pixel_motion


def test_what_stands_has_no_row(moving):
    """Of the floor; of the four that move, a matrix a frame before and later."""
    motion = exported(moving)
    assert (motion.row < 0).sum() == 2  # the floor, and the grid, which keeps its place
    assert motion.matrices.shape == (2, 3, 4, 4)
    (shapes,) = motion.shapes
    assert len(shapes.positions) == 3
    np.testing.assert_allclose(motion.camera_moves, np.tile(np.eye(4), (2, 1, 1)), atol=1e-6)


def test_what_is_not_there_at_other_times_stands(moving):
    """An object that is hidden a frame before or later."""
    cube = bpy.data.objects["Cube"]
    _keyed(cube, hide_render=(True, False, True))
    moving.frame_set(5)
    motion = exported(moving)
    assert np.isfinite(motion.matrices).all()


def test_no_pass_reads_no_other_frame(moving):
    """A render without it goes to no other frame for it."""
    moving.view_layers[0].use_pass_vector = False
    assert not wants_vectors(bpy.context.evaluated_depsgraph_get())
