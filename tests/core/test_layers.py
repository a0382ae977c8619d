"""What a coat leaves over for what is under it (core/nodes/layers.py)."""

import numpy as np
import pytest

from iwis.core.nodes.layers import under_coat
from iwis.core.scene import MULTI_GGX, PRINCIPLED
from support.brdf_points import directions, evaluated, points, sphere_quadrature

_ONE = np.ones(3, np.float32)


class _Seen:
    """A context of one point that looks up."""

    normal = geometric_normal = np.float32([[0.0, 0.0, 1.0]])

    def __init__(self, cosine):
        self.wo = directions([cosine])

    def __len__(self):
        return 1


@pytest.mark.parametrize(
    ("cosine", "roughness"), [(0.9, 0.5), (0.17, 0.3), (0.17, 1.0), (0.5, 0.6)]
)
def test_coat_and_white_under_it_reflect_everything(cosine, roughness):
    """.8 %: so far Cycles' own table of what a layer reflects is off, seen flat."""
    inputs = {"Weight": _ONE, "Coat": _ONE[0], "Tint": _ONE, "IOR": np.float32(1.5)}
    left = under_coat(_Seen(cosine), {}, inputs | {"Roughness": np.float32(roughness)})[""]
    coat = {"base_color": (0.0, 0.0, 0.0), "roughness": roughness, "ior": 1.5}
    lobes = points(directions([cosine]), model=PRINCIPLED, distribution=MULTI_GGX, **coat)
    wi, solid_angle = sphere_quadrature()
    reflected = float(evaluated(lobes, 0, wi)[:, 3] @ solid_angle)
    assert reflected + left[0] == pytest.approx(np.ones(3), abs=0.008)


def test_coat_takes_what_it_reflects():
    """Along the normal: 1 - F0 of its index, times its tint; no coat takes nothing."""
    inputs = {"Weight": np.float32([0.8] * 3), "IOR": np.float32(1.5), "Roughness": np.float32(0.1)}
    tint = np.float32([0.5, 1.0, 1.0])

    def left(share):
        return under_coat(_Seen(1.0), {}, inputs | {"Coat": np.float32(share), "Tint": tint})[""]

    np.testing.assert_allclose(left(0.0), [[0.8] * 3], rtol=1e-6)
    np.testing.assert_allclose(left(1.0)[0], 0.8 * 0.96 * tint, rtol=2e-3)  # a table of albedos
    np.testing.assert_allclose(left(0.5)[0], 0.8 * 0.98 * (0.5 + 0.5 * tint), rtol=2e-3)
