"""Worlds whose trees are more than one image."""

import bpy
import numpy as np

from .cases import world

_WHITE = (1.0, 1.0, 1.0)


def _picture(turn=0.0, name="S"):
    """A packed float map without poles of its own: smooth, with a bright side."""
    rows, columns = np.mgrid[0:32, 0:64] / np.array([32.0, 64.0])[:, None, None]
    level = np.sin(np.pi * rows)
    pixels = np.ones((32, 64, 4), np.float32)
    pixels[..., 0] = 0.4 + 0.3 * level * np.cos(2 * np.pi * columns + turn)
    pixels[..., 1] = 0.4 + 0.3 * rows
    pixels[..., 2] = 0.3 + 0.6 * rows + 0.2 * level * np.sin(4 * np.pi * columns + turn)
    image = bpy.data.images.new(name, 64, 32, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def _image(tree, turn=0.0, vector=None):
    inputs = {} if vector is None else {0: vector}
    return tree.made("ShaderNodeTexEnvironment", 0, inputs, image=_picture(turn, f"S{turn}"))


def _background(tree, color, strength=1.0):
    return tree.made("ShaderNodeBackground", 0, {"Color": color, "Strength": strength})


def _mixed(tree, factor, a, b, **properties):
    node = tree.node("ShaderNodeMix", data_type="RGBA", **properties)
    values = {"Factor_Float": factor, "A_Color": a, "B_Color": b}
    for key, value in values.items():
        tree.link(value, next(s for s in node.inputs if s.identifier == key))
    return next(s for s in node.outputs if s.identifier == "Result_Color")


def _mapped(tree, **values):
    node = tree.node("ShaderNodeMapping")
    tree.link(tree.coordinates("Generated"), node.inputs["Vector"])
    for name, value in values.items():
        node.inputs[name].default_value = value
    return node.outputs[0]


def _texture(tree, kind, output=0, vector=None, **inputs):
    properties = {name: inputs.pop(name) for name in list(inputs) if name[0].islower()}
    place = tree.coordinates("Generated") if vector is None else vector
    return tree.made(f"ShaderNodeTex{kind}", output, {"Vector": place, **inputs}, **properties)


def _noise(tree, **inputs):
    return _texture(tree, "Noise", **{"Scale": 2.0, **inputs})


def _ramp(tree, factor, interpolation="LINEAR"):
    node = tree.node("ShaderNodeValToRGB")
    ramp = node.color_ramp
    ramp.interpolation = interpolation
    ramp.elements[0].color = (0.2, 0.1, 0.05, 1.0)
    ramp.elements.new(0.5).color = (0.9, 0.6, 0.3, 1.0)
    ramp.elements[-1].color = (0.2, 0.4, 0.9, 1.0)
    tree.link(factor, node.inputs[0])
    return node.outputs[0]


def _height(tree):
    """0 below to 1 above, along z."""
    z = tree.made("ShaderNodeSeparateXYZ", "Z", {0: tree.coordinates("Generated")})
    return tree.made("ShaderNodeMapRange", 0, {"Value": z, "From Min": -1.0, "From Max": 1.0})


def _two_shaders(tree, kind, *inputs):
    node = tree.node(f"ShaderNode{kind}Shader")
    for value, socket in zip(inputs, node.inputs, strict=True):
        tree.link(value, socket)
    return node.outputs[0]


def _by_camera_ray(tree):
    seen = tree.made("ShaderNodeLightPath", "Is Camera Ray")
    first = _background(tree, _image(tree), 1.2)
    return _two_shaders(tree, "Mix", seen, first, _background(tree, (0.1, 0.5, 0.2)))


def _on_film(tree):
    bpy.context.scene.render.film_transparent = True
    return _by_camera_ray(tree)


def _colors_by_camera_ray(tree):
    seen = tree.made("ShaderNodeLightPath", "Is Camera Ray")
    picture = _ramp(tree, tree.made("ShaderNodeSeparateXYZ", "Y", {0: tree.coordinates("Window")}))
    return _background(tree, _mixed(tree, seen, _image(tree), picture))


def _strength(tree):
    factor = tree.made("ShaderNodeMath", 0, {0: _noise(tree), 1: 3.0}, operation="MULTIPLY")
    return _background(tree, _image(tree), factor)


def _absolute(tree, value):
    return tree.made("ShaderNodeVectorMath", 0, {0: value}, operation="ABSOLUTE")


def _hue(tree):
    mixed = _mixed(tree, 0.4, _image(tree), _image(tree, 2.0, _mapped(tree, Rotation=(0, 0, 1.0))))
    inputs = {"Hue": 0.6, "Saturation": 1.4, "Value": 0.9, "Fac": 1.0, "Color": mixed}
    return _background(tree, tree.made("ShaderNodeHueSaturation", 0, inputs))


def _override(tree):
    other = bpy.data.worlds.new("Other")
    if bpy.app.version < (5, 0):
        other.use_nodes = True
    other.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.5, 0.7, 1.0)
    bpy.context.view_layer.world_override = other
    return _background(tree, _image(tree))


def _flat_image(tree):
    place = tree.made("ShaderNodeMapping", 0, {"Vector": tree.coordinates("Generated")})
    node = tree.node("ShaderNodeTexImage", image=_picture(1.0), extension="MIRROR")
    tree.link(place, node.inputs[0])
    return _background(tree, node.outputs[0])


def _curved(tree):
    node = tree.node("ShaderNodeRGBCurve")
    node.mapping.curves[3].points.new(0.4, 0.6)
    node.mapping.update()
    tree.link(_image(tree), node.inputs["Color"])
    return _background(tree, node.outputs[0])


world("World, image through curves", _curved)
world("World, two images by noise", lambda t: _mixed(t, _noise(t), _image(t), _image(t, 2.0)))
world("World, hue over two images", _hue)
world(
    "World, gradient by generated",
    lambda t: _background(t, _ramp(t, _texture(t, "Gradient", gradient_type="LINEAR"))),
)
world("World, ramp by height", lambda t: _background(t, _ramp(t, _height(t))))
world("World, stepped ramp", lambda t: _background(t, _ramp(t, _height(t), "CONSTANT")))
world(
    "World, spherical gradient, moved",
    lambda t: _background(
        t,
        _texture(
            t,
            "Gradient",
            vector=_mapped(t, Location=(0.3, -0.4, 0.5)),
            gradient_type="SPHERICAL",
        ),
        2.0,
    ),
)
world("World, noise, turned", lambda t: _noise(t, output=1, vector=_mapped(t, Rotation=(1, 2, 3))))
world("World, checker", lambda t: _texture(t, "Checker", Scale=3.0))
world("World, Voronoi", lambda t: _texture(t, "Voronoi", "Color", Scale=3.0))
world("World, waves", lambda t: _texture(t, "Wave", Scale=1.0, Distortion=2.0))
world("World, magic", lambda t: _texture(t, "Magic", Scale=1.5))
world("World, bricks", lambda t: _texture(t, "Brick", Scale=2.0))
world("World, strength by a texture", _strength)
world(
    "World, two backgrounds by a texture",
    lambda t: _two_shaders(
        t, "Mix", _height(t), _background(t, _image(t), 2.0), _background(t, (0.3, 0.5, 0.9))
    ),
)
world(
    "World, two backgrounds added",
    lambda t: _two_shaders(
        t, "Add", _background(t, _image(t)), _background(t, _ramp(t, _height(t)), 0.5)
    ),
)
world("World, two backgrounds by camera ray", _by_camera_ray)
world("World, two backgrounds by camera ray, transparent film", _on_film, with_alpha=True)
world("World, colours by camera ray, Window", _colors_by_camera_ray)
world("World, Normal output", lambda t: _absolute(t, t.coordinates("Normal")))
world(
    "World, Incoming",
    lambda t: _absolute(t, t.made("ShaderNodeNewGeometry", "Incoming")),
)
world("World, Camera output", lambda t: _absolute(t, t.coordinates("Camera")))
world("World, Image Texture by generated", _flat_image)
world(
    "World, Math",
    lambda t: t.made("ShaderNodeMath", 0, {0: _height(t), 1: 0.5}, operation="POWER"),
)
world("World, override of the view layer", _override)


def _rough(tree, projection="EQUIRECTANGULAR"):
    """A picture whose every texel differs from the next."""
    pixels = np.ones((32, 64, 4), np.float32)
    pixels[..., :3] = 0.2 + 0.8 * np.random.default_rng(5).random((32, 64, 3)) ** 3
    image = bpy.data.images.new("R", 64, 32, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return tree.made("ShaderNodeTexEnvironment", 0, image=image, projection=projection)


def _around(axis):
    """The Tangent node, which goes around an axis."""

    def make(t):
        tangent = t.made("ShaderNodeTangent", 0, direction_type="RADIAL", axis=axis)
        half = t.made("ShaderNodeVectorMath", 0, {0: tangent, "Scale": 0.5}, operation="SCALE")
        move = {0: half, 1: (0.5, 0.5, 0.5)}
        return _background(t, t.made("ShaderNodeVectorMath", 0, move, operation="ADD"))

    return make


for _axis in "XYZ":
    world(f"World, Tangent, radial {_axis}", _around(_axis))
for _projection in ("EQUIRECTANGULAR", "MIRROR_BALL"):
    world(
        f"World, rough picture {_projection} under a ramp",
        lambda t, p=_projection: _background(t, _ramp(t, _rough(t, p))),
    )
    world(
        f"World, rough picture {_projection} under a gamma",
        lambda t, p=_projection: _background(
            t, t.made("ShaderNodeGamma", 0, {"Color": _rough(t, p), "Gamma": 1.6})
        ),
    )


def _lone_sun(over):
    """A picture with one bright texel, which most of the light comes from, under a node."""

    def make(t):
        pixels = np.full((128, 256, 4), 0.05, np.float32)
        pixels[96, 102, :3], pixels[..., 3] = (100.0, 90.0, 80.0), 1.0
        image = bpy.data.images.new("S", 256, 128, float_buffer=True)
        image.pixels.foreach_set(pixels.ravel())
        image.pack()
        return _background(t, over(t, t.made("ShaderNodeTexEnvironment", 0, image=image)))

    return make


_ABATED = {1: (30.0, 30.0, 30.0)}
world(
    "World, one sun under a gamma",
    _lone_sun(lambda t, c: t.made("ShaderNodeGamma", 0, {"Color": c, "Gamma": 1.5})),
)
world(
    "World, one sun, cut off",
    _lone_sun(
        lambda t, c: t.made("ShaderNodeVectorMath", 0, {0: c} | _ABATED, operation="MINIMUM")
    ),
)


def sky(turned=False, seen=True, **settings):
    """A Sky Texture of a type that this Blender has: 4.5 has one in place of two.

    seen: by the camera; within half a degree of the horizon some skies triple their light
    """

    def make(t):
        bpy.context.scene.world.cycles_visibility.camera = seen
        node = t.node("ShaderNodeTexSky")
        kinds = [item.identifier for item in node.bl_rna.properties["sky_type"].enum_items]
        kind = settings.get("sky_type")
        if kind is not None:
            node.sky_type = kind if kind in kinds else "NISHITA"
        for name, value in settings.items():
            if name != "sky_type":
                setattr(node, name, value)
        if turned:
            mapping = t.node("ShaderNodeMapping")
            t.link(t.coordinates("Generated"), mapping.inputs["Vector"])
            mapping.inputs["Rotation"].default_value = 0.3, -0.2, 0.8
            t.tree.links.new(mapping.outputs[0], node.inputs["Vector"])
        return t.made("ShaderNodeBackground", 0, {"Color": node.outputs[0], "Strength": 0.2})

    return make


_SUN = {"sun_elevation": 0.6, "sun_rotation": 2.2}
world("Sky, single scattering, disc", sky(sky_type="SINGLE_SCATTERING", **_SUN))
world("Sky, multiple scattering, disc", sky(sky_type="MULTIPLE_SCATTERING", seen=False, **_SUN))
_NO_DISC = {"sky_type": "MULTIPLE_SCATTERING", "sun_disc": False}
world("Sky, multiple scattering, no disc", sky(seen=False, **_NO_DISC))
world("Sky, multiple scattering, horizon seen", sky(**_NO_DISC))
_LOW = {"sun_elevation": 0.1, "sun_rotation": 3.0, "sun_size": 0.004}
world("Sky, low small sun", sky(seen=False, **_LOW))
world("Sky, Preetham", sky(sky_type="PREETHAM", sun_direction=(0.3, -0.4, 0.6), turbidity=4.0))
world("Sky, Hosek-Wilkie", sky(sky_type="HOSEK_WILKIE", sun_direction=(-0.6, -0.3, 0.4)))
world("Sky, turned", sky(turned=True, sky_type="PREETHAM", sun_direction=(0.3, -0.4, 0.6)))
