"""The panorama of a camera's data, as core.scene.Panorama.

Blender keeps its settings with the camera; before 4.5 they were Cycles' own.
"""

from __future__ import annotations

from ....core.scene import PANORAMAS, Panorama

_CYLINDER = ("u_min", "u_max", "v_min", "v_max")


def panorama_of(data, horizontal: bool, side: float) -> Panorama | None:
    """The panorama of a camera of type PANO; None for one that a newer Blender brought.

    horizontal: whether the sensor is fitted to the frame's width; side: length of the frame's
    other side, of the fitted one
    """
    owner = data if hasattr(data, "panorama_type") else data.cycles
    kind = owner.panorama_type
    if kind not in PANORAMAS:
        return None
    sensor = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
    known = {
        "fov": getattr(owner, "fisheye_fov", 0.0),
        "lens": getattr(owner, "fisheye_lens", 0.0),
        "sensor_width": sensor if horizontal else sensor * side,
        "sensor_height": sensor * side if horizontal else sensor,
        "axis": getattr(owner, "central_cylindrical_axis", 0.0),
    }
    for name in PANORAMAS["EQUIRECTANGULAR"]:
        known[name] = getattr(owner, name, 0.0)
    for name in PANORAMAS["FISHEYE_LENS_POLYNOMIAL"][3:]:
        known[name] = getattr(owner, f"fisheye_polynomial_{name}", 0.0)
    for name in _CYLINDER:
        known[name] = getattr(owner, f"central_cylindrical_range_{name}", 0.0)
        if name.startswith("v_"):  # metres on a cylinder of a radius
            known[name] /= getattr(owner, "central_cylindrical_radius", 1.0)
    return Panorama(kind, tuple(float(known[name]) for name in PANORAMAS[kind]))
