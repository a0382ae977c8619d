"""Nodes of which each pixel asks something else: 0, negative, large and small, in any order.

What they answer is shown by its arc tangent, from 0 to 1, so that an infinite pixel is one of many.
"""

import math

import bpy
import numpy as np

from .cases import shown
from .scene import HEIGHT, WIDTH, Tree
from .value_cases import BLENDS, choices

# Not so far from each other that what is left of a difference is rounding.
_VALUES = -7.3, -2.0, -1.0, -0.25, 0.0, 0.0, 0.1, 1 / 3, 0.5, 1.0, 2.5, 10.0


class _Asked:
    """Vectors and numbers by chance, one for each pixel; the same for all cases."""

    def __init__(self, tree: Tree):
        self._tree = tree
        self._images = [_image(tree, seed) for seed in range(4)]

    def vector(self, k):
        """k: 0 to 3"""
        return self._images[k]

    def number(self, k):
        """k: 0 to 11, of which 3 k to 3 k + 2 are in vector k"""
        return self._tree.made("ShaderNodeSeparateXYZ", k % 3, {0: self._images[k // 3]})


def _image(tree, seed):
    rng = np.random.default_rng(seed)
    pixels = np.ones((HEIGHT, WIDTH, 4), np.float32)
    pixels[..., :3] = rng.choice(np.float32(_VALUES), (HEIGHT, WIDTH, 3))
    pixels[: HEIGHT // 2, :, :3] = rng.uniform(-0.5, 1.5, (HEIGHT // 2, WIDTH, 3))
    image = bpy.data.images.new(f"Asked {seed}", WIDTH, HEIGHT, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    place = {0: tree.coordinates("Window")}
    return tree.made("ShaderNodeTexImage", 0, place, image=image, interpolation="Closest")


def _bent(tree, output):
    """A number or vector, of any size, as numbers from 0 to 1."""
    numbers = output.type == "VALUE"
    parts = [output] * 3
    if not numbers:
        parts = [tree.made("ShaderNodeSeparateXYZ", k, {0: output}) for k in range(3)]
    angles = [tree.made("ShaderNodeMath", 0, {0: p}, operation="ARCTANGENT") for p in parts]
    scaled = [
        tree.made("ShaderNodeMath", 0, {0: a, 1: 1.0 / math.pi, 2: 0.5}, operation="MULTIPLY_ADD")
        for a in angles
    ]
    return tree.made("ShaderNodeCombineXYZ", 0, dict(enumerate(scaled)))


def _asked(name, kind, numbers=(), vectors=(), output=None, **properties):
    """numbers, vectors: inputs, by identifier or number, that get the number or vector of a pixel;
    output: by identifier, else the one that is in use"""

    def make(tree):
        asked, node = _Asked(tree), tree.node(kind, **properties)
        sources = [asked.number(3 * k % 11) for k in range(len(numbers))]
        sources += [asked.vector(k % 4) for k in range(len(vectors))]
        for source, key in zip(sources, (*numbers, *vectors), strict=True):
            sockets = {s.identifier: s for s in node.inputs} | dict(enumerate(node.inputs))
            tree.link(source, sockets[key])
        outputs = [s for s in node.outputs if s.enabled and output in (None, s.identifier)]
        return _bent(tree, outputs[0])

    shown(f"{name}, extremes", make)


for _operation in choices("ShaderNodeMath", "operation"):
    _asked(f"Math {_operation}", "ShaderNodeMath", (0, 1, 2), operation=_operation)
for _operation in choices("ShaderNodeVectorMath", "operation"):
    _asked(
        f"Vector Math {_operation}",
        "ShaderNodeVectorMath",
        ("Scale",),
        (0, 1, 2),
        operation=_operation,
    )
for _blend in BLENDS:
    _asked(
        f"Mix colour {_blend}",
        "ShaderNodeMix",
        ("Factor_Float",),
        ("A_Color", "B_Color"),
        data_type="RGBA",
        blend_type=_blend,
        clamp_factor=False,
    )
_RANGE = "From Min", "From Max", "To Min", "To Max", "Value", "Steps"
_RANGES = "From_Min_FLOAT3", "From_Max_FLOAT3", "To_Min_FLOAT3", "To_Max_FLOAT3", "Vector"
for _kind in ("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"):
    for _clamp in (False, True):
        _how = {"interpolation_type": _kind, "clamp": _clamp}
        _word = f"{_kind}{' clamped' if _clamp else ''}"
        _asked(f"Map Range {_word}", "ShaderNodeMapRange", _RANGE, **_how)
        _asked(
            f"Map Range of vectors {_word}",
            "ShaderNodeMapRange",
            (),
            (*_RANGES, "Steps_FLOAT3"),
            data_type="FLOAT_VECTOR",
            **_how,
        )
for _mode in ("HSV", "HSL"):
    for _part in ("Red", "Green", "Blue"):
        _asked(
            f"Separate Color {_mode} {_part}",
            "ShaderNodeSeparateColor",
            (),
            (0,),
            _part,
            mode=_mode,
        )
    _asked(f"Combine Color {_mode}", "ShaderNodeCombineColor", (0, 1, 2), mode=_mode)
for _kind in ("POINT", "VECTOR", "NORMAL"):
    _asked(
        f"Vector Transform {_kind} to where it is",
        "ShaderNodeVectorTransform",
        (),
        (0,),
        vector_type=_kind,
        convert_from="OBJECT",
        convert_to="OBJECT",
    )
for _space in ("TANGENT", "OBJECT", "WORLD"):
    _asked(
        f"Normal Map {_space}",
        "ShaderNodeNormalMap",
        ("Strength",),
        ("Color",),
        space=_space,
    )
