"""core/nodes/wavelength.py: colors of single wavelengths."""

import numpy as np

from iwis.core.nodes.wavelength import wavelength


def xyz_of(*nanometres):
    """CIE XYZ over Cycles' scale."""
    inputs = {"Wavelength": np.float32(nanometres)}
    return wavelength(None, {"to_rgb": np.eye(3, dtype=np.float32)}, inputs)["Color"] * 2.52


def test_the_observer_is_that_of_1931():
    """Its highest values, and equal light of all wavelengths is white."""
    np.testing.assert_allclose(xyz_of(555.0)[0], [0.5121, 1.0, 0.0057], rtol=1e-4)
    np.testing.assert_allclose(xyz_of(600.0)[0, 0], 1.0622, rtol=1e-4)
    whole = xyz_of(*np.arange(380.0, 780.0)).sum(0)
    np.testing.assert_allclose(whole / whole[1], 1.0, atol=2e-3)  # of four digits
    np.testing.assert_allclose(whole[1], 106.857, rtol=1e-3)


def test_between_rows_colors_are_in_between():
    """Linear; a step before the first they go on, as in Cycles; beyond there is nothing."""
    np.testing.assert_allclose(xyz_of(557.5)[0], xyz_of(555.0, 560.0).mean(0), rtol=1e-5)
    ends = xyz_of(379.0, 375.0, 779.9, 780.0, np.nan, 1e30)
    assert ends[0, 0] > 0.0 and ends[2, 0] >= 0.0 and not ends[[1, 3, 4, 5]].any()
    np.testing.assert_allclose(ends[0, 0], 0.0014 - 0.2 * 0.0008, rtol=1e-3)


def test_nothing_is_negative():
    """What no mixture of the primaries has is cut off."""
    to_rgb = np.float32([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    found = wavelength(None, {"to_rgb": to_rgb}, {"Wavelength": np.float32([600.0])})["Color"]
    assert found[0, 0] == 0.0 and found[0, 1] > 0.0
