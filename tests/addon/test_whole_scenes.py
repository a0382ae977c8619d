"""A small part of the whole scenes (`make whole-scenes` renders all)."""

import bpy
import numpy as np
import pytest
from whole_scenes import assets, operators, templates
from whole_scenes.listing import row
from whole_scenes.measure import compared, measure

_CHOSEN = (
    "General (factory startup)",
    "object.pointcloud_random_add",
    "object.quick_smoke",
)
_SAMPLES = 64  # noise of Cycles in a block: 2 %, of the limit of 3


@pytest.mark.slow
@pytest.mark.parametrize("name", _CHOSEN)
def test_scene_is_the_same_as_in_cycles(scene, name, tmp_path):
    """Means within 1 %, blocks within 3 % of Cycles': measure.py says why."""
    whole = next(w for w in templates.scenes() + operators.scenes() if w.name == name)
    result = measure(whole, tmp_path, _SAMPLES)
    if result.state == "missing":
        assert "is not in this Blender" in result.remark or bpy.app.version < (5, 0)
        return
    assert result.state == "same", result[:7]
    assert len(result.lines) == ("smoke" in name)  # its volume is left out


@pytest.mark.slow
def test_hair_asset_is_rendered(scene, tmp_path):
    """One of Blender's hair node groups, on a hair object of its own."""
    path = next(path for path in assets.files() if "hair_node" in path.name)
    assert assets.scene_of(path, "Curve Tip") is None
    result = measure(assets.scene_of(path, "Frizz Hair Curves"), tmp_path, _SAMPLES)
    assert result.state == "same" and result.lines == (), result[:7]


def test_black_and_other_light_are_found():
    """One dark block is black, another mean differs; what is not finite has failed."""
    picture = np.full((48, 72, 4), 0.5, np.float32)
    dark = picture.copy()
    dark[6:12, 12:18] = 0.0
    assert compared(picture, picture)[0] == "same"
    assert compared(1.02 * picture, picture)[0] == "differs"
    assert compared(dark, picture)[0] == "black"
    assert compared(dark, dark)[0] == "same"
    assert compared(picture * np.nan, picture)[0] == "failed"


def test_failure_is_a_row_of_the_table(scene, tmp_path):
    """A scene that IWIS refuses is told with its reason, and the program goes on."""
    from whole_scenes.stage import Whole, stage

    def build():
        stage()[0].camera = None

    result = measure(Whole("operator", "blind", build), tmp_path, _SAMPLES)
    assert result.state == "failed"
    assert row(result, {"blind": "no camera"}).startswith(
        "| operator | blind | **failed** | | | no camera; "
    )
