"""How the eye sees light that interferes: the tables behind thin films [Belcour17].

Light that is reflected by both sides of a film has gone ways of two lengths. Of all its wavelengths
together a channel of the picture then has the part

    S(x) = sum_l s(l) exp(2 pi i x / l) / sum_l s(l),   x: the difference of both ways

where s is the channel's curve, a mixture of the colour matching functions of the CIE 1931 observer
[CIE31]. Cycles has S at 512 places, and straight lines between them: which are part of the model.
"""

from __future__ import annotations

import numpy as np

# The colour matching functions x, y and z, in 1e-4, from 380 to 780 nm in steps of 5.
_OBSERVER = """
14 0 65  22 1 105  42 1 201  76 2 362  143 4 679  232 6 1102  435 12 2074  776 22 3713
1344 40 6456  2148 73 10391  2839 116 13856  3285 168 16230  3483 230 17471  3481 298 17826
3362 380 17721  3187 480 17441  2908 600 16692  2511 739 15281  1954 910 12876
1421 1126 10419  956 1390 8130  580 1693 6162  320 2080 4652  147 2586 3533  49 3230 2720
24 4073 2123  93 5030 1582  291 6082 1117  633 7100 782  1096 7932 573  1655 8620 422
2257 9149 298  2904 9540 203  3597 9803 134  4334 9950 87  5121 10000 57  5945 9950 39
6784 9786 27  7621 9520 21  8425 9154 18  9163 8700 17  9786 8163 14  10263 7570 11
10567 6949 10  10622 6310 8  10456 5668 6  10026 5030 3  9384 4412 2  8544 3810 2
7514 3210 1  6424 2650 0  5419 2170 0  4479 1750 0  3608 1382 0  2835 1070 0  2187 816 0
1649 610 0  1212 446 0  874 320 0  636 232 0  468 170 0  329 119 0  227 82 0  158 57 0
114 41 0  81 29 0  58 21 0  41 15 0  29 10 0  20 7 0  14 5 0  10 4 0  7 2 0  5 2 0
3 1 0  2 1 0  2 1 0  1 0 0  1 0 0  1 0 0  0 0 0
"""
_FIRST, _STEP = 380.0, 5.0  # nm
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


def observer() -> tuple[np.ndarray, np.ndarray]:
    """(wavelengths (81,), nm; colour matching functions (81, 3)), float64."""
    functions = np.array(_OBSERVER.split(), np.float64).reshape(-1, 3) * 1e-4
    return _FIRST + _STEP * np.arange(len(functions)), functions


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
