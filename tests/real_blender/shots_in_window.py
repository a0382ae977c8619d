"""Run by Blender's window: the screenshots of docs/pictures, each of one editor.

blender STATUE.blend --python shots_in_window.py -- FOLDER
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import inside
import numpy as np

FOLDER = Path(inside.words()[0])


def shot(name: str, area):
    """A picture of the screen, and which part of it the area is: x, y from above, w, h."""
    yield 1.0
    yield from inside.screenshot(FOLDER / f"{name}.png")
    height = bpy.context.window_manager.windows[0].height
    x, y = area.x, height - area.y - area.height
    inside.say("CROP", FOLDER / f"{name}.png", x, y, area.width, area.height)


def final_render():
    """Until the job has ended; what the last render said is then there for the panels."""
    scene = bpy.context.window_manager.windows[0].scene
    scene.render.resolution_x, scene.render.resolution_y = 300, 400
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        bpy.ops.render.render(layer=scene.view_layers[0].name)
    yield 1.0


def spoil(scene):
    """Objects that IWIS cannot show as they are."""
    scene.collection.objects.link(bpy.data.objects.new("Smoke", bpy.data.volumes.new("Smoke")))
    for name in ("Cloth", "Silk"):
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([(0, 0, -3), (1, 0, -3), (0, 1, -3)], [], [(0, 1, 2)])
        material = bpy.data.materials.new(name)
        if bpy.app.version < (5, 0):
            material.use_nodes = True
        shader = material.node_tree.nodes["Principled BSDF"]
        shader.inputs["Transmission Weight"].default_value = 0.5
        mesh.materials.append(material)
        scene.collection.objects.link(bpy.data.objects.new(name, mesh))


def override(area):
    return bpy.context.temp_override(
        window=bpy.context.window_manager.windows[0],
        area=area,
        region=inside.view_window_region(area),
    )


def half_hidden_pixel() -> tuple[int, int]:
    """The pixel of the last render that sees nearest to half of its light."""
    name = next(m for m in sys.modules if m.endswith("iwis.iwis_addon.job"))
    film = next(iter(sys.modules[name].RenderJob.current.numbers.values()))
    far = np.abs(film.layers["visibility"] - 0.5)
    far[film.layers["samples"] < film.layers["samples"].max() / 2] = 1.0
    y, x = np.unravel_index(far.argmin(), far.shape)
    return int(x), int(y)


def main():
    scene, area = bpy.context.window_manager.windows[0].scene, inside.view_area()
    inside.show_rendered()
    view = area.spaces.active.region_3d
    view.view_perspective = "CAMERA"
    yield from inside.until(inside.converged, 900.0, "the rendered view")
    yield from shot("viewport", area)
    scene.iwis.viewport.overlay = "SAMPLES"
    yield from shot("viewport-samples", area)
    scene.iwis.viewport.overlay = "COMBINED"
    area.type = "PROPERTIES"
    area.spaces.active.context = "RENDER"
    yield from shot("render-properties", area)
    spoil(scene)
    yield from final_render()
    yield from shot("warnings", area)
    area.type = "IMAGE_EDITOR"
    with override(area):
        x, y = half_hidden_pixel()
        bpy.ops.iwis.inspect_pixel(x=x, y=y, height=256)
    yield 0.5
    with override(area):
        bpy.ops.image.view_all(fit_view=True)
    yield from shot("pixel-sampling", area)
    inside.say("END")


inside.run(main())
