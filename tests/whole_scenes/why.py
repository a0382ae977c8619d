"""Why whole scenes differ that do, by name: what was found out."""

_RIBBONS = "strands: Cycles' flat ribbons face the ray (decision 0027)"
_TWICE = "likely: it hands on the surface itself, and two spheres in one place shade each other"

WHY: dict[str, str] = {
    "procedural_hair_node_assets: Attachment Info": _TWICE,
    "object.curves_random_add": _RIBBONS,
    "object.quick_liquid": "Cycles' glass is black without bounces, and the camera is in it",
}
