"""The Ambient Occlusion node: its options, what is in its way, and what it drives.

Each sample has noise of its own in both engines, so there is the usual filter.
"""

import bpy

from .cases import CASES, Case
from .clear_cases import new_material
from .movers import move_and_turn


def _case(name, build, **options):
    CASES.append(Case(f"Ambient Occlusion{name}", build, blurred=True, filter_width=1.5, **options))


def _occlusion(tree, output="AO", inputs=None, **options):
    return tree.made("ShaderNodeAmbientOcclusion", output, inputs, **options)


def _shown(name, *own, **options):
    """Of an output as light, of a node with these inputs and options."""
    _case(name, lambda scene, tree: tree.glow(_occlusion(tree, *own, **options)))


_shown("")
_shown(", Color", "Color", {"Color": (0.8, 0.4, 0.1)})
_shown(", one sample", samples=1)
_shown(", 0.3 m", "AO", {"Distance": 0.3})
_shown(", inside", "AO", {"Distance": 0.5}, inside=True)
_shown(", only local", only_local=True)
_shown(", only local, inside", "AO", {"Distance": 1.5}, only_local=True, inside=True)


def _as_far_as_the_world_says(scene, tree):
    scene.world.light_settings.distance = 0.6
    tree.glow(_occlusion(tree, "AO", {"Distance": 0.0}))


def _varying_distance(scene, tree):
    tree.glow(_occlusion(tree, "AO", {"Distance": tree.axis("X", -0.5, 2.0)}))


def _other_normal(scene, tree):
    """Round the sphere most rays go into it."""
    inputs = {"Color": (0.5, 0.5, 1.0)}
    up = tree.made("ShaderNodeNormalMap", 0, inputs, space="WORLD")
    tree.glow(_occlusion(tree, "AO", {"Normal": up, "Distance": 3.0}))


def _bumpy_normal(scene, tree):
    waves = {"Vector": tree.coordinates(), "Scale": 1.5}
    height = tree.made("ShaderNodeTexWave", "Fac", waves)
    bump = tree.made("ShaderNodeBump", 0, {"Height": height, "Distance": 0.2})
    tree.glow(_occlusion(tree, "AO", {"Normal": bump}))


def _displaced(scene, tree):
    """Displacement turns the normal that it looks along."""
    height = tree.made("ShaderNodeTexWave", "Fac", {"Vector": tree.coordinates(), "Scale": 1.5})
    inputs = {"Height": height, "Scale": 0.2}
    tree.link(tree.made("ShaderNodeDisplacement", 0, inputs), tree.output.inputs["Displacement"])
    tree.glow(_occlusion(tree))


def _coarse_and_smooth(scene, tree):
    for obj in scene.objects:
        if obj.type == "MESH":
            obj.data.shade_smooth()
    tree.glow(_occlusion(tree))


_case(", as far as the world says", _as_far_as_the_world_says)
_case(", a distance that varies", _varying_distance)
_case(", another normal", _other_normal)
_case(", a bumpy normal", _bumpy_normal)
_case(", a displaced surface", _displaced)
_case(", coarse and smooth", _coarse_and_smooth)


def _beneath(change):
    """Above the floor a card that change(card) makes special."""

    def build(scene, tree):
        tree.glow(_occlusion(tree))
        bpy.ops.mesh.primitive_plane_add(size=1.5, location=(0.1, -1.2, -0.6))
        bpy.context.object.data.materials.append(bpy.data.materials["M"])
        change(bpy.context.object)

    return build


def _clear(card):
    card.data.materials[0] = new_material(
        lambda tree: tree.made("ShaderNodeBsdfTransparent", 0, {})
    )


def _without_shadow(card):
    card.visible_shadow = False


def _hidden(card):
    card.visible_camera = False


_case(" under a clear card", _beneath(_clear))
_case(" under a card without shadow", _beneath(_without_shadow))
_case(" under a card hidden from the camera", _beneath(_hidden))


def _two_instances(scene, tree):
    """Each is an object of its own: only local knows nothing of the other."""
    tree.glow(_occlusion(tree, only_local=True, inputs={"Distance": 2.0}))
    cube = scene.objects["Cube"]
    other = cube.copy()
    other.location.x -= 1.1
    scene.collection.objects.link(other)


_case(", only local, of two objects of one mesh", _two_instances)


def _dirt(scene, tree):
    """A ramp of it mixes two shaders: what is near to something is dark and matte."""
    ramp = tree.node("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[1].position = 0.4, 0.9
    tree.link(_occlusion(tree, inputs={"Distance": 0.7}), ramp.inputs[0])
    mix = tree.node("ShaderNodeMixShader")
    tree.link(ramp.outputs[0], mix.inputs[0])
    dark = tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.12, 0.07, 0.03)})
    clean = tree.made(
        "ShaderNodeBsdfPrincipled", 0, {"Base Color": (0.8, 0.7, 0.5), "Roughness": 0.4}
    )
    tree.link(dark, mix.inputs[1])
    tree.link(clean, mix.inputs[2])
    tree.surface(mix.outputs[0])


def _threshold(scene, tree):
    """Whether all of eight rays are free: the noise of each point counts."""
    above = {0: _occlusion(tree, samples=8), 1: 0.9}
    tree.glow(tree.made("ShaderNodeMath", 0, above, operation="GREATER_THAN"))


def _color(scene, tree):
    color = _occlusion(tree, "Color", {"Color": (0.8, 0.6, 0.5)})
    tree.surface(tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": color}))


def _bump(scene, tree):
    """Its height is the same a step aside: nothing is bumpy, as in Cycles."""
    normal = tree.made("ShaderNodeBump", 0, {"Height": _occlusion(tree), "Distance": 1.0})
    tree.surface(tree.made("ShaderNodeBsdfDiffuse", 0, {"Normal": normal}))


_case(" as a mask of dirt", _dirt, lit=True)
_case(" above a threshold", _threshold)
_case(" as color", _color, lit=True)
_case(" as bump", _bump, lit=True)


def _clear_cube(scene, tree):
    """Clear where it is open, for the camera; its shadow is that of what is open everywhere."""
    tree.surface(tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.7, 0.7, 0.7)}))

    def make(own):
        mix = own.node("ShaderNodeMixShader")
        own.link(_occlusion(own, inputs={"Distance": 1.5}), mix.inputs[0])
        own.link(own.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.8, 0.3, 0.1)}), mix.inputs[1])
        own.link(own.made("ShaderNodeBsdfTransparent", 0, {}), mix.inputs[2])
        return mix.outputs[0]

    scene.objects["Cube"].data.materials[0] = new_material(make)


def _lamp(scene, tree):
    """A cube that glows where it is open lights the rest as if it were open all over."""
    tree.surface(tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.7, 0.7, 0.7)}))

    def make(own):
        share = _occlusion(own, inputs={"Distance": 1.0})
        return own.made("ShaderNodeEmission", 0, {"Color": share, "Strength": 2.0})

    scene.objects["Cube"].data.materials[0] = new_material(make)


def _clear_cube_under_a_sun(scene, tree):
    """Which no BSDF sample finds: light samples alone say what its shadow is."""
    _clear_cube(scene, tree)
    bpy.ops.object.light_add(type="SUN", rotation=(0.6, -0.5, 0.0))
    bpy.context.object.data.energy, bpy.context.object.data.angle = 3.0, 0.0


_case(" as alpha", _clear_cube, lit=True)
_case(" as alpha, under a sun", _clear_cube_under_a_sun, by_lamps=True)
_case(" as light of a cube", _lamp, by_lamps=True)


def _moving(scene, tree):
    """A cube falls on the floor and turns."""
    tree.glow(_occlusion(tree))
    move_and_turn(scene.objects["Cube"])
    for obj in scene.objects:
        obj.cycles.motion_steps = 3
    scene.frame_set(1)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0


_case(" beside what moves", _moving)


def _written(scene, tree):
    """By an AOV node in a matte material, of which the picture shows nothing."""
    _color(scene, tree)
    aov = tree.node("ShaderNodeOutputAOV")
    aov.aov_name = "open"
    tree.link(_occlusion(tree), aov.inputs["Value"])


_case(" beside an AOV", _written, lit=True)
