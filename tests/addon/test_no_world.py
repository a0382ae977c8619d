"""A scene without a world: what its settings would say is what Cycles takes for them."""

import bpy
import numpy as np
import pytest

from iwis.core.exr import read_exr_layers
from support.cycles_render import use_cycles
from support.iwis_render import by_pass, render_iwis


@pytest.mark.slow
def test_mist_and_occlusion_without_a_world_are_those_of_cycles(cube_scene, tmp_path):
    """Planes to 40 m away show where mist begins and how it grows; ceilings 8.5 and 11 m above the
    floor how far occlusion looks."""
    scene, layer = cube_scene, cube_scene.view_layers[0]
    scene.world = None
    for k in range(12):
        bpy.ops.mesh.primitive_plane_add(size=1.2, location=(1.2 * k - 6.6, 0.0, 40.0 - 3.0 * k))
    for height in (8.5, 11.0):  # ceilings over half of the floor each, one nearer than 10 m
        bpy.ops.mesh.primitive_plane_add(size=40.0, location=(height, 0.0, height))
        bpy.context.object.location.y = 20.0 if height < 10.0 else -20.0
        bpy.context.object.visible_camera = False
    scene.camera.location, scene.camera.rotation_euler = (0.0, 0.0, 45.0), (0.0, 0.0, 0.0)
    scene.camera.data.lens, scene.camera.data.clip_end = 30.0, 100.0
    layer.use_pass_mist = layer.use_pass_ambient_occlusion = True
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    scene.iwis.stop_rule, scene.iwis.max_samples = "FIXED", 256
    ours = by_pass(render_iwis(scene, tmp_path))
    use_cycles(scene, samples=256, filter_width=1.5)
    scene.render.filepath = str(tmp_path / "cycles.exr")
    bpy.ops.render.render(write_still=True)
    theirs = by_pass(read_exr_layers(tmp_path / "cycles.exr"))
    for name in ("Mist", "Ambient Occlusion" if "Ambient Occlusion" in theirs else "AO"):
        own, other = ours[name], theirs[name]
        assert other.std() > 0.1  # it shows something
        shown = (other > 0.05) & (other < 0.95)
        # 32 rays a pixel against Cycles' 256, hundreds of pixels: a tenth of the tolerance.
        assert np.median(own[shown] / other[shown]) == pytest.approx(1.0, abs=0.02)
        assert own.mean() == pytest.approx(other.mean(), rel=0.01)
