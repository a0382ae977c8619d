"""Strands of hair, written to the lobes of their points (hair.py has what they mean)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..data.program import HAIR_BELL_REFLECTION, HAIR_BELL_TRANSMISSION, HAIR_CHIANG
from ..data.rows import rows_of
from ..geometry.round_points import Circles
from .hair import ALL_ROUND, LAMPS_ALONE
from .lambert_kinds import CHIANG, HAIR_REFLECTION, HAIR_TRANSMISSION, TRANSLUCENT_ROUND
from .lobes import DIELECTRIC, DIFFUSE_LOBE, Lobes

_MODELS = {
    HAIR_CHIANG: CHIANG,
    HAIR_BELL_REFLECTION: HAIR_REFLECTION,
    HAIR_BELL_TRANSMISSION: HAIR_TRANSMISSION,
}
_LEAST_ROUGHNESS, _LEAST_IOR = 1e-3, 1.0 + 1e-4
_MEAN_WAY, _LEAST_PART = 1.6, 0.1  # through a strand, in radii; of a side's samples
_SCALE = np.float32(math.sqrt(math.pi / 8.0))


class HairValues(NamedTuple):
    """A program.Hair at m points: float32 (m,), of vectors (m, 3); tangent: unit, world space."""

    model: int
    tangent: np.ndarray
    absorption: np.ndarray
    roughness: np.ndarray
    radial: np.ndarray
    coat: np.ndarray
    ior: np.ndarray
    offset: np.ndarray

    def at(self, which) -> HairValues:
        """Those of a slice, a mask or indices."""
        return HairValues(self.model, *rows_of(self[1:], which))


def _variance(roughness):
    """v of a longitudinal roughness [Chiang16, eq. 7]."""
    b = roughness
    return (0.726 * b + 0.812 * b * b + 3.7 * b**20) ** 2


def _scale(roughness):
    """s of an azimuthal roughness [Chiang16, eq. 8]."""
    b = roughness
    return _SCALE * (0.265 * b + 1.194 * b * b + 5.372 * b**22)


def _part_of_side(hair: HairValues, normal, wo, side) -> np.ndarray:
    """float32 (m,): about how much of a strand's light comes from a side; of both together 1.

    In front it is mirrored, at the surface or inside; behind what goes through. Of the Hair BSDF it
    is the half of the sphere towards the viewer, or the other one.
    """
    cosine = np.clip(np.einsum("ij,ij->i", normal, wo), 0.0, 1.0)
    front = 0.5 + 0.5 * cosine
    if hair.model == HAIR_BELL_TRANSMISSION:
        front = 1.0 - front
    elif hair.model == HAIR_CHIANG:
        mirrored = 0.05 + 0.95 * (1.0 - cosine) ** 5
        left = np.exp(-_MEAN_WAY * np.maximum(hair.absorption, 0.0).mean(1))
        through = (1.0 - mirrored) ** 2 * left
        inside = through * mirrored * left
        front = (mirrored + inside) / (mirrored + inside + through)
    front = np.clip(front, _LEAST_PART, 1.0 - _LEAST_PART)
    front[(side == ALL_ROUND) | (side == LAMPS_ALONE)] = 1.0
    return np.float32(np.where(side > 0.0, front, 1.0 - front))


def set_hair(lobes: Lobes, rows: np.ndarray, hair: HairValues, side: np.ndarray) -> None:
    """Make the Lambert lobes of some points hair: Lobes of n points, written to.

    rows: int (m,), of the points; side: float32 (m,), 1, -1 for what shines from behind, or
        ALL_ROUND and LAMPS_ALONE
    The lobes have the strand's normal, and its reflectance as their color: of the Hair BSDF that is
    its factor, of Principled Hair what Cycles' Glossy Color says. Each side gets its part of that,
    and so of the samples (pass_samples.shared_counts).
    """
    part = _part_of_side(hair, lobes.normal[rows], lobes.wo[rows], side)
    lobes.glossy_color[rows] = lobes.diffuse[rows] * part[:, None]
    lobes.kind[rows], lobes.diffuse_share[rows] = DIFFUSE_LOBE, 1.0
    lobes.tangent[rows] = hair.tangent
    lobes.rough[rows, 3], lobes.fresnel[rows, 2] = _MODELS[hair.model], side
    roughness, radial = (np.clip(x, _LEAST_ROUGHNESS, 1.0) for x in (hair.roughness, hair.radial))
    if hair.model != HAIR_CHIANG:
        lobes.rough[rows, :3] = np.stack([roughness, radial, -hair.offset], -1)
        return
    first = np.clip((1.0 - np.clip(hair.coat, 0.0, 1.0)) * roughness, _LEAST_ROUGHNESS, 1.0)
    numbers = _variance(roughness), _variance(first), _scale(radial)
    lobes.diffuse[rows] = 1.0
    lobes.rough[rows, :3] = np.stack(numbers, -1)
    lobes.edge[rows] = np.maximum(hair.absorption, 0.0)
    lobes.fresnel[rows, 0] = np.maximum(hair.ior, _LEAST_IOR)
    lobes.fresnel[rows, 1] = hair.offset


def set_starts(lobes: Lobes, rows: np.ndarray, own: Circles, behind: np.ndarray) -> np.ndarray:
    """Have rays start outside of the round things that points are on: Lobes of n points, written.

    rows: int (m,), of the points; behind: bool (m,); those that are no hair are translucent
    Returns float32 (m,), how far the points themselves are to be moved along the normal, metres.
    """
    leaf = lobes.rough[rows, 3] == 0.0
    leaves = rows[leaf]
    lobes.rough[leaves, 3], lobes.fresnel[leaves, 2] = TRANSLUCENT_ROUND, -1.0
    lobes.tangent[leaves] = own.axis[leaf]
    reversed_ = np.einsum("ij,ij->i", own.axis, lobes.tangent[rows]) < 0.0
    slope = np.where(reversed_, -own.slope, own.slope)
    lobes.f0[rows, DIELECTRIC] = np.stack([own.radius, own.reach, slope], -1)
    return np.where(behind, -own.radius - own.reach, own.reach - own.radius)


def has_world(lobes: Lobes) -> np.ndarray:
    """bool (n,): whether points have light of the world, and not of lamps alone."""
    return (lobes.rough[:, 3] > CHIANG) | (lobes.fresnel[:, 2] != LAMPS_ALONE)
