"""The picture of a world's tree: texels, and how a direction finds its own.

Either the texels of the tree's images with the nodes over them applied, as exact as the images, or
a new equirectangular map of all directions (core/nodes/world_map.py).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ....core.data.program import Op, Ref, WorldProgram
from ....core.data.program_ops import BY_INPUTS
from ....core.nodes.world import DIRECTION, ENVIRONMENT
from ....core.nodes.world_map import evaluate_map, evaluate_texels, reached_ops
from ....core.scene import CLOSEST, EQUIRECTANGULAR, LINEAR, EnvironmentMap
from .world_tree import WorldTree

# Rows of a map at the least, 0.18 degrees each, and in a window, where a tree is edited and seen at
# once: cameras do not look at it (backdrop_of). And at the most: 400 MB.
LEAST_HEIGHT, LEAST_IN_WINDOW, MOST_HEIGHT = 1024, 512, 4096
# Of directions, without edges.
_SMOOTH = {
    DIRECTION,
    "world_transform",
    "world_camera_data",
    "world_window",
    "ShaderNodeTexGradient",
    "ShaderNodeNormal",
    "ShaderNodeFresnel",
    "ShaderNodeLayerWeight",
}
_STEPS = set(
    "LESS_THAN GREATER_THAN COMPARE SIGN ROUND FLOOR CEIL TRUNC FRACT FRACTION MODULO "
    "FLOORED_MODULO WRAP SNAP DIVIDE TANGENT".split()
)
# Pairs of neighbours that are looked at, of the brightest and of all; a difference of their light
# that nobody sees.
_PAIRS, _BEND = 2048, 0.002
_WAVE = 4.0  # texels: a noise of longer waves has no edges
_SAME = np.eye(3, 4, dtype=np.float32)


class Picture(NamedTuple):
    """As EnvironmentMap; name: of the image, None where it is none."""

    radiance: np.ndarray
    world_to_map: np.ndarray = _SAME
    projection: str = EQUIRECTANGULAR
    interpolation: str = LINEAR
    name: str | None = None


def picture_of_texels(
    tree: WorldTree, slot: str, cache, threads: int, least_height: int
) -> Picture | None:
    """The picture of a tree whose images are looked up in one way, exact; None of another tree.

    slot: what to keep it under in the TexelCache, for a frame where the tree is the same
    least_height: where images have fewer rows, and nodes that bend what lies between two texels
        (a ramp, a gamma), a map of directions is closer to Cycles, which blends before
    """
    ops = reached_ops(tree.program, tree.value)
    images = _images(ops)
    if not images or not _is_of_texels(ops, list(images.values())):
        return None
    first = next(iter(images.values()))
    if tree.value in [Ref(row, "Color") for row in images]:
        radiance = first.radiance
    else:
        texels = {row: image.radiance for row, image in images.items()}
        few = len(first.radiance) < least_height and first.interpolation != CLOSEST
        if few and _bends(tree, texels):
            return None
        radiance = cache.kept(
            ("texels", slot),
            (tree.value, ops),
            lambda: evaluate_texels(tree.program, tree.value, texels, threads),
        )
    how = first.world_to_map, first.projection, first.interpolation
    return Picture(radiance, *how, name=first.name)


def picture_of_directions(
    tree: WorldTree, cache, threads: int, least_height: int, reader, pause: Callable[[], None]
) -> Picture:
    """A new map of a tree that varies; the last frame's where the tree is the same.

    pause() may raise to stop
    """
    ops = reached_ops(tree.program, tree.value)
    height = _height(ops, least_height, reader)
    edges = any(_has_edges(op, ops, height) for op in ops.values())
    radiance = cache.kept(
        "map",
        (tree.value, ops, height),
        lambda: evaluate_map(
            tree.program, tree.value, height, has_edges=edges, threads=threads, pause=pause
        ),
    )
    return Picture(radiance)


def backdrop_of(tree: WorldTree, cache) -> WorldProgram:
    """The tree for the rays of a camera; the last frame's object where it is the same."""
    ops = reached_ops(tree.program, tree.value)
    world = WorldProgram(program=tree.program, value=tree.value, strength=tree.strength)
    return cache.kept("backdrop", (tree.value, ops, tree.strength), lambda: world)


def _images(ops: dict[int, Op]) -> dict[int, EnvironmentMap]:
    return {row: op.settings["map"] for row, op in ops.items() if op.kind == ENVIRONMENT}


def _is_of_texels(ops: dict[int, Op], images: list[EnvironmentMap]) -> bool:
    """Whether a program can be evaluated texel by texel."""
    looked_up = {row for row, op in ops.items() if op.kind == ENVIRONMENT}
    if any(op.inputs for row, op in ops.items() if row in looked_up):
        return False
    if not all(op.kind in BY_INPUTS for row, op in ops.items() if row not in looked_up):
        return False
    return len({_place(image) for image in images}) == 1


def _bends(tree: WorldTree, texels: dict[int, np.ndarray]) -> bool:
    """Whether the colour between two texels is another one than the mean of both of theirs."""
    row, column, weight = _pairs(texels)
    width = next(iter(texels.values())).shape[1]
    pairs = {k: (t[row, column], t[row, (column + 1) % width]) for k, t in texels.items()}
    found = [
        evaluate_texels(tree.program, tree.value, {k: of(*p)[None] for k, p in pairs.items()})
        for of in (lambda a, b: a, lambda a, b: b, lambda a, b: (a + b) / 2)
    ]
    one, other, between = map(np.nan_to_num, found)
    bent = np.abs(between - (one + other) / 2).mean((0, 2), dtype=np.float64)
    return bent @ weight > _BEND * (np.abs(between).mean((0, 2), dtype=np.float64) @ weight)


def _pairs(texels: dict[int, np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Row and column of texels that are looked at with the next one in the row, and how many pairs
    each of them stands for: the brightest for themselves, as a sun may be most of the light, and
    some of the others for the rest."""
    rng = np.random.default_rng(0)
    light = sum(t.sum(-1) for t in texels.values())
    _, width = light.shape
    light = np.nan_to_num(np.maximum(light, np.roll(light, -1, 1))).ravel()
    n = min(_PAIRS, len(light))
    bright = np.argpartition(light, len(light) - n)[-n:]
    others = rng.integers(len(light), size=_PAIRS)
    others = others[~np.isin(others, bright)]
    weight = np.ones(n + len(others))
    weight[n:] = (len(light) - n) / max(len(others), 1)
    return *np.divmod(np.concatenate([bright, others]), width), weight


def _place(image: EnvironmentMap):
    """What decides which texel a direction finds, and how texels are blended."""
    how = image.projection, image.interpolation, image.world_to_map.tobytes()
    return image.radiance.shape, *how


def _height(ops, least: int, reader) -> int:
    """Rows of the map of a tree: those of its largest image, and ``least`` at the least."""
    heights = [least] + [image.radiance.shape[0] for image in _images(ops).values()]
    for op in ops.values():
        tiles = op.settings.get("image") if op.kind == "ShaderNodeTexImage" else None
        for texels in tiles.tiles.values() if tiles else ():
            heights.append(max(texels.shape[0], texels.shape[1] // 2))
    if max(heights) > MOST_HEIGHT:
        reader.warn(
            None,
            f"its images are larger than the map of all its nodes, {2 * MOST_HEIGHT} x "
            f"{MOST_HEIGHT}: more would take over 400 MB; detail below that is averaged",
        )
    return min(max(heights), MOST_HEIGHT)


def _finest_wave(noise: Op, ops: dict[int, Op]) -> float:
    """What a noise's last octave changes over, radians; 0 where that cannot be told."""
    place, stretch = noise.inputs.get("Vector"), 1.0
    while isinstance(place, Ref) and ops[place.op].kind == "ShaderNodeMapping":
        mapping = ops[place.op]
        scale, kind = mapping.inputs["Scale"], mapping.settings["vector_type"]
        if isinstance(scale, Ref) or kind not in ("POINT", "VECTOR"):
            return 0.0
        stretch *= float(np.abs(scale).max())
        place = mapping.inputs["Vector"]
    numbers = [noise.inputs.get(name, 0.0) for name in ("Scale", "Detail", "Lacunarity")]
    is_direction = place is None or (isinstance(place, Ref) and ops[place.op].kind == DIRECTION)
    if not is_direction or any(isinstance(value, Ref) for value in numbers):
        return 0.0
    scale, detail, lacunarity = map(float, numbers)
    return 1.0 / max(abs(scale) * stretch * max(lacunarity, 1.0) ** detail, 1e-6)


def _has_edges(op: Op, ops: dict[int, Op], height: int) -> bool:
    """Whether an operation may jump from a texel to the next."""
    settings = op.settings
    if op.kind == ENVIRONMENT:
        image: EnvironmentMap = settings["map"]
        aligned = (
            not op.inputs
            and image.radiance.shape[:2] == (height, 2 * height)
            and image.projection == EQUIRECTANGULAR
            and np.array_equal(image.world_to_map, _SAME)
        )
        return not aligned
    if op.kind in ("ShaderNodeMath", "ShaderNodeVectorMath"):
        return settings["operation"] in _STEPS
    if op.kind == "ShaderNodeMapRange":
        return settings["interpolation_type"] == "STEPPED"
    if op.kind == "ShaderNodeValToRGB":
        return bool(settings["stepped"])
    if op.kind == "ShaderNodeTexNoise":
        return _finest_wave(op, ops) < _WAVE * np.pi / height
    if op.kind == "ShaderNodeTexGradient":
        return settings["gradient_type"] == "RADIAL"
    return op.kind not in BY_INPUTS and op.kind not in _SMOOTH
