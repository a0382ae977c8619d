"""core/see_through/opacity.py: what grids on triangles say of patterns that cut them out."""

import numpy as np
import pytest

from iwis.core.data.program import Closure, Op, Program, Ref
from iwis.core.scene import DIFFUSE, GGX
from iwis.core.see_through.opacity import bake_opacity
from support.programs import with_programs
from support.scenes import camera_at, constant_world, diffuse, make_scene, quad

_POSITION = Op("ShaderNodeNewGeometry", {}, {"outputs": {"Position"}})


def _grids(colored, *ops):
    """Opacity of a square of 100 metres, two triangles, by the last of the ops after _POSITION."""
    closure = Closure(DIFFUSE, GGX, np.ones(3, np.float32), {})
    program = Program(ops=(_POSITION, *ops), closures=(closure,), transparent=Ref(len(ops), ""))
    part = quad((0.0, 0.0, 0.0), (100.0, 0.0, 0.0), (0.0, 100.0, 0.0))
    camera = camera_at((50.0, 50.0, 200.0), (50.0, 50.1, 0.0), 8, 8, 0.5)
    scene = with_programs(make_scene([part], [diffuse()], constant_world(), camera), program)
    return bake_opacity(scene, np.ones(2, bool), colored)


@pytest.mark.parametrize("colored", [True, False])
def test_grid_follows_its_program(colored):
    """A pattern along x, red: values at the corners of the grid, exactly; triangles apart. Of all
    colors alike the mean is kept."""
    ramp = Op("scale", {"Color": Ref(0, "Position"), "Factor": np.float32(0.01)}, {})
    opacity = _grids(colored, ramp)
    assert sorted(opacity.row) == [0, 1] and opacity.colored == colored
    side = int(opacity.side[0])
    grid = opacity.values[opacity.start[0] :][: side + 1] / 255.0  # the first edge: along x, z = 0
    red = np.arange(side + 1) / side
    np.testing.assert_allclose(grid, red if colored else red / 3.0, atol=0.5 / 255 + 1e-6)


@pytest.mark.parametrize("threads", [191, 192, 193])
def test_many_threads_of_few_triangles_keep_their_share(threads):
    """Six tenths of a curtain are open. In steps of a 64th, three threads each, all of it would be
    or nothing; of a 512th, a half of it. Within 5 standard errors of 131 841 independent places."""

    def number(operation, **inputs):
        values = {"operation": operation, "use_clamp": False, "before": False}
        return Op("ShaderNodeMath", inputs, values)

    opacity = _grids(
        False,
        Op("ShaderNodeSeparateXYZ", {"Vector": Ref(0, "Position")}, {}),
        number("MULTIPLY", Value=Ref(1, "X"), Value_001=np.float32(threads / 100.0)),
        number("FRACT", Value=Ref(2, "Value")),
        number("GREATER_THAN", Value=Ref(3, "Value"), Value_001=np.float32(0.4)),
        Op("convert", {"Value": Ref(4, "Value")}, {"source": "NUMBER", "target": "COLOR"}),
    )
    assert abs(opacity.values.mean() / 255.0 - 0.6) < 0.007
