"""Meshes that shine, and what lamps and they throw on shadow catchers."""

import bpy
import numpy as np

from .cases import lit_by
from .lamp_cases import ABOVE, BALL, SIDE, add_lamp, matte, shiny
from .scene import Tree, picture


def _glow(color, strength):
    return lambda t: t.made("ShaderNodeEmission", 0, {"Color": color, "Strength": strength})


def glowing(make):
    """A material of a shader make(tree), which shines."""
    return material_of("Glow", make)


def material_of(name, make):
    """A material of a shader make(tree)."""
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    tree = Tree(material.node_tree)
    tree.surface(make(tree))
    return material


_EVEN = _glow((1.0, 0.7, 0.3), 8.0)


def glowing_plane(scene):
    """A square that shines, above the cube."""
    bpy.ops.mesh.primitive_plane_add(size=1.0, location=(1.0, -1.0, 2.5))
    bpy.context.object.data.materials.append(glowing(_EVEN))
    return bpy.context.object


def _emitter(name, add, make=matte, world=False, copies=1, glow=_EVEN, sampling="AUTO", **options):
    """add(k): makes the mesh object k in Blender; glow(tree): its shader"""

    def build(scene, tree):
        material = glowing(glow)
        material.cycles.emission_sampling = sampling
        for k in range(copies):
            add(k)
            bpy.context.object.data.materials.append(material)
        tree.surface(make(tree))

    lit_by(name, build, world=world, **options)


def _plane(_):
    bpy.ops.mesh.primitive_plane_add(size=1.2, location=SIDE, rotation=(0.6, -0.9, 0.3))


def _ball(_):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=0.4, location=ABOVE)


def _tiny(_):
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.05, location=(0.2, -1.2, 0.6))


def _row(k):
    place = (-2.5 + 0.25 * k, -1.5, 1.6 + 0.1 * (k % 3))
    bpy.ops.mesh.primitive_cube_add(size=0.12, location=place, rotation=(0.2 * k, 0.1, 0.3 * k))


def _near(_):
    bpy.ops.mesh.primitive_cube_add(size=0.22, location=(0.78, -1.19, -0.14))


def _turned(_):
    bpy.ops.mesh.primitive_cube_add(size=0.6, location=(-0.5, 0.5, 0.6), rotation=(0.7, 0.5, 0.2))


def _behind(_):
    """A plane that shines, unseen, and before it a coarse smooth head, lit along its rim."""
    bpy.ops.mesh.primitive_monkey_add(size=1.9, location=(0.3, -1.2, 0.5))
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(bpy.data.objects["Plane"].data.materials[0])
    bpy.ops.mesh.primitive_plane_add(size=0.8, location=(1.3, 0.6, 2.0), rotation=(2.2, 0.3, 0))
    bpy.context.object.visible_camera = False


_emitter("Emissive plane behind a head, coarse and smooth", _behind)
_emitter("Emissive cube, near a cube", _near)
_emitter("Emissive cube, turned, between all", _turned)
_emitter("Emissive plane", _plane)
_emitter("Emissive plane, sampling NONE", _plane, sampling="NONE", samples=(64, 8192))
_emitter("Emissive sphere of 2208 triangles", _ball)
_emitter("Emissive sphere, tiny", _tiny)
_emitter("Emissive cubes, twenty", _row, copies=20)
_emitter("Emissive sphere under a world", _ball, shiny(0.4), world=True)


def _lantern(tree):
    """It shines, and lets the light of its own inside through."""
    paper = tree.made("ShaderNodeBsdfTranslucent", 0, {"Color": (0.8, 0.7, 0.5)})
    glow = tree.made("ShaderNodeEmission", 0, {"Color": (1.0, 0.7, 0.3), "Strength": 1.0})
    return tree.made("ShaderNodeAddShader", 0, {0: paper, 1: glow})


_emitter("Emissive cube, translucent, between all", _turned, glow=_lantern)


def _half_clear(tree):
    """It shines, and half of all rays go through."""
    clear = tree.made("ShaderNodeBsdfTransparent", 0, {})
    return tree.made("ShaderNodeMixShader", 0, {0: 0.5, 1: clear, 2: _EVEN(tree)})


# What is beside them, or mirrors them, sees their far sides through the near ones.
_emitter("Emissive cube, half clear, between all", _turned, glow=_half_clear, blurred=True)
_emitter("Emissive sphere, half clear, roughness 0.15", _ball, shiny(0.15), glow=_half_clear)
for _roughness in (0.05, 0.15, 0.3):
    _made = shiny(_roughness, Metallic=0.5)
    _emitter(f"Emissive plane, roughness {_roughness}", _plane, _made)


def _black_and_white(name="Black and white", size=8):
    """A packed image of a sharp pattern: uneven stripes, and a few lone texels."""
    image = bpy.data.images.new(name, size, size)
    rows, columns = np.mgrid[0:size, 0:size]
    pixels = np.zeros((size, size, 4), np.float32)
    pixels[..., :3] = (columns < size / 4)[..., None]
    pixels[rows + columns == 9] = 1.0
    pixels[..., 3] = 1.0
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def _sharp(tree):
    """Emission by a sharp pattern."""
    uv = tree.coordinates("UV")
    image = _black_and_white()
    color = tree.made("ShaderNodeTexImage", 0, {0: uv}, image=image, interpolation="Closest")
    return tree.made("ShaderNodeEmission", 0, {"Color": color, "Strength": 20.0})


def _half_glow(tree):
    """A paint that a noise mixes with a picture that glows."""
    color = tree.made("ShaderNodeTexImage", 0, {0: tree.coordinates("UV")}, image=picture())
    glow = tree.made("ShaderNodeEmission", 0, {"Color": color, "Strength": 15.0})
    noise = tree.made("ShaderNodeTexNoise", 0, {"Vector": tree.coordinates(), "Scale": 4.0})
    paint = tree.made("ShaderNodeBsdfPrincipled", 0, {"Base Color": (0.3, 0.5, 0.2)})
    return tree.made("ShaderNodeMixShader", 0, {0: noise, 1: paint, 2: glow})


def _one_sided(tree):
    """It glows at its back alone, by a picture."""
    color = tree.made("ShaderNodeTexImage", 0, {0: tree.coordinates("UV")}, image=picture())
    back = tree.made("ShaderNodeNewGeometry", "Backfacing")
    strength = tree.made("ShaderNodeMath", 0, {0: back, 1: 12.0}, operation="MULTIPLY")
    return tree.made("ShaderNodeEmission", 0, {"Color": color, "Strength": strength})


def _not_for_the_camera(tree):
    """A red light that the camera sees as a dim blue."""
    seen = tree.made("ShaderNodeLightPath", "Is Camera Ray")
    node = tree.node("ShaderNodeMix", data_type="RGBA")
    tree.link(seen, node.inputs[0])
    node.inputs[6].default_value = (9.0, 2.0, 1.0, 1.0)
    node.inputs[7].default_value = (0.1, 0.1, 0.4, 1.0)
    return tree.made("ShaderNodeEmission", 0, {"Color": node.outputs[2], "Strength": 1.0})


def _low_plane(_):
    """Upright on the floor, close to the sphere."""
    bpy.ops.mesh.primitive_plane_add(size=1.6, location=(0.2, -0.9, -0.25), rotation=(1.57, 0, 0.3))


def _fine_ball(_):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=320, ring_count=160, radius=0.5, location=ABOVE)


_emitter("Emissive image, sharp, near", _low_plane, glow=_sharp)
_emitter("Emissive image, sharp, near, roughness 0.15", _low_plane, shiny(0.15), glow=_sharp)
_FINE = {"glow": _sharp, "samples": (64, 4096)}  # Cycles has nine times the noise of IWIS
_emitter("Emissive image, sharp, on 101 760 faces", _fine_ball, **_FINE)
_emitter("Emissive image mixed with paint by noise", _low_plane, glow=_half_glow)
_emitter("Emissive image on the back alone", _plane, glow=_one_sided)
_emitter("Emissive, not to the camera", _plane, glow=_not_for_the_camera)


def _caught(name, add, transparent, make=None):
    """The floor is a shadow catcher; add(scene): what throws shadows on it; make(tree): its shader,
    None: that of all"""

    def build(scene, tree):
        add(scene)
        floor = scene.objects["Plane"]
        floor.is_shadow_catcher = True
        if make is not None:
            floor.data.materials[0] = material_of("Catcher", make)
        scene.render.film_transparent = transparent
        tree.surface(matte(tree))

    lit_by(name, build, world=True, with_alpha=transparent)


def _bright_ball(scene):
    add_lamp(scene, "POINT", ABOVE, **BALL | {"energy": 900.0})


def _bright_sun(scene):
    add_lamp(scene, "SUN", SIDE, energy=4.0, angle=0.05)


def _bright_plane(scene):
    _plane(0)
    bpy.context.object.name = "Light"
    bpy.context.object.data.materials.append(glowing(_glow((1.0, 0.9, 0.8), 20.0)))


_caught("Shadow catcher, world alone", lambda scene: None, False)
_caught("Shadow catcher, point", _bright_ball, False)
_caught("Shadow catcher, sun, transparent film", _bright_sun, True)
_caught("Shadow catcher, emissive plane, transparent film", _bright_plane, True)


def _translucent(tree):
    return tree.made("ShaderNodeBsdfTranslucent", 0, {"Color": (0.7, 0.6, 0.5)})


def _both_sides(tree):
    inputs = {0: 0.5, 1: matte(tree), 2: _translucent(tree)}
    return tree.made("ShaderNodeMixShader", 0, inputs)


def _from_below(scene):
    add_lamp(scene, "POINT", (0.5, -1.0, -2.5), (0, 0, 0), **BALL | {"energy": 900.0})


_caught("Shadow catcher, translucent, world alone", lambda scene: None, False, _translucent)
_caught("Shadow catcher, translucent, point behind", _from_below, True, _translucent)
_caught("Shadow catcher, half translucent, point behind", _from_below, False, _both_sides)
_caught("Shadow catcher, half translucent, sun", _bright_sun, True, _both_sides)
