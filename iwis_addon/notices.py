"""What a user should know before and after a render: merged warnings, by what they mean."""

from __future__ import annotations

import re
from typing import NamedTuple

from . import dependencies
from .job import RenderJob
from .one_line import one_line
from .output import NO_LAYER, lacks_layers
from .viewport import living


class Notice(NamedTuple):
    """One kind of warning. lines: all of that kind, each once; count: with repetitions"""

    text: str
    lines: list[str]
    count: int


# 'Object Cube: text', 'object "A", material "M", node "N": text': where and what.
_WHERE = re.compile(r"^(?:object|mesh|camera|scene|material|world|image)\s.*?(?<!\\):\s+", re.I)


def merge(lines: list[str]) -> list[Notice]:
    """Lines that say the same of different objects become one notice, in their order."""
    kinds: dict[str, list[str]] = {}
    for line in lines:
        what = _WHERE.sub("", line, count=1)
        what = re.sub(r"\d[\d,.]*", "#", what)  # "3 triangles left out" is of one kind with "5 ..."
        kinds.setdefault(what, []).append(line)
    notices = []
    for same in kinds.values():
        lines = list(dict.fromkeys(same))
        more = f" (and {len(lines) - 1} more like it)" if len(lines) > 1 else ""
        notices.append(Notice(lines[0] + more, lines, len(same)))
    return notices


def last_lines() -> list[str]:
    """What the last render, and the rendered views that are open, warned of."""
    lines: list[str] = []
    if RenderJob.current is not None:
        for record in RenderJob.current.records:
            lines += record.stats.warnings
    for viewport in living():
        told = [*viewport.warnings, viewport.thread.denoiser.problem]
        lines += [line for line in told if line and line not in lines]
    return list(map(one_line, lines))


def last_notices() -> list[Notice]:
    """last_lines(), merged."""
    return merge(last_lines())


def environment_node(world):
    """The Environment Texture node with an image that a world uses first; None without one."""
    if world is None or world.node_tree is None:
        return None
    return _first_in(world.node_tree, _is_environment, set())


def _is_environment(node) -> bool:
    return node.bl_idname == "ShaderNodeTexEnvironment" and node.image is not None


def _may_vary(node) -> bool:
    """Whether a node can make a world more than one colour."""
    if node.bl_idname in ("ShaderNodeTexEnvironment", "ShaderNodeTexImage"):
        return node.image is not None
    return node.bl_idname.startswith("ShaderNodeTex") or node.bl_idname == "ShaderNodeNewGeometry"


def _first_in(tree, is_wanted, seen):
    """The first wanted node of a tree and the groups in it, or None."""
    if tree is None or tree in seen:
        return None
    seen.add(tree)
    for node in tree.nodes:
        if is_wanted(node):
            return node
        found = _first_in(getattr(node, "node_tree", None), is_wanted, seen)
        if found is not None:
            return found
    return None


def advice_before_render(scene) -> list[str]:
    """What is missing for a picture as it is meant; none when all is there."""
    lines = dependencies.advice()
    if lacks_layers(scene):
        lines.append(NO_LAYER)
    iwis = scene.iwis
    if iwis.stop_rule == "BUDGET" and not (iwis.target_samples or iwis.time_limit):
        lines.append("The budget is empty: raise Target Samples or Time Limit above 0")
    if scene.camera is None:
        lines.append("The scene has no camera: add one, or choose one in the scene's properties")
    if any(thing.type == "LIGHT" and not thing.hide_render for thing in scene.objects):
        return lines
    if scene.world is None:
        lines.append("The scene has no world: add one in the world's properties")
    elif _first_in(scene.world.node_tree, _may_vary, set()) is None:
        lines.append(
            f'World "{scene.world.name}" is one colour: give its Color an Environment Texture, or '
            f"use Convert World to HDRI"
        )
    return lines


def objects_named_in(lines: list[str], objects) -> list:
    """Those of the objects whose names stand in the lines as words of their own."""
    text = "\n".join(lines)
    return [
        thing
        for thing in objects
        if re.search(rf"(?<![\w.]){re.escape(thing.name)}(?![\w]|\.\d)", text)
    ]
