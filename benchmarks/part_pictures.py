"""Part "pictures": the same CPU time for each of four ways, side by side; differences to Cycles.

The time is what IWIS' rule PERCEPTUAL needs for a moderate error, taken from the curves of the part
"error", which has to be there; so are the counts that the others can afford.
"""

from __future__ import annotations

import json

import numpy as np
import tables
from agreement import compare
from configurations import CONFIGURATIONS, CYCLES, DEFAULT, MIS, WIS
from methods import Renderers, make_method
from metrics import errors
from pictures import developed, difference_picture, save_jpeg
from run_core import CoreRun
from run_cycles import render_cycles

SIDE_BY_SIDE = (DEFAULT, CYCLES, WIS, MIS)
GAIN = 10.0  # of the difference picture: 10 % is full colour
SEED = 4242


def measure(bench) -> dict:
    """Write two JPEGs; what they show, for JSON."""
    scene = json.loads((bench.folder / f"{bench.name}.error.json").read_text())
    renderers = Renderers(
        bench.scene, bench.run, CoreRun(bench.run.scene, bench.run.cache, bench.threads), None
    )
    hit, edges = bench.masks()
    mask = hit & ~edges
    reference = bench.kept_reference("iwis", renderers, mask).mean
    shots = _equal_time(scene, renderers, bench.effort.picture_error, reference, mask)
    white = float(np.quantile(reference[hit], 0.98))
    panels = [developed(np.where(hit[..., None], shot["rgb"], 0.0), white) for shot in shots]
    panels.append(developed(np.where(hit[..., None], reference, 0.0), white))
    names = [shot["name"] for shot in shots] + ["reference"]
    save_jpeg(bench.pictures / f"bench_{bench.name}.jpg", *panels, names=names)
    found = {"shots": [{k: v for k, v in shot.items() if k != "rgb"} for shot in shots]}
    samples = round(tables.curves(scene)[CYCLES].value_for(bench.effort.check_seconds))
    return found | {"check": _check(bench, samples, mask, hit, white)}


def _equal_time(scene, renderers, error, reference, mask) -> list[dict]:
    curves = tables.curves(scene)
    seconds = curves[DEFAULT].cost(max(error, min(curves[DEFAULT].column("mre"))))[0]
    if seconds is None:
        seconds = max(curves[DEFAULT].column("cpu")) / 2.0
    shots = []
    for configuration in CONFIGURATIONS:
        if configuration.name not in SIDE_BY_SIDE:
            continue
        method = make_method(configuration, renderers)
        method(configuration.value(0), SEED)  # whatever is built once
        value = curves[configuration.name].value_for(seconds)
        if configuration.factor > 1.0:
            value = max(1, round(value))
        shot = method(value, SEED + 1)
        found = errors(shot.rgb, reference, mask)
        shots.append(
            {
                "name": configuration.name,
                "rgb": shot.rgb,
                "value": value,
                "samples": shot.samples,
                "cpu": shot.cpu,
                "mre": found.mre,
                "p99": found.p99,
            }
        )
    return shots


def _check(bench, samples, mask, hit, white) -> dict:
    """IWIS UNBIASED at a fixed count against Cycles, two pictures each; writes the difference."""
    changes = {"stop_rule": "FIXED", "max_samples": samples}
    mine = [
        bench.run.render(seed=SEED + k, **changes)[0].layers["combined"][..., :3] for k in range(2)
    ]
    timed = [render_cycles(bench.scene, samples, seed=SEED + k) for k in range(2)]
    theirs = [shot.rgb for shot in timed]
    agreement, difference = compare(mine, theirs, mask & (timed[0].alpha > 0.5))
    panels = [
        developed(np.where(hit[..., None], np.mean(p, 0), 0.0), white) for p in (mine, theirs)
    ]
    panels.append(difference_picture(difference, GAIN))
    names = ["IWIS", "Cycles", f"difference, {1 / GAIN:.0%} full"]
    save_jpeg(bench.pictures / f"bench_{bench.name}_difference.jpg", *panels, names=names)
    return agreement._asdict() | {"ratio": agreement.ratio, "samples": samples}
