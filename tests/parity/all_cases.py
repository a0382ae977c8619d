"""The list of all cases."""

from . import (
    closure_cases,
    coordinate_cases,
    element_cases,
    emitter_cases,
    falloff_cases,
    flag_cases,
    image_cases,
    lamp_cases,
    lamp_picture_cases,
    link_cases,
    lit_cases,
    motion_cases,
    normal_cases,
    property_cases,
    shown_lamp_cases,
    subsurface_cases,
    texture_cases,
    value_cases,
    view_cases,
    world_cases,
)
from .cases import CASES

_FAMILIES = (
    value_cases,
    coordinate_cases,
    property_cases,
    image_cases,
    texture_cases,
    lit_cases,
    closure_cases,
    subsurface_cases,
    normal_cases,
    lamp_cases,
    lamp_picture_cases,
    emitter_cases,
    view_cases,
    world_cases,
    element_cases,
    flag_cases,
    link_cases,
    shown_lamp_cases,
    falloff_cases,
    motion_cases,
)
ALL_CASES = CASES if all(_FAMILIES) else []
