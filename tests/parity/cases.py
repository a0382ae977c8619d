"""What a case is. The cases are in the files that all_cases names."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .scene import Tree


@dataclass(frozen=True)
class Case:
    """build(scene, tree) makes the material; lit: by a world, else it glows by itself.

    by_lamps: it is lit by lamps, in the dark or under a world too
    blurred: several points a pixel, by the camera or by what is seen through
    filter_width: pixels, of both engines' Blackman-Harris filter, of a blurred one
    samples: of a pixel, in IWIS and in Cycles, where there is noise
    warns: a part of the warning that IWIS must give; differs: why Cycles' picture is another one
    """

    name: str
    build: Callable
    lit: bool = False
    by_lamps: bool = False
    blurred: bool = False
    filter_width: float = 0.01
    samples: tuple[int, int] = (64, 128)
    with_alpha: bool = False
    warns: str = ""
    differs: str = ""

    @property
    def noisy(self) -> bool:
        """Whether there is something that both engines sample."""
        return self.lit or self.by_lamps or self.blurred

    @property
    def renders(self) -> int:
        """How often IWIS renders it, with other seeds."""
        return 8 if self.by_lamps else 2 if self.noisy else 1


CASES: list[Case] = []


def shown(name, make, **options):
    """A case that shows the output make(tree) as light."""
    CASES.append(Case(name, lambda scene, tree: tree.glow(make(tree)), **options))


def lit(name, make, **options):
    """A case that shows the shader make(tree) under a world."""
    CASES.append(Case(name, lambda scene, tree: tree.surface(make(tree)), lit=True, **options))


def lit_by(name, build, world=False, **options):
    """A case under lamps, in the dark or under a world too: build(scene, tree) makes both."""
    CASES.append(Case(name, build, lit=world, by_lamps=True, **options))


def world(name, make, **options):
    """A case that lights a plain scene by the world make(tree), a shader or a colour."""

    def build(scene, tree):
        tree.surface(tree.made("ShaderNodeBsdfDiffuse", 0, {"Color": (0.8, 0.7, 0.6)}))
        sky = Tree(scene.world.node_tree, "ShaderNodeOutputWorld")
        sky.surface(make(sky))

    # Two renders of IWIS with other seeds share some of their error: less of it is wanted here.
    CASES.append(Case(name, build, lit=True, samples=(512, 512), **options))
