"""Lamps: each kind and setting alone, over the materials that show what is wrong with it."""

import math

import bpy

from .cases import lit_by
from .scene import Tree


def add_lamp(scene, kind, location, target=(0.0, 0.0, -0.4), scale=(1.0, 1.0, 1.0), **settings):
    """A light that shines on a target. settings: of the light, visible_... of its object, and
    multiple_importance, of Cycles' settings"""
    import mathutils

    light = bpy.data.lights.new("Lamp", kind)
    obj = bpy.data.objects.new("Lamp", light)
    light.cycles.use_multiple_importance_sampling = settings.pop("multiple_importance", True)
    for name, value in settings.items():
        setattr(obj if name.startswith("visible") else light, name, value)
    away = mathutils.Vector(location) - mathutils.Vector(target)
    obj.location, obj.scale = location, scale
    obj.rotation_euler = away.to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(obj)
    return light


def dressed(lamp, shader):
    """Have a light shine as a shader(tree) says."""
    if bpy.app.version < (5, 0):
        lamp.use_nodes = True
    tree = Tree(lamp.node_tree, "ShaderNodeOutputLight")
    tree.surface(shader(tree))


def matte(tree):
    return tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.7, 0.6, 0.5)})


def shiny(roughness, **inputs):
    values = {"Base Color": (0.6, 0.3, 0.2), "Roughness": roughness} | inputs
    return lambda tree: tree.made("ShaderNodeBsdfPrincipled", 0, values)


def _cloth(distribution):
    colors = {"Color": (0.8, 0.6, 0.7), "Roughness": 0.5}
    return lambda tree: tree.made("ShaderNodeBsdfSheen", 0, colors, distribution=distribution)


def _case(name, kind, location, make=matte, world=False, also=None, **options):
    """also: arguments of a second lamp"""

    def build(scene, tree):
        add_lamp(scene, kind, location, **options)
        if also is not None:
            add_lamp(scene, *also[:2], **also[2])
        tree.surface(make(tree))

    lit_by(name, build, world=world)


ABOVE, SIDE = (1.5, -2.0, 3.0), (-2.5, -2.0, 1.5)
_POINT, _AREA = {"energy": 300.0}, {"energy": 200.0, "visible_camera": False}
BALL = _POINT | {"shadow_soft_size": 0.4, "visible_camera": False}
_SPOT = {"energy": 600.0, "spot_size": math.radians(40.0), "visible_camera": False}

_case("Point", "POINT", ABOVE, **_POINT)
_case("Point, not normalized", "POINT", ABOVE, normalize=False, **_POINT)


def _slanted(name, make=matte, turn=(0.6, 0.0, 0.0), scale=(1.0, 1.0, 0.5), **settings):
    """An area that is turned under a parent which is scaled unevenly. name: its shape first"""

    def build(scene, tree):
        size = {"shape": name.split(",")[0], "size": 1.2, "size_y": 0.8}
        add_lamp(scene, "AREA", (0.0, 0.0, 0.0), **size, **_AREA, **settings)
        parent = bpy.data.objects.new("Parent", None)
        scene.collection.objects.link(parent)
        parent.location, parent.scale = (0.3, -1.2, 2.2), scale
        lamp = bpy.data.objects["Lamp"]
        lamp.parent, lamp.rotation_euler = parent, turn
        tree.surface(make(tree))

    lit_by(f"Area under an uneven scale, {name}", build)


def _black_body(tree):
    color = tree.made("ShaderNodeBlackbody", 0, {0: 3200.0})
    return tree.made("ShaderNodeEmission", 0, {"Color": color, "Strength": 1.0})


def _with_blackbody(name):
    def build(scene, tree):
        dressed(add_lamp(scene, "POINT", ABOVE, **_POINT), _black_body)
        tree.surface(matte(tree))

    lit_by(name, build)


_with_blackbody("Point, a black body")
_case("Point, radius", "POINT", ABOVE, use_soft_falloff=False, **BALL)
_case("Point, radius, not normalized", "POINT", ABOVE, normalize=False, **BALL)
_case("Point, soft falloff", "POINT", ABOVE, use_soft_falloff=True, **BALL)
_case("Point, soft falloff, near", "POINT", (0.2, -0.4, 0.1), use_soft_falloff=True, **BALL)
_case("Point, scaled", "POINT", ABOVE, scale=(3.0, 2.0, 0.5), **BALL)
_case("Point, no shadow", "POINT", SIDE, use_shadow=False, **BALL)
_case("Point, coloured, exposed", "POINT", SIDE, color=(1.0, 0.4, 0.1), exposure=-0.7, **_POINT)
_case("Point, temperature", "POINT", ABOVE, use_temperature=True, temperature=3200.0, **_POINT)
_case("Point, factors of EEVEE", "POINT", ABOVE, shiny(0.3), specular_factor=0.2, **BALL)
_case("Point, not for glossy", "POINT", ABOVE, shiny(0.3), visible_glossy=False, **BALL)
_case("Point, not for diffuse", "POINT", ABOVE, shiny(0.3), visible_diffuse=False, **BALL)
for _kind, _rays in {"MICROFIBER": "glossy", "ASHIKHMIN": "diffuse"}.items():
    _case(
        f"Point, sheen {_kind}, not for {_rays}",
        "POINT",
        ABOVE,
        _cloth(_kind),
        **{f"visible_{_rays}": False},
        **BALL,
    )
for _blend in (0.0, 0.15, 1.0):
    _case(f"Spot, blend {_blend}", "SPOT", ABOVE, spot_blend=_blend, **_SPOT)
_case("Spot, radius", "SPOT", ABOVE, spot_blend=0.5, shadow_soft_size=0.5, **_SPOT)
_case("Spot, scaled", "SPOT", ABOVE, spot_blend=0.5, scale=(1.6, 0.7, 1.0), **_SPOT)
_case(
    "Spot, radius, hard falloff",
    "SPOT",
    ABOVE,
    spot_blend=0.5,
    shadow_soft_size=0.5,
    use_soft_falloff=False,
    **_SPOT,
)
for _degrees in (0.0, 5.0, 40.0):
    _case(f"Sun, {_degrees:.0f} degrees", "SUN", SIDE, energy=3.0, angle=math.radians(_degrees))
_case("Sun, not normalized", "SUN", SIDE, energy=3.0, angle=0.3, normalize=False)
_SIZES = {
    "SQUARE": {"size": 1.2},
    "RECTANGLE": {"size": 2.5, "size_y": 0.4},
    "DISK": {"size": 1.2},
    "ELLIPSE": {"size": 2.0, "size_y": 0.7},
}
for _shape, _size in _SIZES.items():
    _case(f"Area {_shape}", "AREA", ABOVE, shape=_shape, **_size, **_AREA)
    for _spread in (5.0, 60.0):
        _case(
            f"Area {_shape}, spread {_spread:.0f}",
            "AREA",
            ABOVE,
            shape=_shape,
            spread=math.radians(_spread),
            **_size,
            **_AREA,
        )
_case("Area, spread 0", "AREA", ABOVE, size=1.7, spread=0.0, **_AREA)
_case("Area, not normalized", "AREA", ABOVE, size=1.2, normalize=False, **_AREA)
_case("Area, scaled", "AREA", ABOVE, size=1.0, scale=(2.0, 0.5, 3.0), **_AREA)
_slanted("RECTANGLE")
_slanted("RECTANGLE, spread 60", spread=math.radians(60.0))
_slanted("RECTANGLE, roughness 0.3", shiny(0.3))
_slanted("RECTANGLE, from behind", turn=(0.0, -0.8, 0.0), scale=(1.0, 1.0, 2.5))
_slanted("ELLIPSE")
_case("Area, no shadow", "AREA", SIDE, size=1.2, use_shadow=False, **_AREA)
_case("Area, near the floor", "AREA", (0.0, -0.6, -0.8), size=0.6, target=(0, 3, -1.4), **_AREA)
for _roughness in (0.05, 0.15, 0.3, 1.0):
    _case(
        f"Area, roughness {_roughness}",
        "AREA",
        SIDE,
        shiny(_roughness, Metallic=0.5),
        size=1.5,
        **_AREA,
    )
    _case(f"Sun, roughness {_roughness}", "SUN", SIDE, shiny(_roughness), angle=0.1)
    _case(
        f"Point, roughness {_roughness}",
        "POINT",
        SIDE,
        shiny(_roughness, Metallic=0.5),
        use_soft_falloff=False,
        **BALL,
    )
for _roughness in (0.0, 0.15):
    _case(
        f"Area, no Multiple Importance, roughness {_roughness}",
        "AREA",
        SIDE,
        shiny(_roughness, Metallic=0.5),
        multiple_importance=False,
        size=1.5,
        **_AREA,
    )
_case("Sun, no Multiple Importance", "SUN", SIDE, shiny(0.1), multiple_importance=False, angle=0.1)
_case(
    "Point, no Multiple Importance",
    "POINT",
    SIDE,
    shiny(0.1, Metallic=1.0),
    multiple_importance=False,
    use_soft_falloff=False,
    **BALL,
)
_case(
    "Two lamps and a world",
    "AREA",
    SIDE,
    shiny(0.4),
    world=True,
    also=("POINT", ABOVE, _POINT),
    size=1.5,
    **_AREA,
)
