"""What a case is. The cases: value_cases, coordinate_cases, image_cases, texture_cases."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Case:
    """build(scene, tree) makes the material; lit: by a world, else it glows by itself.

    blurred: by the camera: several points a pixel, two renders by both even where it glows
    warns: a part of the warning that IWIS must give; differs: why Cycles' picture is another one
    """

    name: str
    build: Callable
    lit: bool = False
    blurred: bool = False
    with_alpha: bool = False
    warns: str = ""
    differs: str = ""


CASES: list[Case] = []


def shown(name, make, **options):
    """A case that shows the output make(tree) as light."""
    CASES.append(Case(name, lambda scene, tree: tree.glow(make(tree)), **options))


def lit(name, make, **options):
    """A case that shows the shader make(tree) under a world."""
    CASES.append(Case(name, lambda scene, tree: tree.surface(make(tree)), lit=True, **options))
