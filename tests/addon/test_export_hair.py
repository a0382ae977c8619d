"""Materials of the open file that are hair."""

import numpy as np
import pytest

from iwis.core.data.program import HAIR_BELL_REFLECTION, HAIR_BELL_TRANSMISSION, HAIR_CHIANG, Ref
from iwis.core.scene import DIFFUSE, TRANSLUCENT
from support.material_builds import Build, only, program_of


@pytest.fixture
def build(scene):
    return Build()


def _asked(build):
    from iwis.iwis_addon.export.shaders.material import export_shaders

    return export_shaders([build.material], []).requests[0]


@pytest.mark.parametrize("parametrization", ["COLOR", "MELANIN", "ABSORPTION"])
def test_principled_hair_is_there_on_both_sides(build, parametrization):
    """Without a warning; the mesh is asked for the strands' directions and random numbers."""
    node = build.node("ShaderNodeBsdfHairPrincipled", parametrization=parametrization, Coat=0.25)
    assert only(build.surface(node))[1] == []
    front, behind = program_of(build).closures
    assert (front.model, behind.model) == (DIFFUSE, TRANSLUCENT)
    assert front.hair == behind.hair and front.hair.model == HAIR_CHIANG
    assert isinstance(front.hair.tangent, Ref) and front.hair.coat == np.float32(0.25)
    assert _asked(build) >= {"element:Tangent", "element:Random"}


def test_huang_is_told_of(build):
    warnings = only(build.surface(build.node("ShaderNodeBsdfHairPrincipled", model="HUANG")))[1]
    (warning,) = warnings
    assert "Huang is not supported: rendered as Chiang" in warning
    assert len(program_of(build).closures) == 2


@pytest.mark.parametrize(
    ("component", "model"),
    [("Reflection", HAIR_BELL_REFLECTION), ("Transmission", HAIR_BELL_TRANSMISSION)],
)
def test_hair_bsdf(build, component, model):
    """Its offset is a strand's alone, unless a tangent is given, as in Cycles."""
    assert only(build.surface(build.node("ShaderNodeBsdfHair", component=component)))[1] == []
    closures = program_of(build).closures
    assert [closure.hair.model for closure in closures] == [model, model]
    assert isinstance(closures[0].hair.offset, Ref)
    tangent = build.node("ShaderNodeTangent").outputs[0]
    node = build.node("ShaderNodeBsdfHair", links=[("Tangent", tangent)], Offset=0.5)
    build.surface(node)
    assert program_of(build).closures[0].hair.offset == np.float32(0.5)


def test_paper_has_hair_as_diffuse_of_its_color(build):
    """The row that the tables of mode PAPER are made of."""
    node = build.node("ShaderNodeBsdfHairPrincipled")
    node.inputs["Color"].default_value = (0.5, 0.3, 0.1, 1.0)
    row = only(build.surface(node))[0]
    assert row["model"] == DIFFUSE
    np.testing.assert_allclose(row["base_color"], (0.5, 0.3, 0.1), rtol=1e-4)
