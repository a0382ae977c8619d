"""The tables of one scene for mode PAPER: which there are, where they come from.

A point's BRDF is a sum of "parts", each a table slice times a colour: the Lambert slice and up to
four curves of the Fresnel factor (tables.CURVES) of its microfacet lobe.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .environment import EnvironmentLookup
from .haar_forest import HaarForest, join_forests
from .lobes import CONDUCTOR_LOBE, DIELECTRIC_LOBE, setup_lobes
from .scene import BECKMANN, MaterialParams
from .settings import RenderSettings
from .table_cache import load_table, save_table, table_folder, table_key
from .tables import (
    DIELECTRIC_CURVE,
    EDGE_CURVE,
    PLAIN,
    SCHLICK_CURVE,
    build_lambert_table,
    build_light_table,
    build_lobe_table,
    light_frames,
)

N_PARTS = 5  # Lambert, then the curves of tables.CURVES


class PaperTables(NamedTuple):
    """The compressed tables of one scene.

    light: HaarForest, 3 channels, a slice a normal; frames: float32 (SLICES, 3, 3), rows t, b, n
    brdf: HaarForest, 1 channel, all lobes' slices after one another
    first_slice: int32 (n_materials, N_PARTS), where each material's slices begin, -1: none
    """

    light: HaarForest
    frames: np.ndarray
    brdf: HaarForest
    first_slice: np.ndarray


@dataclass(frozen=True, slots=True)
class _LobeKey:
    """What a lobe's table depends on; fresnel is zero but for the dielectric's curve."""

    alpha: float
    beckmann: bool
    curve: int
    fresnel: tuple[float, float, float]


class TableBuilder:
    """Makes the tables of a scene: out of memory, from disk, or anew.

    warnings: texts about tables that could not be kept; notes: what was built, its size and time.
        Both are of the last call of ``tables``
    """

    def __init__(self):
        self._forests: dict[str, HaarForest] = {}
        self._joined: tuple[tuple, HaarForest] | None = None
        self.warnings: list[str] = []
        self.notes: list[str] = []

    def tables(
        self,
        lookup: EnvironmentLookup,
        materials: MaterialParams,
        settings: RenderSettings,
        threads: int,
        progress=lambda fraction, text: None,
    ) -> PaperTables:
        """All that PaperSampler needs; progress(fraction, text) is told of tables being built."""
        self.warnings, self.notes = [], []
        fraction, folder = settings.coefficients, table_folder(settings.cache_dir)
        key = table_key("light", *lookup, fraction)
        light = self._forest(
            folder,
            key,
            "light table",
            lambda step: build_light_table(lookup, fraction, threads, step),
            progress,
        )
        keys, first_slice = _lobe_keys(materials)
        used = {key}
        forests = [build_lambert_table(fraction)]
        starts = [0]
        for lobe in keys:
            name = table_key("lobe", lobe, fraction)
            used.add(name)
            forest = self._forest(
                folder,
                name,
                f"BRDF table, alpha {lobe.alpha:.4g}",
                lambda step, lobe=lobe: build_lobe_table(
                    lobe.alpha, lobe.beckmann, lobe.fresnel, lobe.curve, fraction, threads, step
                ),
                progress,
            )
            starts.append(starts[-1] + len(forests[-1].root))
            forests.append(forest)
        self._forests = {name: self._forests[name] for name in used}
        names = (fraction, *sorted(used))
        if self._joined is None or self._joined[0] != names:
            self._joined = names, join_forests(forests)
        offsets = np.asarray(starts, np.int32)
        first = np.where(first_slice >= 0, offsets[np.maximum(first_slice, 0)], -1)
        return PaperTables(light, light_frames(), self._joined[1], first.astype(np.int32))

    def _forest(self, folder, key, text, build, progress) -> HaarForest:
        if key not in self._forests:
            forest = load_table(folder, key)
            if forest is None:
                begin = time.perf_counter()
                forest = build(lambda fraction: progress(fraction, f"Building {text}"))
                seconds = time.perf_counter() - begin
                self.notes.append(f"{text}: {forest.nbytes / 1e6:.1f} MB, built in {seconds:.1f} s")
                warning = save_table(folder, key, forest)
                if warning and warning not in self.warnings:
                    self.warnings.append(warning)
            self._forests[key] = forest
        return self._forests[key]


def _lobe_keys(materials: MaterialParams) -> tuple[list[_LobeKey], np.ndarray]:
    """The distinct lobe tables of some materials, and int (n, N_PARTS): 1 + index of each part's.

    0 is the Lambert slice, -1 no table. What a table depends on does not depend on directions.
    """
    n = len(materials.model)
    up = np.tile(np.float32([0, 0, 1]), (n, 1))
    lobes = setup_lobes(materials, up, up, up)
    keys: dict[_LobeKey, int] = {}
    first = np.full((n, N_PARTS), -1, np.int32)
    first[:, 0] = 0
    for m in range(n):
        kind, alpha = int(lobes.kind[m]), float(lobes.alpha[m])
        beckmann = int(lobes.distribution[m]) == BECKMANN
        curves = [PLAIN] if kind & (DIELECTRIC_LOBE | CONDUCTOR_LOBE) else []
        if kind & DIELECTRIC_LOBE:
            curves.append(DIELECTRIC_CURVE)
        if kind & CONDUCTOR_LOBE and (lobes.f0[m, 1] < 1.0).any():
            curves.append(SCHLICK_CURVE)
        if kind & CONDUCTOR_LOBE and lobes.edge[m].any():
            curves.append(EDGE_CURVE)
        for curve in curves:
            fresnel = tuple(float(x) for x in lobes.fresnel[m]) if curve == DIELECTRIC_CURVE else ()
            key = _LobeKey(alpha, beckmann, curve, fresnel or (0.0, 0.0, 0.0))
            first[m, 1 + curve] = 1 + keys.setdefault(key, len(keys))
    return list(keys), first
