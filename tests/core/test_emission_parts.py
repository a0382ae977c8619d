"""emission_parts.py: parts of faces have the light of what shines on them, however small it is."""

import numpy as np
import pytest

from iwis.core.lamplight import emission_parts
from iwis.core.lamplight.emitter_tree import areas_of
from iwis.core.scene import TriangleMesh

FACES = 144  # of twelve houses
CELLS, WINDOW, LIT = 8, 0.25, 0.25  # along a face; of a cell's side; of the cells


def _houses():
    """Triangles of equal area, one behind the other."""
    corner = np.float32([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    away = np.arange(FACES, dtype=np.float32)[:, None, None] * np.float32([0.0, 0.0, 2.0])
    return TriangleMesh(
        vertices=(corner + away).reshape(-1, 3).astype(np.float32),
        triangles=np.arange(3 * FACES, dtype=np.int32).reshape(-1, 3),
        corner_normals=np.zeros((FACES, 3, 3), np.float32),
        material_index=np.zeros(FACES, np.int32),
        object_index=np.zeros(FACES, np.int32),
    )


def _windows(face, places):
    """Radiance (n, 2, 3): a window in the middle of each cell that is lit, else black."""
    cell = np.floor(places * CELLS).astype(int)
    inside = (np.abs(places * CELLS - cell - 0.5) < 0.5 * WINDOW).all(axis=1)
    number = (face * 7919 + cell[:, 0] * 104729 + cell[:, 1] * 1299709) % 1009
    light = np.where(inside & (number < LIT * 1009), 20.0, 0.0)
    return np.broadcast_to(light[:, None, None], (len(face), 2, 3))


def _half(face, places):
    """Radiance (n, 2, 3): bright where the second corner's weight is less than a half."""
    light = np.where(places[:, 0] < 0.5, 3.0, 0.0)
    return np.broadcast_to(light[:, None, None], (len(face), 2, 3))


def _power_of(light, face, steps=512):
    """Its mean over the faces, by a fine grid."""
    u, v = (a.ravel() for a in np.mgrid[0:steps, 0:steps] + 0.5)
    places = (np.column_stack([u, v]) / steps)[u + v < steps]
    return np.mean([light(np.full(len(places), f), places)[:, 0, 0].mean() for f in face])


@pytest.mark.parametrize("light", [_windows, _half])
def test_parts_have_the_light_of_what_shines_on_them(light):
    """A window is a thirtieth of the largest part, and an eighth of its quarters."""
    mesh, face = _houses(), np.arange(FACES)
    of, corners, mean = emission_parts._varying(mesh, face, light)
    power = np.bincount(of, areas_of(corners) * mean[:, 0, 0], FACES) / 0.5
    # 2^18 points, of which 1 / 64 meet a window: 1.6 % if they were independent.
    assert power.mean() == pytest.approx(_power_of(light, face), rel=0.016)
    own = np.array([_power_of(light, [f]) for f in face])
    # A face has 1 / 144 of these points, but even ones, and its parts are looked at again.
    assert np.abs(power / own - 1.0).mean() < 0.1
