"""Thin films of the open file, beside Cycles' passes."""

import bpy
import numpy as np
import pytest
from parity.scene import Tree

from iwis.core.bsdf.thin_film_tables import ACESCG, GAUSSIANS, REC709
from support.cycles_render import render_cycles
from support.iwis_render import by_pass, render_iwis
from support.material_builds import Build, only, program_of

_OF_5 = bpy.app.version >= (5, 0)


@pytest.fixture
def build(scene):
    return Build()


def _principled(build, thickness=300.0, **values):
    node = build.node("ShaderNodeBsdfPrincipled", Thin_Film_Thickness=thickness, **values)
    return build.surface(node)


def test_film_is_read(build):
    """Thickness and index, and how each Blender version sees its colors: without a warning."""
    _principled(build, Thin_Film_IOR=1.7)
    assert only(build)[1] == []
    film = program_of(build).closures[0].film
    assert (film.thickness, film.ior) == (np.float32(300.0), np.float32(1.7))
    assert film.space == (REC709 if _OF_5 else GAUSSIANS)
    assert film.index is None and film.extinction is None


@pytest.mark.parametrize("thickness", [0.0, -100.0, 0.05])
def test_no_film_needs_no_program(build, thickness):
    """None, and less than a tenth of a nanometre: a row says all, without a warning."""
    _principled(build, thickness)
    assert only(build)[1] == []
    assert program_of(build) is None


def test_textured_film_is_read(build):
    """By the nodes behind it."""
    node = build.node("ShaderNodeBsdfPrincipled")
    build.link(build.node("ShaderNodeTexNoise").outputs[0], node.inputs["Thin Film Thickness"])
    assert only(build.surface(node))[1] == []
    program = program_of(build)
    assert program.ops[program.closures[0].film.thickness.op].kind == "ShaderNodeTexNoise"


def test_film_is_on_all_that_principled_mirrors_but_its_coat(build):
    """On its metal, its glass and what is left of it."""
    _principled(build, Transmission_Weight=0.5, Metallic=0.5, Coat_Weight=1.0)
    assert len(only(build)[1]) == 1  # glass, without refraction
    coat, metal, glass, rest = (closure.film for closure in program_of(build).closures)
    assert coat is None and metal == glass == rest and rest.thickness == 300.0


if _OF_5:

    def test_glass_lets_less_through_by_its_film(build):
        """The share that goes through knows the film."""
        build.surface(build.node("ShaderNodeBsdfGlass", Thin_Film_Thickness=300.0))
        only(build)
        program = program_of(build)
        (op,) = (op for op in program.ops if op.kind == "through_glass")
        film = program.closures[0].film
        assert (op.inputs["Thickness"], op.settings["space"]) == (300.0, film.space)

    def test_metal_by_its_indices_keeps_them_under_a_film(build):
        """A film asks for more than a curve."""
        values = {"IOR": (0.1, 0.4, 1.4), "Extinction": (4.0, 2.5, 1.9)}
        kind = {"fresnel_type": "PHYSICAL_CONDUCTOR", "Thin_Film_Thickness": 300.0}
        build.surface(build.node("ShaderNodeBsdfMetallic", **kind, **values))
        assert only(build)[1] == []
        film = program_of(build).closures[0].film
        np.testing.assert_allclose(film.index, values["IOR"])
        np.testing.assert_allclose(film.extinction, values["Extinction"])

    def test_film_is_seen_by_the_files_own_primaries(build):
        bpy.ops.wm.set_working_color_space(working_space="ACEScg", convert_colors=False)
        assert program_of(_principled(build)).closures[0].film.space == ACESCG


def _wall(**inputs):
    """A plane that fills the picture, seen aslant, of a film that gets thicker."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    material = bpy.data.materials.new("M")
    if material.node_tree is None:
        material.use_nodes = True
    tree = Tree(material.node_tree)
    thickness = tree.axis("X", 0.0, 800.0)
    inputs = {"Thin Film Thickness": thickness, "Roughness": 0.5} | inputs
    tree.surface(tree.made("ShaderNodeBsdfPrincipled", 0, inputs))
    bpy.ops.mesh.primitive_plane_add(size=2, rotation=(0.9, 0.0, 0.0))
    bpy.context.object.data.materials.append(material)
    bpy.ops.object.camera_add(location=(0.0, 0.0, 5.0))
    scene.camera = bpy.context.object
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 1.9
    scene.render.resolution_x, scene.render.resolution_y = 64, 4
    return scene


_PAINT = {"Base Color": (0.8, 0.5, 0.2), "Specular Tint": (1.0, 0.6, 0.3)}


@pytest.mark.parametrize("metallic", [0.0, 0.5, 1.0])
def test_color_passes_are_those_of_cycles(metallic, tmp_path):
    """Glossy Color and Diffuse Color have no noise. Of Blender 5.2's films up to .0004: its table
    differs by as much. Of the metal's part without a film .002: a table of albedos."""
    scene = _wall(**_PAINT, Metallic=metallic)
    names = ("diffuse_color", "glossy_color")
    theirs = render_cycles(scene, tmp_path, names)
    scene.iwis.pixel_filter, scene.iwis.max_samples = "CENTER", 1
    ours = by_pass(render_iwis(scene, tmp_path))
    five, four = ("Diffuse Color", "Glossy Color"), ("DiffCol", "GlossCol")
    for name in five if _OF_5 else four:
        limit = 4e-4 if _OF_5 else 4e-3 * metallic + 1e-5
        np.testing.assert_allclose(ours[name], theirs[name], atol=limit)
        assert np.ptp(theirs[name]) > 0.01 or (metallic == 1.0 and name in ("DiffCol", five[0]))
