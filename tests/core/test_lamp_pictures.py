"""Pictures under lamps: with the world, cut out of a whole, in deep shadow."""

import numpy as np
import pytest

from iwis.core.data.lamps import (
    RECTANGLE,
    SPHERE,
    make_lamps,
)
from support.lamp_rows import area
from support.scenes import (
    box,
    camera_above,
    constant_world,
    diffuse,
    floor,
    make_picture,
    make_scene,
    principled,
)

DARK = constant_world((0.0, 0.0, 0.0))
MATTE = diffuse((0.8, 0.5, 0.3))
PAINT = principled(base_color=(0.2, 0.4, 0.6), roughness=0.4)


def lamp_picture(rows, world=DARK, material=PAINT, region=None, **settings):
    parts = [floor(1.0), box((-0.3, -0.3, 0.2), (0.2, 0.2, 0.5))]
    camera = camera_above(24, 24, region=region)
    scene = make_scene(parts, [material] * 2, world, camera, lamps=make_lamps(rows))
    return make_picture(scene, **settings)


PAIR = [
    area(RECTANGLE, (0.8, 0.1, 1.0), 0.6, 0.3) | {"radiance": (3.0, 2.0, 1.0)},
    {"kind": SPHERE, "position": (-2.0, 1.0, 2.0), "radiance": (1.0, 2.0, 3.0)},
]
FILTERED = {"pixel_filter": "BOX", "max_samples": 128, "stop_rule": "FIXED"}
MODES = pytest.mark.parametrize(
    "settings",
    [{}, FILTERED, {"estimator": "PAPER"}, FILTERED | {"estimator": "PAPER"}],
    ids=["center", "filtered", "paper", "paper filtered"],
)


@MODES
def test_lamps_add_to_the_world(settings):
    """World and lamps together are the sum of both; the passes are Combined; what the world's
    samples know of visibility stays theirs."""
    world, dark = constant_world((0.5, 0.6, 0.7)), lamp_picture(PAIR, **settings)[0]
    alone, both = (lamp_picture(rows, world, **settings)[0] for rows in ([], PAIR))
    fixed = "stop_rule" in settings
    if fixed or settings.get("pixel_filter") is None:
        expected = alone["combined"] + dark["combined"]
        np.testing.assert_allclose(both["combined"][..., :3], expected[..., :3], atol=2e-5)
    passes = sum(both[f"{n}_direct"] * both[f"{n}_color"] for n in ("diffuse", "glossy"))
    np.testing.assert_allclose(both["combined"][..., :3], passes, rtol=1e-4, atol=1e-5)
    for name in ("unoccluded", "visibility", "samples"):
        np.testing.assert_array_equal(both[name], alone[name])
    assert dark["combined"][..., :3].mean() > 0.02


@MODES
def test_lamp_pictures_do_not_depend_on_their_border(settings):
    """A crop is cut out of the whole, to the last bit."""
    whole = lamp_picture(PAIR, **settings)[0]["combined"]
    part = lamp_picture(PAIR, region=(5, 7, 20, 15), **settings)[0]["combined"]
    np.testing.assert_array_equal(part, whole[7:15, 5:20])


def test_the_stop_rule_sees_penumbras():
    """Where nothing but a large lamp lights, its half shadow takes more passes than the rest."""
    row = area(RECTANGLE, (0.0, 0.0, 2.0), 1.0, 1.0, np.eye(3)) | {"radiance": 1.0}
    rules = {"pixel_filter": "BOX", "max_samples": 400, "error_threshold": 0.02}
    matte, world = MATTE, constant_world((1e-3, 1e-3, 1e-3))
    layers, stats = lamp_picture([row], world, matte, **rules, stop_rule="PAPER")
    free = lamp_picture([row | {"shadow": False}], world, matte, max_samples=64)[0]
    share = layers["combined"][..., 0] / free["combined"][..., 0]
    count = layers["samples"][..., 0]
    half, lit = (share > 0.2) & (share < 0.8), share > 0.99
    assert half.sum() > 20 and count[half].mean() > 2.0 * np.median(count[lit])
    assert stats.shadow_rays > 0


@pytest.mark.parametrize("stop_rule", ["PAPER", "PERCEPTUAL", "FIXED"])
def test_deep_shadow_is_not_left_black(stop_rule):
    """Under one lamp alone, a tenth of which is seen: only the lamp says that there is light."""
    row = area(RECTANGLE, (1.2, 0.0, 1.5), 1.0, 1.0, np.eye(3)) | {"radiance": 1.0}
    rules = {"pixel_filter": "BOX", "max_samples": 256, "error_threshold": 0.1}
    layers, _ = lamp_picture([row], DARK, MATTE, stop_rule=stop_rule, **rules)
    settled, _ = lamp_picture([row], DARK, MATTE, max_samples=64)
    exact, found = (picture["combined"][..., 0] for picture in (settled, layers))
    deep = (exact > 0.03 * exact.max()) & (exact < 0.2 * exact.max())
    assert deep.sum() > 5 and (found[deep] > 0.0).all()
    # 16 samples of which one in ten is seen: 1 / sqrt(1.6) of each pixel, over their number.
    assert abs(found[deep].mean() / exact[deep].mean() - 1.0) < 0.15
