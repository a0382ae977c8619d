"""The rendered view's own object, asked as Blender asks it, while its shading menu is used."""

from types import SimpleNamespace

import bpy
import pytest

from iwis.iwis_addon.viewport import Viewport
from support.view_space import view_space

SIZE = 16, 12


class Engine:
    """What of Blender's engine object a view uses."""

    def get_preview_pixel_size(self, _scene):
        return 1

    def tag_redraw(self):
        pass

    def update_stats(self, *_texts):
        pass


class View:
    """A region's Viewport, without a screen; space: its settings."""

    def __init__(self, scene, space=None):
        camera, graph = scene.camera, bpy.context.evaluated_depsgraph_get()
        self.space = space or view_space()
        self._context = SimpleNamespace(
            region=SimpleNamespace(width=SIZE[0], height=SIZE[1], as_pointer=lambda: 1),
            region_data=SimpleNamespace(
                window_matrix=camera.calc_matrix_camera(graph, x=SIZE[0], y=SIZE[1]),
                view_matrix=camera.matrix_world.normalized().inverted(),
                view_perspective="PERSP",
            ),
            space_data=self.space,
        )
        self.engine = Engine()
        self.viewport = Viewport(self.engine)
        self.viewport._drawing = SimpleNamespace(draw=lambda *_rest: None)
        self.viewport.thread.close()  # what it is given is looked at here, not rendered
        self.viewport.update(self._context, graph)

    @property
    def scene(self):
        return self.viewport._scene

    def draw(self):
        """The scene that is rendered after a redraw, and whether the picture began anew."""
        before = self.viewport.restarts
        self.viewport.draw(self._context, bpy.context.evaluated_depsgraph_get())
        assert not self.viewport.failure
        return self.scene, self.viewport.restarts > before


@pytest.fixture
def view(cube_scene):
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    lamp.location = 0.0, 0.0, 5.0
    cube_scene.collection.objects.link(lamp)
    bpy.context.view_layer.update()
    view = View(cube_scene)
    yield view
    view.viewport.close()


def test_lamps_and_world_are_left_out_at_the_next_redraw(view):
    """And come back; the meshes stay the very same all the while."""
    world, mesh = view.scene.environment, view.scene.mesh
    shading = view.space.shading
    assert len(view.scene.lamps.kind) == 1 and view.draw() == (view.scene, False)
    shading.use_scene_lights_render = False
    scene, anew = view.draw()
    assert anew and not len(scene.lamps.kind) and scene.environment is world
    shading.use_scene_world_render = False
    scene, anew = view.draw()
    assert anew and scene.environment.name == shading.selected_studio_light.name
    turned = scene.environment.world_to_map
    shading.studiolight_rotate_z = 1.0
    scene, anew = view.draw()
    assert anew and (scene.environment.world_to_map != turned).any()
    shading.use_scene_lights_render = shading.use_scene_world_render = True
    scene, anew = view.draw()
    assert anew and len(scene.lamps.kind) == 1 and scene.environment is world
    assert scene.mesh is mesh


def test_a_pass_is_shown_at_the_next_redraw(view):
    """One in false color begins nothing anew: the window has it."""
    view.space.shading.iwis.render_pass = "UV"
    scene, anew = view.draw()
    assert anew and scene.asked.shown == "uv" and scene.asked.uv is not None
    view.space.shading.iwis.render_pass = "COMBINED"
    assert view.draw()[0].asked.shown == ""
    view.space.shading.iwis.render_pass = "SAMPLES"
    scene, anew = view.draw()
    assert not anew and scene.asked.shown == ""


def test_passes_keep_their_noise(view):
    """The denoiser is for Combined; it is on again with it."""
    own = bpy.context.scene.iwis.viewport
    own.denoise = True
    denoiser, shading = view.viewport.thread.denoiser, view.space.shading
    view.draw()
    assert denoiser.denoising.settings.denoise
    shading.iwis.render_pass = "DIFFUSE_DIRECT"
    view.draw()
    assert not denoiser.denoising.settings.denoise
    shading.iwis.render_pass = "COMBINED"
    view.draw()
    assert denoiser.denoising.settings.denoise


def test_two_views_have_their_own(view):
    """Of one scene, one with its lamps, the other a pass without them."""
    spaces = [area.spaces[0] for screen in bpy.data.screens for area in screen.areas]
    other = next(space for space in spaces if space.type == "VIEW_3D" and space != view.space)
    other.shading.type = "RENDERED"
    other.shading.use_scene_lights_render = False
    other.shading.iwis.render_pass = "NORMAL"
    second = View(bpy.context.scene, other)
    try:
        assert second.scene.asked.shown == "normal" and not len(second.scene.lamps.kind)
        assert view.draw()[1] is False
        assert view.scene.asked.shown == "" and len(view.scene.lamps.kind) == 1
    finally:
        second.viewport.close()
