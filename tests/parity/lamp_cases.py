"""Lamps: each kind and setting alone, over the materials that show what is wrong with it."""

import math

import bpy
import numpy as np

from .cases import lit_by
from .scene import Tree, picture


def _lamp(scene, kind, location, target=(0.0, 0.0, -0.4), scale=(1.0, 1.0, 1.0), **settings):
    """A light that shines on a target. settings: of the light, and visible_... of its object"""
    import mathutils

    light = bpy.data.lights.new("Lamp", kind)
    obj = bpy.data.objects.new("Lamp", light)
    for name, value in settings.items():
        setattr(obj if name.startswith("visible") else light, name, value)
    away = mathutils.Vector(location) - mathutils.Vector(target)
    obj.location, obj.scale = location, scale
    obj.rotation_euler = away.to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(obj)
    return light


def _diffuse(tree):
    return tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.7, 0.6, 0.5)})


def _principled(roughness, **inputs):
    values = {"Base Color": (0.6, 0.3, 0.2), "Roughness": roughness} | inputs
    return lambda tree: tree.made("ShaderNodeBsdfPrincipled", 0, values)


def _case(name, kind, location, make=_diffuse, world=False, also=None, **options):
    """also: arguments of a second lamp"""

    def build(scene, tree):
        _lamp(scene, kind, location, **options)
        if also is not None:
            _lamp(scene, *also[:2], **also[2])
        tree.surface(make(tree))

    lit_by(name, build, world=world)


_ABOVE, _SIDE = (1.5, -2.0, 3.0), (-2.5, -2.0, 1.5)
_POINT, _AREA = {"energy": 300.0}, {"energy": 200.0, "visible_camera": False}
_BALL = _POINT | {"shadow_soft_size": 0.4, "visible_camera": False}
_SPOT = {"energy": 600.0, "spot_size": math.radians(40.0), "visible_camera": False}

_case("Point", "POINT", _ABOVE, **_POINT)
_case("Point, not normalized", "POINT", _ABOVE, normalize=False, **_POINT)


def _with_blackbody(name):
    def build(scene, tree):
        lamp = _lamp(scene, "POINT", _ABOVE, **_POINT)
        if bpy.app.version < (5, 0):
            lamp.use_nodes = True
        light = Tree(lamp.node_tree, "ShaderNodeOutputLight")
        color = light.made("ShaderNodeBlackbody", 0, {0: 3200.0})
        light.surface(light.made("ShaderNodeEmission", 0, {"Color": color, "Strength": 1.0}))
        tree.surface(_diffuse(tree))

    lit_by(name, build)


_with_blackbody("Point, a black body")
_case("Point, radius", "POINT", _ABOVE, use_soft_falloff=False, **_BALL)
_case("Point, radius, not normalized", "POINT", _ABOVE, normalize=False, **_BALL)
_case("Point, soft falloff", "POINT", _ABOVE, use_soft_falloff=True, **_BALL)
_case("Point, soft falloff, near", "POINT", (0.2, -0.4, 0.1), use_soft_falloff=True, **_BALL)
_case("Point, scaled", "POINT", _ABOVE, scale=(3.0, 2.0, 0.5), **_BALL)
_case("Point, no shadow", "POINT", _SIDE, use_shadow=False, **_BALL)
_case("Point, coloured, exposed", "POINT", _SIDE, color=(1.0, 0.4, 0.1), exposure=-0.7, **_POINT)
_case("Point, temperature", "POINT", _ABOVE, use_temperature=True, temperature=3200.0, **_POINT)
_case("Point, factors of EEVEE", "POINT", _ABOVE, _principled(0.3), specular_factor=0.2, **_BALL)
_case("Point, not for glossy", "POINT", _ABOVE, _principled(0.3), visible_glossy=False, **_BALL)
_case("Point, not for diffuse", "POINT", _ABOVE, _principled(0.3), visible_diffuse=False, **_BALL)
for _blend in (0.0, 0.15, 1.0):
    _case(f"Spot, blend {_blend}", "SPOT", _ABOVE, spot_blend=_blend, **_SPOT)
_case("Spot, radius", "SPOT", _ABOVE, spot_blend=0.5, shadow_soft_size=0.5, **_SPOT)
_case("Spot, scaled", "SPOT", _ABOVE, spot_blend=0.5, scale=(1.6, 0.7, 1.0), **_SPOT)
_case(
    "Spot, radius, hard falloff",
    "SPOT",
    _ABOVE,
    spot_blend=0.5,
    shadow_soft_size=0.5,
    use_soft_falloff=False,
    **_SPOT,
)
for _degrees in (0.0, 5.0, 40.0):
    _case(f"Sun, {_degrees:.0f} degrees", "SUN", _SIDE, energy=3.0, angle=math.radians(_degrees))
_case("Sun, not normalized", "SUN", _SIDE, energy=3.0, angle=0.3, normalize=False)
_SIZES = {
    "SQUARE": {"size": 1.2},
    "RECTANGLE": {"size": 2.5, "size_y": 0.4},
    "DISK": {"size": 1.2},
    "ELLIPSE": {"size": 2.0, "size_y": 0.7},
}
for _shape, _size in _SIZES.items():
    _case(f"Area {_shape}", "AREA", _ABOVE, shape=_shape, **_size, **_AREA)
    for _spread in (5.0, 60.0):
        _case(
            f"Area {_shape}, spread {_spread:.0f}",
            "AREA",
            _ABOVE,
            shape=_shape,
            spread=math.radians(_spread),
            **_size,
            **_AREA,
        )
_case("Area, spread 0", "AREA", _ABOVE, size=1.7, spread=0.0, **_AREA)
_case("Area, not normalized", "AREA", _ABOVE, size=1.2, normalize=False, **_AREA)
_case("Area, scaled", "AREA", _ABOVE, size=1.0, scale=(2.0, 0.5, 3.0), **_AREA)
_case("Area, no shadow", "AREA", _SIDE, size=1.2, use_shadow=False, **_AREA)
_case("Area, near the floor", "AREA", (0.0, -0.6, -0.8), size=0.6, target=(0, 3, -1.4), **_AREA)
for _roughness in (0.05, 0.15, 0.3, 1.0):
    _case(
        f"Area, roughness {_roughness}",
        "AREA",
        _SIDE,
        _principled(_roughness, Metallic=0.5),
        size=1.5,
        **_AREA,
    )
    _case(f"Sun, roughness {_roughness}", "SUN", _SIDE, _principled(_roughness), angle=0.1)
    _case(
        f"Point, roughness {_roughness}",
        "POINT",
        _SIDE,
        _principled(_roughness, Metallic=0.5),
        use_soft_falloff=False,
        **_BALL,
    )
_case(
    "Two lamps and a world",
    "AREA",
    _SIDE,
    _principled(0.4),
    world=True,
    also=("POINT", _ABOVE, _POINT),
    size=1.5,
    **_AREA,
)


def _glow(color, strength):
    return lambda t: t.made("ShaderNodeEmission", 0, {"Color": color, "Strength": strength})


def _glowing(make):
    """A material of a shader, which shines."""
    material = bpy.data.materials.new("Glow")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    tree = Tree(material.node_tree)
    tree.surface(make(tree))
    return material


_EVEN = _glow((1.0, 0.7, 0.3), 8.0)


def _emitter(
    name, add, make=_diffuse, world=False, copies=1, glow=_EVEN, sampling="AUTO", **options
):
    """add(k): makes the mesh object k in Blender; glow(tree): its shader"""

    def build(scene, tree):
        material = _glowing(glow)
        material.cycles.emission_sampling = sampling
        for k in range(copies):
            add(k)
            bpy.context.object.data.materials.append(material)
        tree.surface(make(tree))

    lit_by(name, build, world=world, **options)


def _plane(_):
    bpy.ops.mesh.primitive_plane_add(size=1.2, location=_SIDE, rotation=(0.6, -0.9, 0.3))


def _ball(_):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=0.4, location=_ABOVE)


def _tiny(_):
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.05, location=(0.2, -1.2, 0.6))


def _row(k):
    place = (-2.5 + 0.25 * k, -1.5, 1.6 + 0.1 * (k % 3))
    bpy.ops.mesh.primitive_cube_add(size=0.12, location=place, rotation=(0.2 * k, 0.1, 0.3 * k))


_emitter("Emissive plane", _plane)
_emitter("Emissive plane, sampling NONE", _plane, sampling="NONE", samples=(64, 8192))
_emitter("Emissive sphere of 2208 triangles", _ball)
_emitter("Emissive sphere, tiny", _tiny)
_emitter("Emissive cubes, twenty", _row, copies=20)
_emitter("Emissive sphere under a world", _ball, _principled(0.4), world=True)
for _roughness in (0.05, 0.15, 0.3):
    _made = _principled(_roughness, Metallic=0.5)
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
    bpy.ops.mesh.primitive_uv_sphere_add(segments=320, ring_count=160, radius=0.5, location=_ABOVE)


_emitter("Emissive image, sharp, near", _low_plane, glow=_sharp)
_emitter("Emissive image, sharp, near, roughness 0.15", _low_plane, _principled(0.15), glow=_sharp)
_FINE = {"glow": _sharp, "samples": (64, 4096)}  # Cycles has nine times the noise of IWIS
_emitter("Emissive image, sharp, on 101 760 faces", _fine_ball, **_FINE)
_emitter("Emissive image mixed with paint by noise", _low_plane, glow=_half_glow)
_emitter("Emissive image on the back alone", _plane, glow=_one_sided)
_emitter("Emissive, not to the camera", _plane, glow=_not_for_the_camera)


def _caught(name, add, transparent):
    """The floor is a shadow catcher; add(scene): what throws shadows on it."""

    def build(scene, tree):
        add(scene)
        scene.objects["Plane"].is_shadow_catcher = True
        scene.render.film_transparent = transparent
        tree.surface(_diffuse(tree))

    lit_by(name, build, world=True, with_alpha=transparent)


def _bright_ball(scene):
    _lamp(scene, "POINT", _ABOVE, **_BALL | {"energy": 900.0})


def _bright_sun(scene):
    _lamp(scene, "SUN", _SIDE, energy=4.0, angle=0.05)


def _bright_plane(scene):
    _plane(0)
    bpy.context.object.name = "Light"
    bpy.context.object.data.materials.append(_glowing(_glow((1.0, 0.9, 0.8), 20.0)))


_caught("Shadow catcher, world alone", lambda scene: None, False)
_caught("Shadow catcher, point", _bright_ball, False)
_caught("Shadow catcher, sun, transparent film", _bright_sun, True)
_caught("Shadow catcher, emissive plane, transparent film", _bright_plane, True)
