"""Materials of the open file with a grain, sheen, toon or Ashikhmin and Shirley's lobe."""

import numpy as np
import pytest

from iwis.core.data.program import Ref
from iwis.core.nodes.layers import grain
from iwis.core.scene import (
    ASHIKHMIN_SHIRLEY,
    BECKMANN,
    DIFFUSE,
    GLOSSY,
    GLOSSY_TOON,
    SHEEN,
    TOON,
    VELVET_SHEEN,
)
from support.material_builds import Build, only, program_of


@pytest.fixture
def build(scene):
    return Build()


ISOTROPIC = [
    ("ShaderNodeBsdfPrincipled", {"Anisotropic": 0.0}),
    ("ShaderNodeBsdfAnisotropic", {"Anisotropy": 0.0, "Rotation": 0.3}),
    ("ShaderNodeBsdfMetallic", {"Anisotropy": 0.0}),
]


@pytest.mark.parametrize(("kind", "values"), ISOTROPIC)
def test_round_gloss_needs_no_program(build, kind, values):
    build.surface(build.node(kind, **values))
    assert program_of(build) is None


STRETCHED = [
    ("ShaderNodeBsdfPrincipled", {"Anisotropic": 0.5}),
    ("ShaderNodeBsdfAnisotropic", {"Anisotropy": -0.5}),
    ("ShaderNodeBsdfMetallic", {"Anisotropy": 0.5}),
]


@pytest.mark.parametrize(("kind", "values"), STRETCHED)
def test_stretched_gloss_has_a_grain_and_no_warning(build, kind, values):
    assert only(build.surface(build.node(kind, **values)))[1] == []
    (closure,) = program_of(build).closures
    assert isinstance(closure.grain, Ref)


@pytest.mark.parametrize(
    ("direction", "request_of"), [("RADIAL", "generated"), ("UV_MAP", "tangent:")]
)
def test_tangent_node_asks_the_mesh(build, direction, request_of):
    """Generated coordinates, or the tangents of the active UV map."""
    from iwis.iwis_addon.export.shaders.material import export_shaders

    tangent = build.node("ShaderNodeTangent", direction_type=direction)
    links = [("Tangent", tangent.outputs[0])]
    build.surface(build.node("ShaderNodeBsdfAnisotropic", links=links, Anisotropy=0.5))
    assert export_shaders([build.material], []).requests == (frozenset({request_of}),)


@pytest.mark.parametrize(
    ("model", "amount", "length"),
    [
        ("ASPECT", 0.9, 0.19**-0.5),
        ("GLOSSY", 0.5, 0.5),
        ("GLOSSY", -0.5, 2.0),
        ("ASPECT", -1.0, 1.0),
    ],
)
def test_grain_turns_and_stretches(model, amount, length):
    """A quarter turn about the normal; the length is the root of alpha_x / alpha_y."""

    class Up:
        normal = np.float32([[0.0, 0.0, 1.0]])

        def __len__(self):
            return 1

    inputs = {"Anisotropy": np.float32(amount), "Rotation": np.float32(0.25)}
    inputs["Tangent"] = np.float32([1.0, 0.0, 0.0])
    found = grain(Up(), {"model": model}, inputs)[""]
    np.testing.assert_allclose(found, [[0.0, length, 0.0]], atol=1e-6)


def test_sheen_is_a_closure_over_the_rest(build):
    """Of its own, times its weight and tint, first; what is under it gets what it leaves."""
    tint = (1.0, 0.5, 0.2, 1.0)
    node = build.node(
        "ShaderNodeBsdfPrincipled", Sheen_Weight=0.5, Sheen_Roughness=0.3, Sheen_Tint=tint
    )
    _, warnings = only(build.surface(node))
    assert not warnings
    sheen, base = program_of(build).closures
    assert sheen.model == SHEEN and isinstance(base.weight, Ref)
    np.testing.assert_allclose(sheen.weight, [0.5, 0.25, 0.1], rtol=1e-6)
    np.testing.assert_allclose(sheen.params["roughness"], 0.3, rtol=1e-6)


@pytest.mark.parametrize(
    ("distribution", "model"), [("MICROFIBER", SHEEN), ("ASHIKHMIN", VELVET_SHEEN)]
)
def test_sheen_node(build, distribution, model):
    node = build.node("ShaderNodeBsdfSheen", distribution=distribution, Color=(0.2, 0.3, 0.4, 1.0))
    row, warnings = only(build.surface(node))
    assert not warnings and row["model"] == DIFFUSE  # mode PAPER
    (closure,) = program_of(build).closures
    assert closure.model == model


@pytest.mark.parametrize(
    ("component", "model", "nearest"), [("DIFFUSE", TOON, DIFFUSE), ("GLOSSY", GLOSSY_TOON, GLOSSY)]
)
def test_toon_node(build, component, model, nearest):
    """A closure of its own; the row, for mode PAPER, has a lobe about as wide, which is smooth."""
    values = {"Size": 0.3, "Smooth": 0.2, "Color": (0.2, 0.3, 0.4, 1.0)}
    row, warnings = only(
        build.surface(build.node("ShaderNodeBsdfToon", **values, component=component))
    )
    assert not warnings and row["model"] == nearest and row["diffuse_roughness"] == 0.0
    np.testing.assert_allclose(row["roughness"], (0.4 * np.pi / 2.0 / 8.0**0.5) ** 0.5, rtol=1e-6)
    (closure,) = program_of(build).closures
    assert closure.model == model
    np.testing.assert_allclose(closure.params["roughness"], 0.3, rtol=1e-6)
    np.testing.assert_allclose(closure.params["diffuse_roughness"], 0.2, rtol=1e-6)


def test_ashikhmin_shirley(build):
    """A closure, whose row is Beckmann's."""
    node = build.node("ShaderNodeBsdfGlossy", distribution="ASHIKHMIN_SHIRLEY", Roughness=0.5)
    row, warnings = only(build.surface(node))
    (closure,) = program_of(build).closures
    assert (row["model"], row["distribution"], warnings) == (GLOSSY, BECKMANN, [])
    assert (closure.model, closure.distribution) == (GLOSSY, ASHIKHMIN_SHIRLEY)
