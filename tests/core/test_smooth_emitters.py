"""Faces that shine light coarse smooth meshes from below their faces, as lamps and Cycles do."""

import numpy as np
import pytest

from iwis.core.data.lamps import RECTANGLE, make_lamps
from iwis.core.lamplight.emitters import with_emitters
from support.scenes import (
    camera_above,
    constant_world,
    diffuse,
    glossy,
    make_mesh,
    make_picture,
    make_scene,
    quad,
    sphere,
)

RADIANCE = np.array([[3.0, 2.0, 1.0]], np.float32)
# A square beside and a little below the middle of a ball, which the camera sees from above.
CENTER, SIDE = np.array([1.5, 0.1, -0.3]), 0.5


def _light(lamps, material):
    """The mean of a ball's picture, its rays lifted to the smooth patch over each face."""
    scene = make_scene(
        [sphere(radius=0.8, rings=5, smooth=True)],
        [material],
        constant_world((0.0, 0.0, 0.0)),
        camera_above(24, 24),
        lamps=lamps,
        terminator_offset=np.full(1, 0.1, np.float32),
    )
    return make_picture(scene, max_samples=256)[0]["combined"][..., :3].mean()


@pytest.mark.parametrize("material", [diffuse(), glossy(0.4)], ids=["diffuse", "gloss"])
def test_a_mesh_lights_coarse_smooth_faces_from_below(material):
    """As the rectangle in its place: both draw 16 and 64 samples. 1 %: three times their noise."""
    row = {"kind": RECTANGLE, "position": CENTER, "size": (SIDE, SIDE), "radiance": RADIANCE[0]}
    row |= {"right": (0.0, 1.0, 0.0), "up": (0.0, 0.0, 1.0), "forward": (-1.0, 0.0, 0.0)}
    corner = CENTER - (0.0, SIDE / 2, SIDE / 2)
    square = make_mesh(quad(corner, (0.0, SIDE, 0.0), (0.0, 0.0, SIDE)))
    found = _light(with_emitters([], square, RADIANCE), material)
    assert found == pytest.approx(_light(make_lamps([row]), material), rel=0.01)
