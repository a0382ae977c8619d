"""How the eye sees light that interferes: the tables behind thin films [Belcour17].

Light that is reflected by both sides of a film has gone ways of two lengths. Of all its wavelengths
together a channel of the picture then has the part

    S(x) = sum_l s(l) exp(2 pi i x / l) / sum_l s(l),   x: the difference of both ways

where s is the channel's curve, a mixture of the colour matching functions of the CIE 1931 observer
[CIE31]. Cycles has S at 512 places, and straight lines between them: which are part of the model.
"""

from __future__ import annotations

import numpy as np

from ..data.observer import observer

TABLE_POINTS = 512
# What one step of the table is worth, in 1 / nm; its end is 60 um of phase.
STEPS_PER_NM = 2.0 * np.pi * (TABLE_POINTS - 1) / 60000.0
# Chromaticities of red, green, blue and white; ACEScg's is adapted to the white of the others.
_D65 = (0.3127, 0.3290)
_SPACES = {
    "Linear Rec.709": ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06), _D65),
    "Linear Rec.2020": ((0.708, 0.292), (0.170, 0.797), (0.131, 0.046), _D65),
    "ACEScg": ((0.713, 0.293), (0.165, 0.830), (0.128, 0.044), (0.32168, 0.33767)),
}
_BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)
THINNEST = np.float32(0.1)  # nm; below it Cycles sees no film
# ThinFilm.space: these three, and the Gaussians of the paper, which Cycles of Blender 4 has.
REC709, REC2020, ACESCG, GAUSSIANS = range(4)


def film_space(name: str) -> int:
    """The number of a working space by Blender's name; of others that of Linear Rec.709."""
    return list(_SPACES).index(name) if name in _SPACES else REC709


def _xyz(chromaticity) -> np.ndarray:
    x, y = chromaticity
    return np.array([x / y, 1.0, (1.0 - x - y) / y])


def _from_xyz(space: str) -> np.ndarray:
    """float64 (3, 3): linear red, green, blue of X, Y, Z."""
    *primaries, white = _SPACES[space]
    to_xyz = np.stack([_xyz(p) for p in primaries], 1)
    to_xyz = to_xyz * np.linalg.solve(to_xyz, _xyz(white))
    gains = (_BRADFORD @ _xyz(_D65)) / (_BRADFORD @ _xyz(white))
    adapted = np.linalg.inv(_BRADFORD) @ (gains[:, None] * _BRADFORD) @ to_xyz
    return np.linalg.inv(adapted)


def sensitivities() -> np.ndarray:
    """float32 (3, TABLE_POINTS, 6): of each space and difference of ways S of red, green, blue,
    its real part and then its imaginary one."""
    wavelengths, functions = observer()
    ways = np.arange(TABLE_POINTS) / STEPS_PER_NM
    waves = np.exp(2j * np.pi * ways[:, None] / wavelengths)
    tables = []
    for space in _SPACES:
        curves = functions @ _from_xyz(space).T
        found = waves @ (curves / curves.sum(0))
        tables.append(np.concatenate([found.real, found.imag], 1))
    return np.ascontiguousarray(tables, dtype=np.float32)
