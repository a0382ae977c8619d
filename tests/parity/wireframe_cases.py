"""The Wireframe node, before each kind of camera."""

import math

from .cases import CASES, Case, lit, shown


def _wires(tree, size, in_pixels=False):
    return tree.made("ShaderNodeWireframe", 0, {"Size": size}, use_pixel_size=in_pixels)


for _size in (0.03, 0.3):
    shown(f"Wireframe, {_size:g} m", lambda t, s=_size: _wires(t, s))
for _size in (2.0, 8.0):
    shown(f"Wireframe, {_size:g} pixels", lambda t, s=_size: _wires(t, s, True))


def _by_camera(kind):
    """A wireframe in pixels before another camera than the usual one."""

    def build(scene, tree):
        tree.glow(_wires(tree, 8.0, True))
        data = scene.camera.data
        data.type, data.ortho_scale = kind, 5.0
        if kind == "PANO":
            owner = data if hasattr(data, "panorama_type") else data.cycles
            owner.panorama_type = "FISHEYE_EQUIDISTANT"
            data.clip_start = 0.01
            scene.camera.location = (0.15, -1.3, 0.1)
            scene.camera.rotation_euler = (math.radians(80), 0.1, 0.3)

    CASES.append(Case(f"Wireframe, pixels, camera {kind}", build))


_by_camera("ORTHO")
_by_camera("PANO")
shown("Wireframe, of a size that varies", lambda t: _wires(t, t.axis("X", 0.0, 0.2)))
lit(
    "Wireframe as color",
    lambda t: t.made("ShaderNodeBsdfDiffuse", 0, {"Color": _wires(t, 0.05)}),
    blurred=True,
    filter_width=1.5,
)
