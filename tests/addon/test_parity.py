"""A part of the parity suite (`make parity` runs all of it): one in ten of those without noise, and
of the others a few lamps, worlds, mixtures, depth of field and motion."""

import pytest
from parity.all_cases import ALL_CASES
from parity.compare import run_case
from parity.why import WHY

_NOISY = (
    "Spot, scaled",
    "Sun, 5 degrees",
    "Area DISK, spread 60",
    "Emissive plane, roughness 0.15",
    "Camera depth of field of glowing checks",
    "Mix, three closures",
    "World, ramp by height",
    "Curves, metal",
    "Subsurface: share varies",
    "Linking: two lamps",
    "Linking: emissive plane, shiny",
    "Motion of shape keys",
    "Ambient Occlusion as a mask of dirt",
    "Bevel of a matte surface",
    "Displacement of vertices and bump",
)
_CHOSEN = [case for case in ALL_CASES if not case.noisy and case.name not in WHY][::10]
_CHOSEN += [case for case in ALL_CASES if case.name in _NOISY]


@pytest.mark.slow
@pytest.mark.parametrize("case", _CHOSEN, ids=lambda case: case.name)
def test_case_agrees_with_cycles(scene, case, tmp_path):
    """Difference and bias of at most 1 %: parity/compare.py says what is left out, and why."""
    result = run_case(case, tmp_path)
    assert result.agrees, (result.difference, result.bias, result.odd, result.warnings)
