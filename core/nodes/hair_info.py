"""What a strand of hair is made of, as the nodes of hair have it: its direction, its pigment."""

from __future__ import annotations

import numpy as np

from ..data.rows import any_in_row
from .element_info import element_number
from .values import as_number, as_vector, column, normalized

# Absorption of eumelanin and pheomelanin over a strand's radius [dEon11].
_EUMELANIN, _PHEOMELANIN = np.float32([0.506, 0.841, 1.653]), np.float32([0.343, 0.733, 1.924])
_LEAST_COLOR, _LEAST_LEFT = np.float32(1e-12), np.float32(1e-4)


def strand_tangent(context, settings, inputs):
    """World space, unit; where there is no strand the input Otherwise."""
    tangent, n = context.attribute("element:Tangent"), len(context)
    other = as_vector(inputs["Otherwise"], n)
    if tangent is not None:
        tangent = normalized(context.vector_to_world(tangent))
        other = np.where(any_in_row(tangent)[:, None], tangent, other)
    return {"": np.float32(normalized(other))}


def strand_only(context, settings, inputs):
    """The input Value on strands, 0 elsewhere."""
    on_strand = np.where(element_number(context, "Is Strand") > 0.0, np.float32(1.0), 0.0)
    return {"": np.float32(on_strand * as_number(inputs["Value"], len(context)))}


def _reach(radial):
    """The factor of sqrt(absorption) in -log(color) [Chiang16, eq. 9]."""
    x = radial
    return ((((0.245 * x + 5.574) * x - 10.73) * x + 2.532) * x - 0.215) * x + 5.969


def _of_color(color, radial):
    """Absorption of hair that looks of a color, many strands together."""
    found = np.log(np.maximum(color, _LEAST_COLOR)) / column(_reach(radial))
    return found * found


def _of_melanin(value, redness, spread):
    """Absorption of an amount of pigment, 0 to 1, as artists want it to look."""
    amount = -np.log(np.maximum(1.0 - value * spread, _LEAST_LEFT))
    return column(amount * (1.0 - redness)) * _EUMELANIN + column(amount * redness) * _PHEOMELANIN


def hair_pigment(context, settings, inputs):
    """Inputs of a Principled Hair BSDF to its absorption, roughness both ways, and mean color.

    settings: parametrization; huang: its model has one roughness. Random is that of the strand
    where no input says otherwise.
    """
    n, number = len(context), {}
    for name in ("Roughness", "Radial", "Random Roughness", "Random Color", "Melanin", "Redness"):
        number[name] = as_number(inputs[name], n)
    random = inputs.get("Random")
    random = element_number(context, "Random") if random is None else as_number(random, n)
    off_mean = 2.0 * (random - 0.5)
    spread = 1.0 + off_mean * number["Random Roughness"]
    roughness, radial = number["Roughness"] * spread, number["Radial"] * spread
    if settings["huang"]:
        radial = roughness
    if settings["parametrization"] == "ABSORPTION":
        absorption = as_vector(inputs["Absorption"], n)
    elif settings["parametrization"] == "MELANIN":
        color_spread = 1.0 + off_mean * np.clip(number["Random Color"], 0.0, 1.0)
        absorption = _of_melanin(number["Melanin"], number["Redness"], color_spread)
        absorption = absorption + _of_color(as_vector(inputs["Tint"], n), radial)
    else:
        absorption = _of_color(as_vector(inputs["Color"], n), radial)
    color = np.exp(-np.sqrt(np.maximum(absorption, 0.0)) * column(_reach(radial)))
    return {
        "absorption": np.float32(absorption),
        "roughness": np.float32(roughness),
        "radial": np.float32(radial),
        "color": np.float32(color),
    }


FUNCTIONS = {
    "strand_tangent": strand_tangent,
    "strand_only": strand_only,
    "hair_pigment": hair_pigment,
}
