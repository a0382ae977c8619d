"""What stands behind a socket of a shader tree: the node that feeds it, or a constant.

Links are followed through reroutes, muted nodes and node groups, so that a value that is the same
all over the surface is found wherever it is typed in. What varies over the surface becomes one
value, and a warning says so.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....core.data.channels import LUMINANCE
from ..images.blackbody import blackbody_color
from .seen_tree import name_of

_MISSING_IMAGE = (1.0, 0.0, 1.0)  # as in Cycles
_MAX_LINKS = 1000  # a cycle of links must not hang the export


class End(NamedTuple):
    """Where the links behind a socket end.

    socket: the input that has no link, or the output that feeds it; groups: the group nodes that
    it lies in, the outermost first; node: the output's node, None for an input
    """

    socket: object
    groups: tuple
    node: object | None


def follow(socket, groups=()) -> End:
    """The end of the links behind an input that lies in ``groups``."""
    valued = End(socket, groups, None)
    for _ in range(_MAX_LINKS):
        link = next((link for link in socket.links if link.is_valid and not link.is_muted), None)
        if link is None:
            break
        node, output = link.from_node, link.from_socket
        if node.bl_idname == "NodeReroute":
            socket = node.inputs[0]
            continue
        if node.mute:
            socket = _passed_through(node, output)
        elif node.bl_idname == "ShaderNodeGroup" and node.node_tree is not None:
            socket, groups = _group_result(node, output), (*groups, node)
        elif node.bl_idname == "NodeGroupInput" and groups:
            socket, groups = _by_identifier(groups[-1].inputs, output.identifier), groups[:-1]
        else:
            return End(output, groups, node)
        if socket is None:
            break
        valued = End(socket, groups, None)
    return valued


def _passed_through(node, output):
    """The input that a muted node hands on to an output, or None."""
    for link in node.internal_links:
        if link.to_socket == output:
            return link.from_socket
    return None


def _group_result(node, output):
    """The input of the group's active output node that stands for an output of the group."""
    outputs = [n for n in node.node_tree.nodes if n.bl_idname == "NodeGroupOutput"]
    active = next((n for n in outputs if n.is_active_output), outputs[0] if outputs else None)
    return None if active is None else _by_identifier(active.inputs, output.identifier)


def _by_identifier(sockets, identifier):
    return next((socket for socket in sockets if socket.identifier == identifier), None)


class NodeReader:
    """Reads constants from one material's tree, and keeps its warnings."""

    def __init__(self, material_name: str, users: list[str], warnings: list[str]):
        self._where = f'{_objects(users)}material "{material_name}"'
        self._warnings = warnings

    def warn(self, node, text: str) -> None:
        """Add a warning that names object, material and node (None: no node), once."""
        where = "" if node is None else f', node "{name_of(node)}"'
        line = f"{self._where}{where}: {text}"
        if line not in self._warnings:
            self._warnings.append(line)

    def color(self, node, name: str, groups) -> tuple[float, float, float]:
        """The color of an input, linear Rec.709; grey if a number feeds it."""
        value = self._value(node, name, groups)
        return (value, value, value) if isinstance(value, float) else value

    def number(self, node, name: str, groups) -> float:
        """The number of an input; the luminance if a color feeds it."""
        value = self._value(node, name, groups)
        if isinstance(value, float):
            return value
        return float(sum(w * c for w, c in zip(LUMINANCE, value, strict=True)))

    def _value(self, node, name, groups):
        socket = node.inputs[name]
        end = follow(socket, groups)
        if end.node is None:
            return _constant(end.socket, _constant(socket))
        kind = end.node.bl_idname
        if kind in ("ShaderNodeRGB", "ShaderNodeValue"):
            return _constant(end.socket, _constant(socket))
        if kind == "ShaderNodeTexImage":
            return self._mean_of_image(end)
        if kind == "ShaderNodeBlackbody":
            return blackbody_color(self.number(end.node, "Temperature", end.groups))
        value = _constant(socket)
        self.warn(
            end.node,
            f'{end.node.bl_label} is not supported yet: "{name}" of {name_of(node)} is '
            f"{_text(value)}, the value under the link",
        )
        return value

    def _mean_of_image(self, end):
        image = end.node.image
        if image is None or not len(image.pixels):
            name = "none" if image is None else f'"{image.name}"'
            self.warn(end.node, f"image {name} cannot be read: pink instead, as in Cycles")
            return _MISSING_IMAGE
        mean = _mean_pixel(image)
        value = float(mean[3]) if end.socket.name == "Alpha" else tuple(map(float, mean[:3]))
        self.warn(
            end.node,
            f'textures are not supported yet: the mean of image "{image.name}", {_text(value)}, '
            "is used all over",
        )
        return value


def _objects(users: list[str]) -> str:
    """The first of the objects that have a material, and how many more there are."""
    if not users:
        return ""
    more = f" and {len(users) - 1} more" if len(users) > 1 else ""
    return f'object "{users[0]}"{more}, '


def _constant(socket, otherwise=None):
    """A float, or a tuple of three; ``otherwise`` if the socket has no such value."""
    value = getattr(socket, "default_value", None)
    if isinstance(value, (bool, int, float)):
        return float(value)
    try:
        return tuple(float(c) for c in value[:3])
    except TypeError:
        return otherwise


def _mean_pixel(image) -> np.ndarray:
    """Mean (r, g, b, alpha), linear: byte images in the sRGB color space are decoded first."""
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(-1, image.channels)
    mean = np.ones(4)
    color = pixels[:, :3]
    if not image.is_float and image.colorspace_settings.name == "sRGB":
        color = np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)
    mean[:3] = color.mean(axis=0, dtype=np.float64)
    if image.channels == 4:
        mean[3] = pixels[:, 3].mean(dtype=np.float64)
    return mean


def _text(value) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    return "(" + ", ".join(f"{c:.3g}" for c in value) + ")"
