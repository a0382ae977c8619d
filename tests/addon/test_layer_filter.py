"""The filter of a view layer: which kinds of things it has."""

import bpy
import numpy as np
import pytest
from parity.element_cases import add_curves, add_particle_hair, add_points

from iwis.iwis_addon.export import export_scene
from iwis.iwis_addon.export.placed.instances import collect_instances


@pytest.fixture
def all_kinds(cube_scene):
    """A cube with hair and a plane, hair curves and points under a white world."""
    places = np.float32([[0.0, 0.0, 2.0], [0.5, 0.0, 2.0]])
    strand = np.stack([places, places + np.float32([0.0, 0.0, 1.0])], 1)
    material = bpy.data.materials.new("Small")
    add_curves(material, strand, np.full((2, 2), 0.05, np.float32))
    add_points(material, places + 1.0, np.full(2, 0.1, np.float32))
    add_particle_hair(bpy.data.objects["Cube"], 3)
    return cube_scene


def _names(**flags):
    """Of what is shown, with the modifier of hair."""
    for name, value in flags.items():
        setattr(bpy.context.view_layer, name, value)
    inventory = collect_instances(bpy.context.evaluated_depsgraph_get(), [])
    return sorted(one.name + one.hair for one in inventory.instances)


def test_all_is_shown_as_it_is(all_kinds):
    assert _names() == ["Cube", "CubeHair", "Plane", "Points", "Strands"]


def test_without_surfaces_hair_and_points_stay(all_kinds):
    assert _names(use_solid=False) == ["CubeHair", "Points", "Strands"]


def test_without_hair_meshes_and_points_stay(all_kinds):
    assert _names(use_strand=False) == ["Cube", "Plane", "Points"]


def test_without_environment_there_is_no_light_of_it(all_kinds):
    """Nothing is warned of: that is what was asked for."""
    bpy.context.view_layer.use_sky, told = False, []
    scene = export_scene(bpy.context.evaluated_depsgraph_get(), warnings=told)
    assert told == []
    assert not (scene.environment.radiance * scene.environment.strength).any()
