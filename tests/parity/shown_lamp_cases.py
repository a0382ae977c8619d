"""Lamps that the camera sees: what they look like, and what they are behind and before."""

from __future__ import annotations

import math

from .cases import lit_by
from .lamp_cases import add_lamp, matte

_CAMERA = (0.3, -6.0, 1.6)
_BEHIND, _BESIDE, _BEFORE = (-0.6, 1.5, 0.9), (0.2, 0.5, 1.1), (0.5, -2.5, 0.9)


def _case(name, kind, location, target=_CAMERA, world=True, film=False, depth=False, **options):
    """target: where it shines; film: transparent; depth: a wide aperture"""

    def build(scene, tree):
        scene.render.film_transparent = film
        add_lamp(scene, kind, location, target, visible_camera=True, **options)
        tree.surface(matte(tree))
        if depth:
            lens = scene.camera.data.dof
            lens.use_dof, lens.focus_distance, lens.aperture_fstop = True, 6.0, 0.1

    lit_by(f"Shown lamp: {name}", build, world=world, blurred=True, with_alpha=film)


_AREA = {"energy": 20.0, "size": 1.2}
_BALL = {"energy": 30.0, "shadow_soft_size": 0.4}

_case("area", "AREA", _BESIDE, **_AREA)
_case("area behind the sphere", "AREA", _BEHIND, **_AREA)
_case("area before all", "AREA", _BEFORE, **_AREA)
_case("area from behind", "AREA", _BEFORE, target=(0.3, 6.0, 0.0), **_AREA)
_case("disk, spread", "AREA", _BESIDE, shape="DISK", spread=math.radians(70.0), **_AREA)
_case("area, transparent film", "AREA", _BEHIND, film=True, **_AREA)
_case("area, out of focus", "AREA", _BEFORE, depth=True, **_AREA)
_case("ball", "POINT", _BESIDE, use_soft_falloff=False, **_BALL)
_case("soft ball", "POINT", _BESIDE, use_soft_falloff=True, **_BALL)
_case("ball in the dark", "POINT", _BEHIND, world=False, **_BALL)
_case("spot", "SPOT", _BESIDE, spot_size=math.radians(30.0), **_BALL)
_case("spot from aside", "SPOT", _BESIDE, target=(-3.0, 0.0, 0.0), **_BALL)
_case("sun", "SUN", (0.8, 6.0, 1.5), energy=1.0, angle=math.radians(12.0))
_case("sun, transparent film", "SUN", (0.8, 6.0, 1.5), film=True, energy=1.0, angle=0.2)
