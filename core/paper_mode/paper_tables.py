"""The tables of one scene for mode PAPER: which there are, where they come from.

A point's BRDF is a sum of "parts", each a table slice times a colour: the Lambert slice and up to
four curves of the Fresnel factor (tables.CURVES) of its microfacet lobe. A measured BRDF is one
part, in the place of the first curve, with three channels; all slices then have three.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..bsdf.lobe_setup import setup_lobes
from ..bsdf.lobes import CONDUCTOR_LOBE, DIELECTRIC_LOBE
from ..light.environment import EnvironmentLookup
from ..scene import BECKMANN, MEASURED, NO_MEASURED, MaterialParams, MeasuredBrdfs
from ..settings import RenderSettings
from ..wavelets.haar_forest import HaarForest, join_forests, with_channels
from ..wavelets.table_cache import load_table, save_table, table_folder, table_key
from .tables import (
    DIELECTRIC_CURVE,
    EDGE_CURVE,
    PLAIN,
    SCHLICK_CURVE,
    build_lambert_table,
    build_light_table,
    build_lobe_table,
    build_measured_table,
    light_frames,
)

N_PARTS = 5  # Lambert, then the curves of tables.CURVES


class PaperTables(NamedTuple):
    """The compressed tables of one scene.

    light: HaarForest, 3 channels, a slice a normal; frames: float32 (SLICES, 3, 3), rows t, b, n
    brdf: HaarForest, 1 channel (3 with measured BRDFs), all lobes' slices after one another
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

    def text(self) -> str:
        return f"BRDF table, alpha {self.alpha:.4g}"

    def build(self, _measured, fraction, threads, step) -> HaarForest:
        shape = self.alpha, self.beckmann, self.fresnel, self.curve
        return build_lobe_table(*shape, fraction, threads, step)


@dataclass(frozen=True, slots=True)
class _MeasuredKey:
    """What the table of a measured BRDF depends on: sha256 of its file. row: of Scene.measured"""

    digest: str
    row: int = field(compare=False, repr=False)

    def text(self) -> str:
        return f"BRDF table, measured {self.digest[:8]}"

    def build(self, measured, fraction, threads, step) -> HaarForest:
        return build_measured_table(measured.values, self.row, fraction, threads, step)


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
        measured: MeasuredBrdfs = NO_MEASURED,
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
        keys, first_slice = _lobe_keys(materials, measured)
        used = {key}
        forests = [build_lambert_table(fraction)]
        starts = [0]
        for lobe in keys:
            name = table_key("lobe", lobe, fraction)
            used.add(name)
            forest = self._forest(
                folder,
                name,
                lobe.text(),
                lambda step, lobe=lobe: lobe.build(measured, fraction, threads, step),
                progress,
            )
            starts.append(starts[-1] + len(forests[-1].root))
            forests.append(forest)
        self._forests = {name: self._forests[name] for name in used}
        names = (fraction, *sorted(used))
        if self._joined is None or self._joined[0] != names:
            channels = max(forest.slice_mean.shape[1] for forest in forests)
            self._joined = names, join_forests([with_channels(f, channels) for f in forests])
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


def _lobe_keys(materials: MaterialParams, measured: MeasuredBrdfs) -> tuple[list, np.ndarray]:
    """The distinct lobe tables of some materials, and int (n, N_PARTS): 1 + index of each part's.

    0 is the Lambert slice, -1 no table. What a table depends on does not depend on directions.
    """
    n = len(materials.model)
    up = np.tile(np.float32([0, 0, 1]), (n, 1))
    lobes = setup_lobes(materials, up, up, up, measured)
    keys: dict[_LobeKey | _MeasuredKey, int] = {}
    first = np.full((n, N_PARTS), -1, np.int32)
    first[:, 0] = 0
    for m in range(n):
        if materials.model[m] == MEASURED:
            row = int(materials.distribution[m])
            key = _MeasuredKey(measured.keys[row], row)
            first[m, :2] = -1, 1 + keys.setdefault(key, len(keys))
            continue
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
