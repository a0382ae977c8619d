"""What a case is. The cases: value_cases, coordinate_cases, image_cases, texture_cases."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Case:
    """build(scene, tree) makes the material; lit: by a world, else it glows by itself.
    noisy: lit by something that both engines sample; renders: by IWIS, with other seeds

    warns: a part of the warning that IWIS must give; differs: why Cycles' picture is another one
    """

    name: str
    build: Callable
    lit: bool = False
    noisy: bool = False
    renders: int = 1
    with_alpha: bool = False
    warns: str = ""
    differs: str = ""


CASES: list[Case] = []


def shown(name, make, **options):
    """A case that shows the output make(tree) as light."""
    CASES.append(Case(name, lambda scene, tree: tree.glow(make(tree)), **options))


def lit(name, make, **options):
    """A case that shows the shader make(tree) under a world."""
    CASES.append(
        Case(name, lambda scene, tree: tree.surface(make(tree)), lit=True, noisy=True, **options)
    )


def lit_by(name, build, world=False, **options):
    """A case under lamps, in the dark or under a world too: build(scene, tree) makes both."""
    CASES.append(Case(name, build, lit=world, noisy=True, renders=8, **options))
