"""The one picture that is shown of an OpenEXR file with layers, made a plain file.

Cycles shows files on disk by OpenImageIO: the first part's first four channels, sorted by layer,
then by their meaning, whatever the layers are. What is packed it gets from Blender: the first pass
of the first layer, in Blender's order of passes. Measured in Blender 4.5 and 5.2, which agree.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .exr import open_parts, plane_of, write_exr_layers

# In one layer channels come in this order; others after them, by name.
_BY_MEANING = (
    *("r", "red", "g", "green", "b", "blue", "real", "imag"),
    *("a", "alpha", "ar", "ra", "ag", "ga", "ab", "ba", "z", "depth", "zback"),
)
_LETTERS = {"red": "R", "green": "G", "blue": "B", "alpha": "A", "depth": "Z"}
_COMPLETE = ("RGB", "XYZ", "UVA", "RGBA", "XYZW")  # passes whose channels have an order
_VIEWS = ("left", "right")


class Shown(NamedTuple):
    """Up to four channels, in the order they are shown: objects of the package OpenEXR by name.

    multiplied: whether Blender 5.1 and later multiply them by the last where it is straight alpha
    colors: whether they are in the space that the user names; else they are data
    """

    channels: dict
    multiplied: bool
    colors: bool


def _shown_by_cycles(parts) -> Shown:
    def place(name):
        layer, dot, letter = name.rpartition(".")
        known = letter.lower() in _BY_MEANING and (letter != "Z" or f"{layer}{dot}Y" not in first)
        return layer + dot, _BY_MEANING.index(letter.lower()) if known else len(_BY_MEANING), name

    first = parts[0].channels
    names = sorted(first, key=place)[:4]
    return Shown({name: first[name] for name in names}, len(first) in (2, 4), True)


class _Channel(NamedTuple):
    """A channel of Blender's, by the words of its name."""

    layer: str
    of_pass: str
    view: str
    letter: str
    name: str
    channel: object

    def place(self, order):
        """Of its pass among those of the layer, and of the view among the pass'."""
        known = self.of_pass in order
        number = order.index(self.of_pass) if known else len(order)
        view = _VIEWS.index(self.view) if self.view in _VIEWS else len(_VIEWS)
        return number, "" if known else self.of_pass, view, self.view


def _channel_of(part, name: str, channel) -> _Channel:
    """Blender's reading of a name: layer.pass.view.letter, of which the last alone must be there;
    before it stands the name of its part."""
    view, words = part.view, name.split(".")
    if len(words) == 1 and part.name != view:
        words = [*part.name.split("."), name]
    *words, letter = (word for word in words if word)
    letter = _LETTERS.get(letter.lower(), letter[:1].upper())
    if words and words[-1] in part.views:
        view = words.pop()
    if not words:
        words = ["Combined" if letter in "RGBA" else "Depth" if letter == "Z" else name]
    return _Channel(".".join(words[:-1]), words[-1], view, letter, name, channel)


def _shown_by_blender(parts, order) -> Shown:
    channels = [
        _channel_of(part, name, own)
        for part in parts
        for name, own in sorted(part.channels.items())
    ]
    layer = [channel for channel in channels if channel.layer == channels[0].layer]
    first = min(channel.place(order) for channel in layer)
    shown = [channel for channel in layer if channel.place(order) == first]
    letters = sorted(channel.letter for channel in shown)
    orders = [order for order in _COMPLETE if sorted(order) == letters]
    if orders:
        shown.sort(key=lambda channel: orders[0].index(channel.letter))
    own = {channel.name: channel.channel for channel in shown[:4]}
    return Shown(own, orders == ["RGBA"], orders in (["RGB"], ["RGBA"]))


def _colors_of(planes) -> np.ndarray:
    """float32 (h, w, 3 or 4) of one to four planes: one is grey, of two the second is alpha."""
    grey = planes[:1] * 3
    return np.stack({1: grey, 2: grey + planes[1:]}.get(len(planes), planes), axis=-1)


def write_picture(source: str, target: str, passes: Sequence[str], straight: bool) -> bool:
    """Write what is shown of a file as plain OpenEXR, RGB or RGBA; tell whether it is colors, or
    data that no color space says anything of.

    passes: as Blender shows it, which has names of passes in this order; none: as Cycles does
    straight: multiplied by alpha where Blender 5.1 does that
    Raises OSError, with the file's name, for what is no picture, and as read_exr().
    """
    parts = open_parts(os.fspath(source))
    shown = _shown_by_blender(parts, passes) if passes else _shown_by_cycles(parts)
    planes = [plane_of(source, *channel) for channel in shown.channels.items()]
    if any(channel.pixels.dtype == np.uint32 for channel in shown.channels.values()):
        raise OSError(f"{source}: its first layer holds whole numbers, which are no color")
    if passes and len(planes) == 2:  # Blender's second is green, Cycles' alpha
        planes.append(np.zeros_like(planes[0]))
    picture = _colors_of(planes)
    if straight and shown.multiplied:
        picture[..., :3] *= picture[..., 3:]
    write_exr_layers(target, {"": picture}, view_layer="", compression="NO")
    return shown.colors
