"""Subsurface leaves Blender as Cycles reads it. (Pictures: tests/parity.)"""

import bpy
import numpy as np
import pytest

from iwis.core.data.program import Ref
from iwis.core.nodes import Evaluation
from iwis.core.scene import DIFFUSE, PRINCIPLED
from iwis.core.walks.subsurface import LEGACY, SKIN, VAN_DE_HULST
from iwis.iwis_addon.export.shaders.material import export_shaders
from support.material_builds import Build

RANDOM_WALK = VAN_DE_HULST if bpy.app.version >= (5, 2) else LEGACY


@pytest.fixture
def build(scene):
    return Build()


def _closure(build):
    warnings = []
    program = export_shaders([build.material], warnings).programs[0]
    assert len(program.closures) == 1
    return program, program.closures[0], warnings


def _number(program, value):
    """Of a constant, or of an operation of constants."""
    return Evaluation(program, None).number(value) if isinstance(value, Ref) else value


def test_principled_scatters_as_its_inputs_say(build):
    node = build.node("ShaderNodeBsdfPrincipled", subsurface_method="RANDOM_WALK_SKIN")
    given = {
        "Subsurface Weight": 0.25,
        "Subsurface Radius": (1.0, 0.5, 0.25),
        "Subsurface Scale": 0.1,
        "Subsurface IOR": 1.3,
        "Subsurface Anisotropy": 0.6,
        "Roughness": 0.4,
        "IOR": 1.7,
    }
    for name, value in given.items():
        node.inputs[name].default_value = value
    _, closure, warnings = _closure(build.surface(node))
    under = closure.subsurface
    assert (closure.model, under.method, warnings) == (PRINCIPLED, SKIN, [])
    np.testing.assert_allclose(under.radius, [0.1, 0.05, 0.025], rtol=1e-6)
    found = [under.share, under.anisotropy, under.ior, under.roughness]
    np.testing.assert_allclose(found, [0.25, 0.6, 1.3, 0.4], rtol=1e-6)
    node.subsurface_method = "RANDOM_WALK"  # of which the index is the surface's
    under = _closure(build)[1].subsurface
    assert under.method == RANDOM_WALK and under.ior == pytest.approx(1.7)


def test_the_scattering_node_is_all_subsurface(build):
    """Its roughness is that of the facets."""
    node = build.node("ShaderNodeSubsurfaceScattering", falloff="RANDOM_WALK")
    node.inputs["Roughness"].default_value = 0.25
    program, closure, warnings = _closure(build.surface(node))
    assert closure.model == DIFFUSE and closure.subsurface.share == 1.0 and not warnings
    assert _number(program, closure.subsurface.roughness) == pytest.approx(0.5)


def test_no_weight_is_no_subsurface(build):
    """The material stays a row."""
    node = build.node("ShaderNodeBsdfPrincipled")
    node.inputs["Subsurface Weight"].default_value = 0.0
    assert export_shaders([build.surface(node).material], []).programs == (None,)


@pytest.mark.parametrize("kind", ["ShaderNodeBsdfPrincipled", "ShaderNodeSubsurfaceScattering"])
def test_burley_is_told(build, kind):
    """Its inputs are fewer than those of the others."""
    node = build.node(kind)
    build.surface(node)
    if kind == "ShaderNodeBsdfPrincipled":
        node.subsurface_method = "BURLEY"
        node.inputs["Subsurface Weight"].default_value = 1.0
    else:
        node.falloff = "BURLEY"
    _, closure, warnings = _closure(build)
    assert closure.subsurface.method == LEGACY
    assert len(warnings) == 1 and "Christensen-Burley" in warnings[0]
