"""All scenes, and the table of their results."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from . import assets, operators, templates
from .measure import Measured, measure
from .stage import Whole


def all_scenes() -> tuple[list[Whole], list[str]]:
    """(scenes, names of asset groups that none shows)"""
    of_assets, values = assets.scenes()
    return templates.scenes() + of_assets + operators.scenes(), values


def measure_all(scenes: list[Whole], words: list[str]) -> list[Measured]:
    """Of those whose name has one of the words, or all; each is told on standard output."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for whole in scenes:
            label = f"{whole.group} {whole.name}".lower()
            if words and not any(word.lower() in label for word in words):
                continue
            found.append(measure(whole, Path(folder)))
            sys.stdout.write(row(found[-1], {}))
            sys.stdout.flush()
    return found


def row(result: Measured, why: dict[str, str]) -> str:
    """A line of the table."""
    shown = {"same": "same", "missing": "not there"}.get(result.state, f"**{result.state}**")
    figures = "|"
    if result.pictures is not None:
        figures = f"{100 * result.mean:+.1f} % | {100 * result.blocks:.1f} %"
    told = [result.remark] if result.remark else []
    if result.state in ("differs", "black", "failed"):
        told.insert(0, why.get(result.name, "not known"))
    told += [f'"{line}"' for line in result.lines]
    text = "; ".join(told).replace("|", "/")
    return f"| {result.group} | {result.name} | {shown} | {figures} | {text} |\n"
