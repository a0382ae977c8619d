"""No choice that Blender's nodes have ends a render: each is in the core's tables."""

import bpy
import numpy as np
import pytest

from iwis.core.nodes.arithmetic import math, vector_math
from iwis.core.nodes.color import BLEND


def _choices(node, name) -> list[str]:
    return [item.identifier for item in getattr(bpy.types, node).bl_rna.properties[name].enum_items]


@pytest.mark.parametrize("operation", _choices("ShaderNodeMath", "operation"))
def test_math_has_every_operation(operation):
    """A value for each of three points."""
    numbers = np.float32([-0.7, 0.0, 1.3])
    inputs = {"Value": numbers, "Value_001": numbers + 0.5, "Value_002": numbers}
    with np.errstate(all="ignore"):
        found = math(None, {"operation": operation, "use_clamp": False}, inputs)["Value"]
    assert np.shape(found) == (3,)


@pytest.mark.parametrize("operation", _choices("ShaderNodeVectorMath", "operation"))
def test_vector_math_has_every_operation(operation):
    """A vector or a number for each of two points."""
    vectors = np.float32([[-0.7, 0.1, 1.3], [0.2, 0.4, -2.0]])
    names = ("Vector", "Vector_001", "Vector_002")
    inputs = {name: vectors + k for k, name in enumerate(names)} | {"Scale": np.float32(0.5)}
    with np.errstate(all="ignore"):
        found = vector_math(None, {"operation": operation}, inputs)
    assert np.shape(found["Vector"]) == (2, 3) or np.shape(found["Value"]) == (2,)


def test_mix_has_every_blend_type():
    """Of Mix and of the MixRGB of older files."""
    for node in ("ShaderNodeMix", "ShaderNodeMixRGB"):
        assert set(_choices(node, "blend_type")) <= set(BLEND)
