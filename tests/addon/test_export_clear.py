"""Materials of the open file that let light through."""

import numpy as np
import pytest

from iwis.core.nodes.typical import mean_value
from iwis.core.scene import DIFFUSE, TRANSLUCENT
from support.material_builds import Build, only, program_of


@pytest.fixture
def build(scene):
    return Build()


def test_alpha_and_transparent_shaders_let_light_through(build):
    """Principled's alpha and a share of Transparent add up; what is left reflects and glows."""
    paint = build.node(
        "ShaderNodeBsdfPrincipled",
        Alpha=0.25,
        Emission_Strength=1.0,
        Emission_Color=(0.0, 1.0, 0.0, 1.0),
    )
    clear = build.node("ShaderNodeBsdfTransparent")
    mix = build.node("ShaderNodeMixShader", links=[(1, paint.outputs[0]), (2, clear.outputs[0])])
    mix.inputs[0].default_value = 0.5
    _, warnings = only(build.surface(mix))
    assert warnings == []
    program = program_of(build)
    np.testing.assert_allclose(program.transparent, [0.5 * 0.75 + 0.5] * 3)
    np.testing.assert_allclose(program.closures[0].weight, [0.125] * 3)
    np.testing.assert_allclose(program.emission, [0.0, 0.125, 0.0])


def test_opaque_alpha_needs_no_program(build):
    node = build.node("ShaderNodeBsdfPrincipled", Alpha=1.0)
    only(build.surface(node))
    assert program_of(build) is None


def test_colored_transparency(build):
    """Its shadow has the color, unless the ray has a say in how much passes, by more than the angle
    at which it comes: that is told."""
    tint = build.node("ShaderNodeBsdfTransparent", Color=(0.9, 0.5, 0.1, 1.0))
    assert only(build.surface(tint))[1] == []
    mix, facing = build.node("ShaderNodeMixShader"), build.node("ShaderNodeLayerWeight")
    build.link(facing.outputs["Facing"], mix.inputs[0])
    build.link(tint.outputs[0], mix.inputs[1])
    assert only(build.surface(mix))[1] == []
    build.link(build.node("ShaderNodeNewGeometry").outputs["Incoming"], mix.inputs[0])
    warnings = only(build.surface(mix))[1]
    assert len(warnings) == 1 and "grey shadow" in warnings[0]
    assert only(build.surface(tint))[1] == []
    np.testing.assert_allclose(program_of(build).transparent, [0.9, 0.5, 0.1], rtol=1e-6)


def test_translucent(build):
    """A closure of its own, never a row of the table alone."""
    leaf = build.node("ShaderNodeBsdfTranslucent", Color=(0.1, 0.8, 0.2, 1.0))
    row, warnings = only(build.surface(leaf))
    assert not warnings and row["model"] == DIFFUSE
    (closure,) = program_of(build).closures
    assert closure.model == TRANSLUCENT
    np.testing.assert_allclose(closure.params["base_color"], [0.1, 0.8, 0.2], rtol=1e-6)


def _shares(program):
    """(what passes, weights of the closures) along the normal, of a program."""
    weights = [mean_value(program, closure.weight) for closure in program.closures]
    return mean_value(program, program.transparent), weights


@pytest.mark.parametrize("kind", ["Glass", "Refraction"])
def test_glass_lets_light_straight_through(build, kind):
    """Told; glass reflects as a clear layer does, and its color is that of both parts."""
    glass = build.node(f"ShaderNodeBsdf{kind}", Color=(0.5, 1.0, 1.0, 1.0), IOR=1.5, Roughness=0.1)
    warnings = only(build.surface(glass))[1]
    assert len(warnings) == 1 and "straight through" in warnings[0]
    through, weights = _shares(program_of(build))
    left = 0.96 if kind == "Glass" else 1.0
    np.testing.assert_allclose(through, [0.5 * left, left, left], rtol=2e-3)
    reflected = [0.5, 1.0, 1.0] if kind == "Glass" else [1.0, 1.0, 1.0]
    np.testing.assert_allclose(weights[0], reflected, rtol=1e-6)


@pytest.mark.parametrize("metallic", [0.0, 0.4, 1.0])
def test_transmission_is_shared_with_metal_and_diffuse(build, metallic):
    """.75 of what is no metal is glass: the weights add up to 1; the tint is the root of .25."""
    values = {"Transmission_Weight": 0.75, "Metallic": metallic, "Base_Color": (0.25,) * 3 + (1.0,)}
    node = build.node("ShaderNodeBsdfPrincipled", IOR=1.5, Roughness=0.1, **values)
    warnings = only(build.surface(node))[1]
    if metallic == 1.0:
        assert not warnings and program_of(build) is None
        return
    assert len(warnings) == 1 and "straight through" in warnings[0]
    through, weights = _shares(program_of(build))
    np.testing.assert_allclose(through, 0.75 * (1.0 - metallic) * 0.96 * 0.5, rtol=3e-3)
    np.testing.assert_allclose(np.sum(weights, axis=0), 1.0, rtol=1e-6)


def _mixed(build, kind, *shaders):
    """A Mix or Add Shader of two."""
    first = 1 if kind == "Mix" else 0
    links = [(first + k, shader.outputs[0]) for k, shader in enumerate(shaders)]
    return build.node(f"ShaderNode{kind}Shader", links=links)


def test_what_is_added_to_a_transparent_shader_has_its_weight(build):
    """More than passes leaves: the program says how much. Else it is what passes leaves."""
    clear, matte = build.node("ShaderNodeBsdfTransparent"), build.node("ShaderNodeBsdfDiffuse")
    glow = build.node("ShaderNodeEmission")
    sum_ = _mixed(build, "Add", clear, _mixed(build, "Add", matte, glow))
    only(build.surface(sum_))
    np.testing.assert_allclose(program_of(build).shown, [1.0] * 3)
    mix = _mixed(build, "Mix", sum_, matte)
    mix.inputs[0].default_value = 0.25
    only(build.surface(mix))
    np.testing.assert_allclose(program_of(build).shown, [1.0] * 3)  # 0.75 + 0.25
    np.testing.assert_allclose(program_of(build).transparent, [0.75] * 3)
    only(build.surface(_mixed(build, "Mix", clear, _mixed(build, "Add", matte, glow))))
    assert program_of(build).shown is None
