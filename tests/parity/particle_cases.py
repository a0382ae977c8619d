"""What instances know of the particle that they stand for, and of their place on what made them."""

from __future__ import annotations

import bpy

from .cases import CASES, Case
from .scene import Tree

# The parts that show them; ages and places are of ten frames.
SCALES = {
    "Index": 0.01,
    "Random": 1.0,
    "Age": 0.1,
    "Lifetime": 0.02,
    "Location": 0.5,
    "Size": 1.5,
    "Velocity": 0.3,
    "Angular Velocity": 0.3,
}


def _particles(kind):
    """Cubes as particles of the sphere, falling or its hair. Returns the settings."""
    scene = bpy.context.scene
    sphere, cube = scene.objects["Sphere"], scene.objects["Cube"]
    cube.scale = (0.5, 0.5, 0.5)
    settings = sphere.modifiers.new("P", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count = kind, 60
    settings.render_type, settings.instance_object = "OBJECT", cube
    settings.particle_size, settings.size_random = 0.4, 0.5
    if kind == "HAIR":
        settings.hair_length = 0.2
        return settings
    settings.frame_start, settings.frame_end, settings.lifetime = 1.0, 9.0, 40.0
    settings.lifetime_random, settings.normal_factor = 0.5, 2.0
    settings.use_rotations, settings.angular_velocity_mode = True, "RAND"
    settings.angular_velocity_factor = 1.5
    return settings


def _info(kind, output):
    def build(scene, tree):
        _particles(kind)
        value = tree.made("ShaderNodeParticleInfo", output)
        inputs = {0: value, 1: (SCALES[output],) * 3}
        tree.glow(tree.made("ShaderNodeVectorMath", 0, inputs, operation="MULTIPLY"))
        for frame in range(1, 11):  # particles are simulated from one frame to the next
            scene.frame_set(frame)

    return build


for _output in SCALES:
    CASES.append(Case(f"Particle Info {_output}", _info("EMITTER", _output)))
for _output in ("Index", "Location", "Size"):
    CASES.append(Case(f"Particle Info {_output}, of hair", _info("HAIR", _output)))


def _children(scene, tree):
    """They stand for no particle that the node knows."""
    settings = _particles("HAIR")
    settings.child_type, settings.count = "SIMPLE", 20
    settings.rendered_child_count = 3
    value = tree.made("ShaderNodeParticleInfo", "Random")
    tree.glow(value)


CASES.append(Case("Particle Info Random, of children", _children))


def _of_instancers(output, how, node="ShaderNodeTexCoord"):
    """Cubes on the faces or the vertices of the sphere, or as its particles."""

    def build(scene, tree):
        sphere, cube = scene.objects["Sphere"], scene.objects["Cube"]
        if how == "particles":
            _particles("HAIR")
        else:
            cube.parent, sphere.instance_type = sphere, how
            cube.location, cube.scale = (0.0, 0.0, 0.0), (0.05, 0.05, 0.05)
        value = tree.made(node, output, from_instancer=True)
        inputs = {0: value, 1: (1.0, 1.0, 1.0), 2: (0.5, 0.5, 0.5)}
        tree.glow(tree.made("ShaderNodeVectorMath", 0, inputs, operation="MULTIPLY_ADD"))

    return build


for _how in ("VERTS", "FACES", "particles"):
    for _output in ("Generated", "UV", "Object"):
        _name = f"Texture Coordinate {_output}, from instancer, {_how.lower()}"
        CASES.append(Case(_name, _of_instancers(_output, _how)))
CASES.append(Case("UV Map, from instancer", _of_instancers("UV", "FACES", "ShaderNodeUVMap")))


def _noise_from_instancer(scene, tree):
    """In a group: each instance a colour of its own."""
    _of_instancers("Generated", "FACES")(scene, tree)
    group = bpy.data.node_groups.new("Inner", "ShaderNodeTree")
    group.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
    inner = Tree(group, "NodeGroupOutput")
    place = inner.made("ShaderNodeTexCoord", "Generated", from_instancer=True)
    inner.link(inner.made("ShaderNodeTexNoise", "Color", {0: place}), inner.output.inputs[0])
    node = tree.node("ShaderNodeGroup")
    node.node_tree = group
    tree.glow(node.outputs[0])


CASES.append(
    Case("Texture Coordinate Generated, from instancer, in a group", _noise_from_instancer)
)
