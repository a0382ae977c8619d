"""Tables of docs/benchmarks.md about error and time, of the JSON that part_error.py writes."""

from __future__ import annotations

import numpy as np
from configurations import CONFIGURATIONS, CYCLES, DEFAULT, FIXED, PAPER, TARGETS
from metrics import cost_at, cost_beyond, error_at, without_noise

NOISE_SHARE = 0.5  # of an error, that a reference's own may be to be taken off
COUNTS = (16, 32, 64)


class Curve:
    """The points of one configuration on one scene, less the reference's own error (noise)."""

    def __init__(self, points: list[dict], noise: float):
        self.points = [p | {"mre": without_noise(p["mre"], noise)} for p in points]
        self.noise = noise

    def column(self, name: str) -> list[float]:
        """One figure of every point."""
        return [point[name] for point in self.points]

    def cost(self, target: float) -> tuple[float | None, str]:
        """CPU seconds to an error, and how to print them; None and why where it is not known."""
        if self.noise > NOISE_SHARE * target:
            return None, "noise"
        cpu, mre = self.column("cpu"), self.column("mre")
        if min(mre) <= target:
            found = cost_at(target, cpu, mre)
            if found is None:  # the first point is better already
                return cpu[0], f"< {seconds(cpu[0])}"
            return found, seconds(found)
        found = cost_beyond(target, cpu, mre)
        return found, f"≈ {seconds(found)}" if found else f"> {seconds(max(cpu))}"

    def value_for(self, cpu: float) -> float:
        """The knob's value that takes so many CPU seconds, in log-log; the ends go on linearly."""
        costs, values = self.column("cpu"), self.column("value")
        log_cost, log_value = np.log(costs), np.log(values)
        inside = np.exp(np.interp(np.log(cpu), log_cost, log_value))
        grows = 1.0 if values[-1] > values[0] else -0.5
        beyond = cpu / costs[-1] if cpu > costs[-1] else min(1.0, cpu / costs[0])
        return float(inside * beyond**grows)

    def at_samples(self, name: str, count: float) -> float | None:
        """A figure at a mean count of samples."""
        return error_at(count, self.column("samples"), self.column(name))


def seconds(value: float) -> str:
    """Three digits."""
    return f"{value:.3g}" if value < 100.0 else f"{value:.0f}"


def curves(scene: dict) -> dict[str, Curve]:
    """Configuration's name -> its curve, in the order of CONFIGURATIONS."""
    noise, found = scene["reference"]["noise"], {}
    for configuration in CONFIGURATIONS:
        own = scene.get("mitsuba_reference") if configuration.renderer == "mitsuba" else None
        points = [p for p in scene["points"] if p["configuration"] == configuration.name]
        if points:
            found[configuration.name] = Curve(points, own["noise"] if own else noise)
    return found


def common_error(found: dict[str, Curve]) -> float:
    """The smallest error that Cycles, IWIS and the reference's noise allow, rounded up."""

    def least_of(*names):
        return min(min(found[name].column("mre")) for name in names if name in found)

    noise = max(curve.noise for curve in found.values()) / NOISE_SHARE
    least = max(noise, least_of(DEFAULT, FIXED), least_of(*{CYCLES} & set(found) or found))
    return next((t for t in (0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.5) if t >= least), 1.0)


def cost_table(scene: dict) -> list[str]:
    """CPU seconds to each error, and how many times as long Cycles takes."""
    found = curves(scene)
    targets = sorted({*TARGETS, common_error(found)}, reverse=True)
    head = " | ".join(f"to MRE {t:g} | Cycles / it" for t in targets)
    lines = [f"| CPU s | {head} |", "|---|" + "---|---|" * len(targets)]
    for name, curve in found.items():
        cells = []
        for target in targets:
            mine, text = curve.cost(target)
            theirs = found[CYCLES].cost(target)[0] if CYCLES in found else None
            cells += [text, f"{theirs / mine:.1f}" if mine and theirs else "-"]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return lines


def equal_samples_table(scene: dict) -> list[str]:
    """Errors of the rules at equal mean counts of samples, and their ratios."""
    found = curves(scene)
    lines = [
        "| mean samples | rule | MRE | p99 | bias | in penumbrae "
        "| MRE / fixed | p99 / fixed | MRE / paper's |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for count in COUNTS:
        fixed, paper = found.get(FIXED), found.get(PAPER)
        for name in (FIXED, PAPER, DEFAULT):
            if name not in found:
                continue
            mre, p99 = (found[name].at_samples(figure, count) for figure in ("mre", "p99"))
            if mre is None:
                continue
            biases = [nearest(found[name], count)[key] for key in ("bias", "penumbra_bias")]
            ratios = [
                _ratio(mre, fixed, "mre", count),
                _ratio(p99, fixed, "p99", count),
                _ratio(mre, paper, "mre", count),
            ]
            lines.append(
                f"| {count} | {name} | {mre:.4f} | {p99:.3f} | {biases[0]:+.2%} | {biases[1]:+.2%} "
                f"| {' | '.join(ratios)} |"
            )
    return lines


def nearest(curve: Curve, count: float) -> dict:
    """The point whose mean count is next to one."""
    return min(curve.points, key=lambda p: abs(p["samples"] / count - 1.0))


def _ratio(value, other, figure, count) -> str:
    beside = other and other.at_samples(figure, count)
    return f"{value / beside:.2f}" if beside else "-"


def points_table(scene: dict) -> list[str]:
    """Every point that was measured, folded away."""
    lines = [
        "<details><summary>All points</summary>",
        "",
        "| | setting | samples | CPU s | MRE | p99 | relMSE | bias |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, curve in curves(scene).items():
        for p in curve.points:
            lines.append(
                f"| {name} | {p['value']:g} | {p['samples']:.1f} | {seconds(p['cpu'])} "
                f"| {p['mre']:.4f} | {p['p99']:.3f} | {p['relmse']:.2g} | {p['bias']:+.2%} |"
            )
    return [*lines, "", "</details>"]
