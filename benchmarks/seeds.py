"""Do ten renders of a fixed count agree with 64 k samples of another estimator, pixel by pixel?

    python benchmarks/seeds.py [--samples 256] [--seeds 10] [--reference 65536] [--side 20] [NUMBER]

Twelve pairs of material and HDRI on a bumpy ball of 600 smooth-shaded triangles under a roof, its
color and roughness another on each triangle. The reference is reference.py: MIS of light and
BSDF sampling, with Halton points; only BRDF, look-up and Embree are the same code.

The standard error is estimated from the ten seeds themselves, so the difference over it follows
Student's t with 9 degrees of freedom, not the normal: 3 standard errors hold 98.50 % of the pixels
of a right estimator, and what 3 hold of a normal, 99.73 %, is held by 4.094. Both are printed, with
the share of a twin that is 2 % too bright: a test that does not see that one proves nothing.
Pixels darker than .1 % of the mean are left out: where ten renders saw nothing but the one ray in
a million that slips out under the roof is missing, their standard error is 0.
"""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path
from typing import NamedTuple

import ball
import numpy as np
from metrics import DARK, luminance
from run_core import CoreRun

from iwis.core.exr import read_exr_layers
from iwis.core.film import Film
from iwis.core.render import RenderCache, render
from iwis.core.scene import (
    DIFFUSE,
    GGX,
    PRINCIPLED,
    EnvironmentMap,
    MaterialParams,
    Scene,
    TriangleMesh,
)
from iwis.core.settings import RenderSettings

HDRIS = Path(__file__).resolve().parent.parent / "sample_blends" / "hdri"
# Material: its name and roughness; HDRI: a file, or a sun of 0.5 degrees, or one texel of 64 x 32.
PAIRS = (
    ("diffuse 1", "hall"),
    ("diffuse 1", "sun"),
    ("plastic .05", "hall"),
    ("plastic .05", "sun"),
    ("plastic .3", "sunset"),
    ("plastic .6", "workshop"),
    ("metal 0", "sunrise"),
    ("metal .1", "hall"),
    ("metal .1", "sun"),
    ("metal .2", "workshop"),
    ("metal .3", "texel"),
    ("metal .5", "sunset"),
)
SUN = np.array([-0.45, -0.75, 0.5]) / np.linalg.norm([-0.45, -0.75, 0.5])
_SKY, _SUN_OVER_SKY = 0.5, 1e5
_ROWS = 24  # different materials on the ball
_REPLICATES = 16  # independent parts of the reference, which tell its own error
# Two-sided, P = .0027: what 3 is to the normal distribution.
T9_LIMIT = 4.094


class Agreement(NamedTuple):
    """pixels: how many; within_3, within_t, twin_t: the share of them within 3 standard errors, and
    within T9_LIMIT, of the estimator and of one that is 2 % too bright; worst: the largest distance
    in standard errors; difference: of the means of both pictures, relative; error: of that
    """

    pixels: int
    within_3: float
    within_t: float
    twin_t: float
    worst: float
    difference: float
    error: float


def world(name: str) -> EnvironmentMap:
    """The HDRI of a pair."""
    if name == "texel":
        radiance = np.zeros((32, 64, 3), np.float32)
        radiance[21, 41] = 100.0
    elif name == "sun":
        latitude = ((np.arange(512) + 0.5) / 512 - 0.5)[:, None] * math.pi
        longitude = (0.5 - (np.arange(1024) + 0.5) / 1024) * 2.0 * math.pi
        level, up = np.cos(latitude), np.sin(latitude) + 0.0 * longitude
        cosine = SUN[0] * level * np.cos(longitude) + SUN[1] * level * np.sin(longitude)
        disc = cosine + SUN[2] * up > math.cos(math.radians(0.25))
        radiance = np.where(disc, _SUN_OVER_SKY * _SKY, _SKY)[..., None].repeat(3, axis=-1)
    else:
        (layers,) = read_exr_layers(HDRIS / f"{name}.exr").values()
        radiance = layers[..., :3]
    return EnvironmentMap(radiance=np.ascontiguousarray(radiance, np.float32))


def materials(name: str) -> MaterialParams:
    """_ROWS of them: roughness within a fifth of that in the name, colors at random."""
    kind, roughness = name.split()
    rng = np.random.default_rng(7)
    spread = 1.0 + 0.2 * rng.uniform(-1.0, 1.0, _ROWS)
    ones = np.ones(_ROWS, np.float32)
    return MaterialParams(
        model=np.full(_ROWS, DIFFUSE if kind == "diffuse" else PRINCIPLED, np.int8),
        distribution=np.full(_ROWS, GGX, np.int8),
        base_color=rng.uniform(0.2, 0.9, (_ROWS, 3)).astype(np.float32),
        metallic=ones if kind == "metal" else 0.0 * ones,
        roughness=np.minimum(float(roughness) * spread, 1.0).astype(np.float32),
        ior=1.5 * ones,
        specular_level=0.5 * ones,
        specular_tint=np.ones((_ROWS, 3), np.float32),
        emission=np.zeros((_ROWS, 3), np.float32),
        diffuse_roughness=np.zeros(_ROWS, np.float32),
    )


def _with_roof(mesh: TriangleMesh) -> TriangleMesh:
    """The ball and a square over a quarter of it; a material of its own for each triangle."""
    corners = np.float32([[-1.6, -1.5, 0.9], [0.1, -1.5, 0.9], [0.1, 0.6, 1.3], [-1.6, 0.6, 1.3]])
    normal = np.cross(corners[1] - corners[0], corners[3] - corners[0])
    normal /= np.linalg.norm(normal)
    roof = np.int32([[0, 1, 2], [0, 2, 3]])
    triangles = np.concatenate([mesh.triangles, roof + np.int32(len(mesh.vertices))])
    index = np.arange(len(triangles))
    return TriangleMesh(
        vertices=np.concatenate([mesh.vertices, corners]),
        triangles=triangles,
        corner_normals=np.concatenate(
            [mesh.corner_normals, np.tile(normal, (2, 3, 1)).astype(np.float32)]
        ),
        material_index=(index * 7 % _ROWS).astype(np.int32),
        object_index=np.zeros(len(triangles), np.int32),
    )


def pair_scene(material: str, hdri: str, side: int) -> Scene:
    """What is rendered for a pair, side x side pixels."""
    plain = ball.scene(ball.ball(600), world(hdri), side)
    return Scene(
        mesh=_with_roof(plain.mesh),
        materials=materials(material),
        environment=plain.environment,
        camera=plain.camera,
        material_pass_index=np.zeros(_ROWS, np.float32),
        object_pass_index=plain.object_pass_index,
    )


def renders(scene: Scene, cache: RenderCache, samples: int, seeds: int) -> np.ndarray:
    """float64 (seeds, h, w): luminance of renders at a fixed count; NaN where nothing is hit."""
    pictures = []
    for seed in range(seeds):
        settings = RenderSettings(
            stop_rule="FIXED", max_samples=samples, pixel_filter="CENTER", seed=seed, threads=1
        )
        film = Film(scene.camera.region)
        render(scene, settings, film, cache)
        hit = film.layers["depth"][..., 0] < 1e9
        pictures.append(np.where(hit, luminance(film.layers["combined"][..., :3]), np.nan))
    return np.array(pictures, np.float64)


def references(scene: Scene, cache: RenderCache, samples: int) -> np.ndarray:
    """float64 (_REPLICATES, h, w): luminance of independent parts of ``samples`` samples by MIS."""
    run, each = CoreRun(scene, cache, 1), max(1, samples // _REPLICATES)
    parts = [run.render("mis", each, 1000 + part).rgb for part in range(_REPLICATES)]
    return np.array([luminance(part) for part in parts], np.float64)


def agreement(pictures: np.ndarray, reference: np.ndarray) -> Agreement:
    """Compare renders with the parts of a reference, both (n, h, w), where ``pictures`` is a
    number.
    """
    hit = np.isfinite(pictures[0])
    hit &= reference.mean(0) > DARK * reference.mean(0)[hit].mean()
    ours, theirs = pictures[:, hit], reference[:, hit]
    mean, truth = ours.mean(0), theirs.mean(0)
    variance = ours.var(0, ddof=1) / len(ours) + theirs.var(0, ddof=1) / len(theirs)
    # float32 pictures: where nothing varies (no light, or all of it exact) they differ by rounding
    error = np.sqrt(variance + (1e-6 * truth) ** 2 + 1e-30)
    distance = np.abs(mean - truth) / error
    twin = np.abs(1.02 * mean - truth) / np.sqrt(variance * 1.02**2 + (1e-6 * truth) ** 2 + 1e-30)
    return Agreement(
        pixels=int(hit.sum()),
        within_3=float((distance <= 3.0).mean()),
        within_t=float((distance <= T9_LIMIT).mean()),
        twin_t=float((twin <= T9_LIMIT).mean()),
        worst=float(distance.max()),
        difference=float(mean.sum() / truth.sum() - 1.0),
        error=float(np.sqrt((error**2).sum()) / truth.sum()),
    )


def least_share(pixels: int, chance: float) -> float:
    """The share of right pixels that a right estimator falls short of once in a thousand times."""
    right, tail = pixels, 0.0
    while right >= 0:
        wrong = pixels - right
        log = math.lgamma(pixels + 1) - math.lgamma(right + 1) - math.lgamma(wrong + 1)
        tail += math.exp(log + right * math.log(1.0 - chance) + wrong * math.log(chance))
        if tail > 0.999:
            break
        right -= 1
    return right / pixels


def main() -> None:
    """Print a line for each pair."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pairs", nargs="*", type=int, help="numbers of pairs, from 1; default all")
    parser.add_argument("--samples", type=int, default=256, help="of a pixel, each seed")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--reference", type=int, default=1 << 16, help="samples of a pixel, in all")
    parser.add_argument("--side", type=int, default=20, help="of the picture, in pixels")
    given = parser.parse_args()
    print(
        "pair                     pixels   3 s.e.  4.09 s.e. (least)   2 % off  worst   difference"
    )
    for number, (material, hdri) in enumerate(PAIRS, 1):
        if given.pairs and number not in given.pairs:
            continue
        started, cache = time.process_time(), RenderCache()
        scene = pair_scene(material, hdri, given.side)
        found = agreement(
            renders(scene, cache, given.samples, given.seeds),
            references(scene, cache, given.reference),
        )
        print(
            f"{number:2} {material:11} {hdri:9} {found.pixels:6} {100 * found.within_3:7.2f} %"
            f" {100 * found.within_t:7.2f} % ({100 * least_share(found.pixels, 0.0027):.2f})"
            f" {100 * found.twin_t:7.1f} % {found.worst:6.1f}"
            f"   {100 * found.difference:+.3f} +- {100 * found.error:.3f} %"
            f"   {time.process_time() - started:.0f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
