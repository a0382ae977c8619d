"""Which value nodes there are, what of their properties counts, and those that need more than that.

A handler (builder, node, groups) returns the row of the operation that it has added, a dictionary
of constant outputs by identifier, or None where the node cannot be followed.
"""

from __future__ import annotations

import bpy
import numpy as np

from ....core.data.program import Ref
from ....core.nodes.falloff import LIGHT_FALLOFF
from ..objects.object_properties import TABLES
from ..objects.origins import PARTICLE
from . import spectral_nodes
from .program_images import environment_settings, image_settings

# bl_idname -> properties; the operation has the same name (core/nodes).
SETTINGS = {
    "ShaderNodeMath": ("operation", "use_clamp"),
    "ShaderNodeVectorMath": ("operation",),
    "ShaderNodeClamp": ("clamp_type",),
    "ShaderNodeMapRange": ("data_type", "interpolation_type", "clamp"),
    "ShaderNodeCombineXYZ": (),
    "ShaderNodeSeparateXYZ": (),
    "ShaderNodeMix": (
        "data_type",
        "blend_type",
        "factor_mode",
        "clamp_factor",
        "clamp_result",
    ),
    "ShaderNodeMixRGB": ("blend_type", "use_clamp"),
    "ShaderNodeHueSaturation": (),
    "ShaderNodeBrightContrast": (),
    "ShaderNodeGamma": (),
    "ShaderNodeInvert": (),
    "ShaderNodeRGBToBW": (),
    "ShaderNodeSeparateColor": ("mode",),
    "ShaderNodeCombineColor": ("mode",),
    "ShaderNodeMapping": ("vector_type",),
    "ShaderNodeVectorRotate": ("rotation_type", "invert"),
    "ShaderNodeVectorTransform": ("vector_type", "convert_from", "convert_to"),
    "ShaderNodeNewGeometry": (),
    "ShaderNodeObjectInfo": (),
    "ShaderNodeCameraData": (),
    "ShaderNodeLightPath": (),
    "ShaderNodeHairInfo": (),
    "ShaderNodePointInfo": (),
    "ShaderNodeBump": ("invert",),
    "ShaderNodeFresnel": (),
    "ShaderNodeLayerWeight": (),
    "ShaderNodeTexNoise": ("noise_dimensions", "noise_type", "normalize"),
    "ShaderNodeTexVoronoi": ("voronoi_dimensions", "feature", "distance", "normalize"),
    "ShaderNodeTexGabor": ("gabor_type",),
    "ShaderNodeTexChecker": (),
    "ShaderNodeTexGradient": ("gradient_type",),
    "ShaderNodeTexWave": ("wave_type", "bands_direction", "rings_direction", "wave_profile"),
    "ShaderNodeTexMagic": ("turbulence_depth",),
    "ShaderNodeTexBrick": ("offset", "offset_frequency", "squash", "squash_frequency"),
    "ShaderNodeTexWhiteNoise": ("noise_dimensions",),
    "ShaderNodeWireframe": ("use_pixel_size",),
}
_TABLE = 257  # values of a ramp or curve, as in Cycles: every 1/256


def _texture_coordinate(builder, node, groups):
    settings = {"outputs": set(), "from_instancer": node.from_instancer and builder.of_instances}
    if node.from_instancer and not builder.of_instances:
        builder.reader.warn(node, "From Instancer is not supported: the object's own coordinates")
    if node.object is not None:
        settings["world_to_object"] = np.array(node.object.matrix_world.inverted_safe())
    return builder.add_node(node, groups, "ShaderNodeTexCoord", {}, settings)


def _particle_info(builder, node, groups):
    if not builder.of_instances:
        return None
    return builder.add_node(node, groups, node.bl_idname, {}, {"outputs": set()})


def _uv_map(builder, node, groups):
    if node.from_instancer and builder.of_instances:
        return {"UV": builder.of_origin("UV")}
    if node.from_instancer:
        builder.reader.warn(node, "From Instancer is not supported: the object's own UV map")
    builder.requests.add(f"uv:{node.uv_map}")
    return builder.add_node(node, groups, "ShaderNodeUVMap", {}, {"uv_map": node.uv_map})


def _color_attribute(builder, node, groups):
    table = f"color:{node.layer_name}"
    builder.requests.add(table)
    return builder.add_node(node, groups, "attribute", {}, {"table": table})


def _attribute(builder, node, groups):
    kind, name = node.attribute_type, node.attribute_name
    if kind == "GEOMETRY":
        table = f"attribute:{name}"
        builder.requests.add(table)
        return builder.add_node(node, groups, "attribute", {}, {"table": table})
    if kind not in TABLES:
        return None
    settings = {"table": f"{TABLES[kind]}:{name}", "outputs": set()}
    builder.requests.add(settings["table"])
    return builder.add_node(node, groups, "object_attribute", {}, settings)


def _normal_map(builder, node, groups):
    settings = {
        "space": node.space,
        "downward": getattr(node, "convention", "OPENGL") == "DIRECTX",
        "original": getattr(node, "base", "") == "ORIGINAL",
        "follows": getattr(node, "base", "") == "DISPLACED",  # since Blender 5.2
        "unit": bpy.app.version >= (5, 0),
    }
    if node.space == "TANGENT":
        settings["table"] = f"tangent:{node.uv_map}"
        builder.requests.add(settings["table"])
    inputs = builder.inputs(node, groups)
    return builder.add_node(node, groups, "ShaderNodeNormalMap", inputs, settings)


def _tangent(builder, node, groups):
    settings = {"axis": node.axis}
    if node.direction_type == "UV_MAP":
        settings = {"table": f"tangent:{node.uv_map}"}
    builder.requests.add(settings.get("table", "generated"))
    return builder.add_node(node, groups, "ShaderNodeTangent", {}, settings)


def _normal(builder, node, groups):
    direction = np.array(node.outputs[0].default_value[:3], np.float32)
    settings = {"direction": direction / max(float(np.linalg.norm(direction)), 1e-20)}
    return builder.add_node(
        node, groups, "ShaderNodeNormal", builder.inputs(node, groups), settings
    )


def _color_ramp(builder, node, groups):
    ramp = node.color_ramp
    table = np.array([ramp.evaluate(k / (_TABLE - 1)) for k in range(_TABLE)], np.float32)
    settings = {"table": table, "stepped": ramp.interpolation == "CONSTANT"}
    return builder.add_node(
        node, groups, "ShaderNodeValToRGB", builder.inputs(node, groups), settings
    )


def _curve_settings(mapping, n_curves):
    """The curves at even steps, and where they begin and end."""
    mapping.initialize()
    curves = list(mapping.curves)[:n_curves]
    low = min([0.0] + [point.location[0] for curve in curves for point in curve.points])
    high = max([1.0] + [point.location[0] for curve in curves for point in curve.points])
    steps = [low + (high - low) * k / (_TABLE - 1) for k in range(_TABLE)]
    values = [[mapping.evaluate(curve, x) for x in steps] for curve in curves]
    if n_curves == 4:  # the last one is for all three, and comes first
        values = [[mapping.evaluate(curve, x) for x in values[3]] for curve in curves[:3]]
    table = np.array(values, np.float32).T
    extend = mapping.extend == "EXTRAPOLATED"
    return {
        "table": np.ascontiguousarray(table[:, 0] if n_curves == 1 else table),
        "low": np.float32(low),
        "high": np.float32(high),
        "extend": extend,
    }


def _curves(n_curves):
    def handler(builder, node, groups):
        settings = _curve_settings(node.mapping, n_curves)
        return builder.add_node(
            node, groups, node.bl_idname, builder.inputs(node, groups), settings
        )

    return handler


def _image_texture(builder, node, groups):
    settings = image_settings(builder, node)
    inputs = builder.inputs(node, groups)
    if "Vector" not in inputs:
        builder.requests.add("uv:")
    return builder.add_node(node, groups, node.bl_idname, inputs, settings)


def _vector(_builder, node, _groups):
    """What Blender 5 makes of constants that feed a socket which shows no value, as a Normal."""
    return {"Vector": np.float32(node.vector)}


def _environment_texture(builder, node, groups):
    settings = environment_settings(builder, node)
    return builder.add_node(node, groups, node.bl_idname, builder.inputs(node, groups), settings)


def _light_falloff(builder, node, groups):
    """Light falls off by the square of the distance as it is: then it is a constant."""
    strength = builder.number(node, "Strength", groups)
    smooth = builder.number(node, "Smooth", groups)
    used = {output.identifier for output in node.outputs if output.is_linked}
    if not isinstance(smooth, Ref) and not smooth > 0.0 and used <= {"Quadratic"}:
        return {"Quadratic": strength}
    inputs = {"Strength": strength, "Smooth": smooth}
    return builder.add_node(node, groups, LIGHT_FALLOFF, inputs, {"outputs": set()})


def _scene_time(builder, node, groups):
    if builder.scene is None:
        return None
    frame, render = builder.scene.frame_float, builder.scene.render
    seconds = frame * render.fps_base / render.fps
    return {"Seconds": np.float32(seconds), "Frame": np.float32(frame)}


def _displacement(builder, node, groups):
    settings, inputs = {"space": node.space}, builder.inputs(node, groups)
    if node.space == "TANGENT":
        settings["table"] = "tangent:"
        builder.requests.add(settings["table"])
    return builder.add_node(node, groups, node.bl_idname, inputs, settings)


def _bevel(builder, node, groups):
    """ "Surface" is the normal that displacement leaves."""
    inputs = builder.inputs(node, groups)
    if builder.displaced is not None:
        inputs["Surface"] = builder.displaced
    settings = {"samples": node.samples}
    return builder.add_node(node, groups, node.bl_idname, inputs, settings)


def _ambient_occlusion(builder, node, groups):
    """A distance that is 0, however it is made, is the world's."""
    inputs = builder.inputs(node, groups)
    if builder.displaced is not None:
        inputs.setdefault("Normal", builder.displaced)
    distance = inputs["Distance"]
    settings = {
        "samples": node.samples,
        "inside": node.inside,
        "only_local": node.only_local,
        "everywhere": not isinstance(distance, Ref) and float(distance) == 0.0,
    }
    return builder.add_node(node, groups, node.bl_idname, inputs, settings)


HANDLERS = {
    "FunctionNodeInputVector": _vector,
    "GeometryNodeInputSceneTime": _scene_time,
    "ShaderNodeAmbientOcclusion": _ambient_occlusion,
    "ShaderNodeBevel": _bevel,
    **spectral_nodes.HANDLERS,
    "ShaderNodeDisplacement": _displacement,
    "ShaderNodeVectorDisplacement": _displacement,
    "ShaderNodeTexCoord": _texture_coordinate,
    "ShaderNodeUVMap": _uv_map,
    PARTICLE: _particle_info,
    "ShaderNodeVertexColor": _color_attribute,
    "ShaderNodeAttribute": _attribute,
    "ShaderNodeNormalMap": _normal_map,
    "ShaderNodeNormal": _normal,
    "ShaderNodeTangent": _tangent,
    "ShaderNodeValToRGB": _color_ramp,
    "ShaderNodeRGBCurve": _curves(4),
    "ShaderNodeVectorCurve": _curves(3),
    "ShaderNodeFloatCurve": _curves(1),
    "ShaderNodeTexImage": _image_texture,
    "ShaderNodeTexEnvironment": _environment_texture,
    LIGHT_FALLOFF: _light_falloff,
}
