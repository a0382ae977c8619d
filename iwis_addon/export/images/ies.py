"""IES files (IESNA LM-63), luminaires' photometric tables, read as Cycles reads them."""

from __future__ import annotations

import bpy
import numpy as np

# Candela to W/sr of a lamp of 1 W: 4 pi / 177.83 lumens a watt, Cycles' own.
_WATTS = 0.0706650768394
_MOST = 1 << 22  # values of a table


class IesError(ValueError):
    """A file that cannot be read, with what is wrong with it."""


def read_ies(node) -> dict:
    """settings of the operation core.nodes.ies.IES for an IES Texture node. Raises IesError"""
    if node.mode == "INTERNAL":
        if node.ies is None:
            raise IesError("no text is chosen")
        return parse_ies(node.ies.as_string())
    path = bpy.path.abspath(node.filepath, library=node.id_data.library)
    try:
        with open(path, encoding="latin-1") as file:
            return parse_ies(file.read())
    except OSError as error:
        raise IesError(f'"{node.filepath}" cannot be read: {error.strerror}') from error


def parse_ies(text: str) -> dict:
    """vertical, horizontal: float32 (k,), (m,), degrees; values: float32 (m, k), W/sr.

    Of type C, and of type B turned round. Raises IesError
    """
    numbers = _numbers(text)
    try:
        head = [next(numbers) for _ in range(13)]
        n_vertical, n_horizontal, kind = int(head[3]), int(head[4]), int(head[5])
        if not (n_vertical > 1 and n_horizontal > 0 and n_vertical * n_horizontal <= _MOST):
            raise IesError(f"it has {n_horizontal} x {n_vertical} angles")
        vertical = np.array([next(numbers) for _ in range(n_vertical)])
        horizontal = np.array([next(numbers) for _ in range(n_horizontal)])
        count = n_vertical * n_horizontal
        values = np.array([next(numbers) for _ in range(count)]).reshape(n_horizontal, n_vertical)
    except StopIteration:
        raise IesError("it ends before its table does") from None
    if kind != 1:
        raise IesError("only photometry of type C is supported")
    values = values * head[2] * head[10] * head[11] * _WATTS
    horizontal, values = _all_round(horizontal, values)
    rising = np.all(np.diff(vertical) > 0.0) and np.all(np.diff(horizontal) > 0.0)
    if not rising or not np.isfinite(values).all():
        raise IesError("its angles do not rise, or its values are no numbers")
    tables = {"vertical": vertical, "horizontal": horizontal, "values": values}
    return {name: np.ascontiguousarray(table, np.float32) for name, table in tables.items()}


def _numbers(text: str):
    """All numbers after the line TILT=, and after the table of a tilt that is included."""
    _, found, rest = text.partition("TILT=")
    if not found:
        raise IesError("it has no line TILT=: it is no IES file")
    tilt, _, rest = rest.partition("\n")
    words = iter(rest.replace(",", " ").split())
    if tilt.strip().upper() == "INCLUDE":
        next(words, None)
        pairs = int(float(next(words, "0")))
        for _ in range(2 * pairs):
            next(words, None)
    for word in words:
        try:
            yield float(word)
        except ValueError:
            raise IesError(f'"{word[:20]}" is no number') from None


def _all_round(horizontal, values):
    """The table from 0 to 360 degrees, of one that leaves out what is symmetrical."""
    if horizontal[0] == 90.0:  # some go from 90 to 270
        horizontal = horizontal - 90.0
    if horizontal[0] != 0.0:
        raise IesError(f"its horizontal angles begin at {horizontal[0]:g}, not at 0")
    if len(horizontal) == 1:
        return np.array([0.0, 360.0]), np.repeat(values, 2, axis=0)
    for half in (90.0, 180.0):
        if horizontal[-1] == half:
            horizontal = np.concatenate([horizontal, 2.0 * half - horizontal[-2::-1]])
            values = np.concatenate([values, values[-2::-1]])
    if horizontal[-1] < 360.0:  # some leave out the last, which is the first again
        horizontal, values = np.append(horizontal, 360.0), np.concatenate([values, values[:1]])
    return horizontal, values
