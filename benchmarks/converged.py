"""References: the mean of two independent halves, whose difference tells the mean's own error.

A half is the mean of pictures with seeds of their own; pictures are added by turns until the error
is small enough or the time is used up. Kept in a folder, by a hash of what is rendered.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import NamedTuple

import numpy as np
from metrics import luminance, measured_pixels


class Converged(NamedTuple):
    """mean: float64 (h, w, 3); noise: its mean relative error; samples: a pixel, of both halves
    together; cpu: seconds; commit: of the checkout that made it."""

    mean: np.ndarray
    noise: float
    samples: int
    cpu: float
    commit: str


def converge(render, mask, effort, seconds: float, commit: str) -> Converged:
    """Render two halves.

    render: (samples, seed) -> (picture (h, w, 3), samples taken, CPU seconds); mask: bool (h, w)
    """
    halves, cpu, samples, rounds = None, 0.0, 0, 0
    while True:
        pair = [render(effort.reference_samples, 100_000 + 2 * rounds + k) for k in range(2)]
        pictures = np.array([picture for picture, _, _ in pair], np.float64)
        halves = pictures if halves is None else halves + (pictures - halves) / (rounds + 1)
        rounds += 1
        samples += sum(taken for _, taken, _ in pair)
        cpu += sum(seconds for _, _, seconds in pair)
        noise = own_noise(*halves, mask)
        if noise <= effort.reference_noise or cpu * (1.0 + 1.0 / rounds) > seconds:
            return Converged(halves.mean(axis=0), noise, samples, cpu, commit)


def own_noise(a, b, mask) -> float:
    """Mean relative error of the mean of two halves: half their difference is distributed as it."""
    mean = (np.asarray(a, np.float64) + b) / 2.0
    used = measured_pixels(mean, mask)
    error = np.abs(luminance(a) - luminance(b))[used] / 2.0
    return float((error / luminance(mean)[used]).mean())


def key_of(scene, effort) -> str:
    """Hash of an exported scene and of how good the reference has to be."""
    digest = hashlib.blake2b(repr((effort, scene.camera.window, scene.camera.region)).encode())
    mesh, light = scene.mesh, scene.environment
    arrays = (mesh.vertices, mesh.triangles, mesh.corner_normals, mesh.material_index)
    for array in (*arrays, *scene.materials, light.radiance, light.world_to_map, light.strength):
        digest.update(np.ascontiguousarray(array))
    digest.update(np.ascontiguousarray(scene.camera.camera_to_world))
    return digest.hexdigest()[:16]


def kept(path: Path, make, renew: bool = False) -> Converged:
    """What path holds; made by make() and kept there if there is none, or if renew says so."""
    if renew or not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(path, **make()._asdict())
    with np.load(path) as data:
        return Converged(data["mean"], *(data[name].item() for name in Converged._fields[1:]))
