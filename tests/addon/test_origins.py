"""How instances were made, as far as a material asks (iwis_addon/export/objects/origins.py)."""

import bpy
import numpy as np
import pytest

from iwis.iwis_addon.export.placed.instances import collect_instances


def _ask(kind, **properties):
    material = bpy.data.materials.new("Asks")
    if material.node_tree is None:
        material.use_nodes = True
    node = material.node_tree.nodes.new(kind)
    for name, value in properties.items():
        setattr(node, name, value)


@pytest.fixture
def hairy(scene):
    """Twelve cubes as hair of a sphere, and the two themselves."""
    bpy.ops.mesh.primitive_cube_add(size=0.1)
    cube = bpy.context.object
    bpy.ops.mesh.primitive_uv_sphere_add(location=(2.0, 0.0, 0.0))
    sphere = bpy.context.object
    settings = sphere.modifiers.new("P", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count, settings.hair_length = "HAIR", 12, 0.3
    settings.render_type, settings.instance_object = "OBJECT", cube
    return sphere


def _origins():
    inventory = collect_instances(bpy.context.evaluated_depsgraph_get(), [])
    made = zip(inventory.instances, inventory.looks, strict=True)
    return [look.origin for instance, look in made if instance.number >= 0]


def test_instances_know_their_particle(hairy):
    """Index and location are those of the system's particles."""
    _ask("ShaderNodeParticleInfo")
    found = _origins()
    assert [origin.value("Index")[0] for origin in found] == list(range(12))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    particles = hairy.evaluated_get(depsgraph).particle_systems[0].particles
    for origin, particle in zip(found, particles, strict=True):
        np.testing.assert_allclose(origin.value("Location")[:3], particle.location)
        assert origin.value("Generated").tolist() == [0.0] * 4


def test_instances_know_their_place(hairy):
    """Where something asks From Instancer; hair's generated place is on its emitter."""
    _ask("ShaderNodeTexCoord", from_instancer=True)
    places = np.array([origin.value("Generated") for origin in _origins()])
    assert len(np.unique(places, axis=0)) == 12
    assert (places[:, 3] == 0.0).all() and np.abs(places).max() <= 1.0


def test_children_stand_for_no_particle(hairy):
    """They are numbered after their parents, which are not shown beside them."""
    _ask("ShaderNodeParticleInfo")
    settings = hairy.particle_systems[0].settings
    settings.child_type = "SIMPLE"
    settings.child_percent = settings.rendered_child_count = 3
    found = _origins()
    assert len(found) == 36 and not any(origin.values for origin in found)


def test_nothing_is_read_that_no_material_asks(hairy):
    assert all(origin.values == {} for origin in _origins())
