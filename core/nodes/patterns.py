"""Textures by a formula: Checker, Gradient, Wave, Magic, Brick, White Noise."""

from __future__ import annotations

import numpy as np

from .hashing import hash_numbers, hash_to_color
from .noise import fbm, noise_place
from .values import as_number, as_vector, clipped, column, length, parts

_TURN = np.float32(2.0 * np.pi)


def _place(context, inputs):
    co = inputs.get("Vector")
    return as_vector(context.generated if co is None else co, len(context))


def _off_the_grid(p):
    """As Cycles does: coordinates on whole numbers must not flicker."""
    return (p + np.float32(0.000001)) * np.float32(0.999999)


def checker(context, settings, inputs):
    p = _off_the_grid(_place(context, inputs) * column(inputs["Scale"]))
    x, y, z = (np.abs(np.floor(a)).astype(np.int64) % 2 for a in parts(p))
    first = (x == y) == (z == 1)
    color = np.where(first[:, None], inputs["Color1"], inputs["Color2"])
    return {"Color": color, "Fac": first.astype(np.float32)}


def _sphere(p):
    return np.maximum(np.float32(0.999999) - length(p), 0.0)


_GRADIENT = {
    "LINEAR": lambda x, y, p: x,
    "QUADRATIC": lambda x, y, p: np.maximum(x, 0.0) ** 2,
    "EASING": lambda x, y, p: clipped(x) ** 2 * (3.0 - 2.0 * clipped(x)),
    "DIAGONAL": lambda x, y, p: (x + y) * 0.5,
    "RADIAL": lambda x, y, p: np.arctan2(y, x) / _TURN + 0.5,
    "QUADRATIC_SPHERE": lambda x, y, p: _sphere(p) ** 2,
    "SPHERICAL": lambda x, y, p: _sphere(p),
}


def _grey(value):
    return {"Color": np.repeat(value[:, None], 3, -1), "Fac": value}


def gradient(context, settings, inputs):
    p = _place(context, inputs)
    x, y, _ = parts(p)
    return _grey(clipped(_GRADIENT[settings["gradient_type"]](x, y, p)).astype(np.float32))


def _wave_phase(settings, p):
    x, y, z = parts(p)
    if settings["wave_type"] == "BANDS":
        kind = settings["bands_direction"]
        if kind == "DIAGONAL":
            return (x + y + z) * 10.0
        return {"X": x, "Y": y, "Z": z}[kind] * 20.0
    kept = {"X": (0, 1, 1), "Y": (1, 0, 1), "Z": (1, 1, 0)}.get(
        settings["rings_direction"], (1, 1, 1)
    )
    return length(p * np.float32(kept)) * 20.0


def wave(context, settings, inputs):
    n = len(context)
    p = _off_the_grid(_place(context, inputs) * column(inputs["Scale"]))
    phase = _wave_phase(settings, p) + as_number(inputs["Phase Offset"], n)
    distortion = as_number(inputs["Distortion"], n)
    if distortion.any():
        q = np.ascontiguousarray((p * column(inputs["Detail Scale"])).T)
        detail = np.clip(as_number(inputs["Detail"], n), 0.0, 15.0)
        phase = phase + distortion * (fbm(q, detail, inputs["Detail Roughness"]) * 2.0 - 1.0)
    if settings["wave_profile"] == "SIN":
        value = 0.5 + 0.5 * np.sin(phase - np.float32(np.pi / 2.0))
    else:
        turns = phase / _TURN
        saw = settings["wave_profile"] == "SAW"
        value = turns - np.floor(turns) if saw else np.abs(turns - np.floor(turns + 0.5)) * 2.0
    return _grey(value.astype(np.float32))


# What is computed anew at each depth: (coordinate, function, signs of x, y and z).
_MAGIC = (
    (1, lambda a: -np.cos(a), (1, -1, 1)),
    (0, np.cos, (1, -1, -1)),
    (2, np.sin, (-1, -1, -1)),
    (0, lambda a: -np.cos(a), (-1, 1, -1)),
    (1, lambda a: -np.sin(a), (-1, 1, 1)),
    (1, lambda a: -np.cos(a), (-1, 1, 1)),
    (0, np.cos, (1, 1, 1)),
    (2, np.sin, (1, 1, -1)),
    (0, lambda a: -np.cos(a), (-1, -1, 1)),
    (1, lambda a: -np.sin(a), (1, -1, 1)),
)


def magic(context, settings, inputs):
    """settings: turbulence_depth; scaled_first: before places are taken modulo a turn"""
    n, depth = len(context), settings["turbulence_depth"]
    scale, distortion = as_number(inputs["Scale"], n), as_number(inputs["Distortion"], n)
    place = _place(context, inputs)
    if settings["scaled_first"]:
        place, scale = place * column(scale), np.float32(1.0)
    px, py, pz = (np.fmod(a, _TURN) for a in parts(place))
    values = [
        np.sin((px + py + pz) * 5.0 * scale),
        np.cos((-px + py - pz) * 5.0 * scale),
        -np.cos((-px - py + pz) * 5.0 * scale),
    ]
    if depth > 0:
        values = [a * distortion for a in values]
    for which, function, signs in _MAGIC[:depth]:
        values[which] = (
            function(sum(s * a for s, a in zip(signs, values, strict=True))) * distortion
        )
    divisor = np.where(distortion != 0.0, 2.0 * distortion, 1.0)
    color = np.stack([0.5 - a / divisor for a in values], -1).astype(np.float32)
    return {"Color": color, "Fac": color.mean(-1)}


def _brick_noise(number):
    with np.errstate(over="ignore"):
        n = (number + np.uint32(1013)) & np.uint32(0x7FFFFFFF)
        n = (n >> np.uint32(13)) ^ n
        n = n * (n * n * np.uint32(60493) + np.uint32(19990303)) + np.uint32(1376312589)
    return np.float32(0.5) * (
        (n & np.uint32(0x7FFFFFFF)).astype(np.float32) / np.float32(1073741824.0)
    )


def brick(context, settings, inputs):
    n = len(context)
    x, y, _ = parts(_place(context, inputs) * column(inputs["Scale"]))
    width, height = (as_number(inputs[k], n) for k in ("Brick Width", "Row Height"))
    mortar, smooth = (as_number(inputs[k], n) for k in ("Mortar Size", "Mortar Smooth"))
    row = np.floor(y / height).astype(np.int64)
    shift = np.zeros(n, np.float32)
    if settings["offset_frequency"] and settings["squash_frequency"]:
        odd = np.fmod(row, settings["squash_frequency"]) != 0
        width = width * np.where(odd, 1.0, np.float32(settings["squash"]))
        odd = np.fmod(row, settings["offset_frequency"]) != 0
        shift = np.where(odd, 0.0, width * np.float32(settings["offset"]))
    number = np.floor((x + shift) / width).astype(np.int64)
    along, up = x + shift - width * number, y - height * row
    word = ((row << 16) + (number & 0xFFFF)).astype(np.uint32)
    tint = column(clipped(_brick_noise(word) + as_number(inputs["Bias"], n)))
    near = np.minimum(np.minimum(along, up), np.minimum(width - along, height - up))
    t = clipped((1.0 - near / mortar) / np.where(smooth > 0.0, smooth, 1.0))
    value = np.where(smooth > 0.0, t * t * (3.0 - 2.0 * t), 1.0)
    value = np.where(near >= mortar, 0.0, value).astype(np.float32)
    color = (1.0 - tint) * inputs["Color1"] + tint * inputs["Color2"]
    color = color * (1.0 - value[:, None]) + inputs["Mortar"] * value[:, None]
    return {"Color": color, "Fac": value}


def white_noise(context, settings, inputs):
    p = noise_place(context, inputs, settings["noise_dimensions"])
    return {"Value": hash_numbers(*p), "Color": hash_to_color(p)}


FUNCTIONS = {
    "ShaderNodeTexChecker": checker,
    "ShaderNodeTexGradient": gradient,
    "ShaderNodeTexWave": wave,
    "ShaderNodeTexMagic": magic,
    "ShaderNodeTexBrick": brick,
    "ShaderNodeTexWhiteNoise": white_noise,
}
