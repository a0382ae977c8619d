"""Writes docs/benchmarks.md and its plots from the results of the suite (JSON)."""

from __future__ import annotations

import json
from pathlib import Path

import plots
import tables
from configurations import EDGE_RADIUS_PX, SCENES

TITLES = {
    "statue_diffuse": "Diffuse statue",
    "statue_glossy": "Glossy statue",
    "foliage": "Foliage",
    "interior": "Interior",
}


def write(folder: Path, page: Path, pictures: Path) -> None:
    """The page, of whatever results there are in a folder."""
    results = read(folder)
    link = pictures.relative_to(page.parent).as_posix()
    lines = head(results)
    for section in (error_section,):
        lines += section(results, pictures, link)
    page.write_text("\n".join(lines).rstrip() + "\n")


def read(folder: Path) -> dict[str, dict]:
    """part or scene.part -> what was measured; the suite's scenes first."""
    found = {path.stem: json.loads(path.read_text()) for path in sorted(folder.glob("*.json"))}
    order = {name: k for k, name in enumerate(SCENES)}
    return dict(
        sorted(found.items(), key=lambda item: order.get(item[0].split(".")[0], len(order)))
    )


def of_part(results: dict, part: str) -> dict[str, dict]:
    """scene -> results of a part."""
    return {
        name.rpartition(".")[0]: found
        for name, found in results.items()
        if name.rpartition(".")[2] == part and "." in name
    }


def title(scene: str) -> str:
    """What a scene is called in headings."""
    return TITLES.get(scene, scene)


def head(results: dict) -> list[str]:
    """Where and of what the figures are."""
    machine = results.get("machine", {})
    versions = dict(machine.get("versions", {}))
    for found in of_part(results, "error").values():
        if "mitsuba_version" in found:
            versions["mitsuba"] = found["mitsuba_version"]
    told = ", ".join(f"{name} {number}" for name, number in versions.items())
    spent = sum(found.get("seconds", 0.0) for found in results.values())
    return [
        "# Benchmarks",
        "",
        "Written by `make bench` (`benchmarks/README.md` says how each figure is made).",
        "",
        f"- Machine: {machine.get('processor')}, {machine.get('cores')} cores, "
        f"{machine.get('memory_gb')} GB, {machine.get('system')}",
        f"- Versions: {told}, Python {machine.get('python')}; Cycles is bpy's",
        f"- Commit {machine.get('commit')}; {spent / 60.0:.0f} minutes in all",
        "- CPU seconds are user + system time of sampling, all threads; medians of runs by turns",
        "- Error: mean relative error (MRE) of luminance over object pixels brighter than .1 % of",
        f"  the mean; pixels with an edge within {EDGE_RADIUS_PX:g} px of their centre are left out",
        "",
    ]


def error_section(results, pictures, link) -> list[str]:
    """Tables of cost, tables at equal samples, plots."""
    scenes = of_part(results, "error")
    if not scenes:
        return []
    plots.error_curves(scenes, pictures / "bench_error.png", title)
    lines = ["## Error against CPU time", "", f"![Error against time]({link}/bench_error.png)", ""]
    lines += [
        "`noise`: the reference's own error is more than a quarter of that; `≈`: the curve goes on",
        "as it ended; `>`: not reached; `Cycles / it`: how many times as long Cycles takes.",
        "",
    ]
    for name, scene in scenes.items():
        lines += [f"### {title(name)}", "", _about(scene), "", *tables.cost_table(scene), ""]
    lines += ["## The stop rules at equal mean counts", ""]
    for name, scene in scenes.items():
        lines += [f"### {title(name)}", "", *tables.equal_samples_table(scene), ""]
    return lines


def _about(scene) -> str:
    reference = scene["reference"]
    text = (
        f"{scene['width']}x{scene['height']}, {scene['triangles']:,} triangles; "
        f"{scene['measured_pixels']:,} of {scene['object_pixels']:,} object pixels measured, "
        f"{scene['edge_pixels']:,} have an edge at the centre. Reference: IWIS UNBIASED, "
        f"{reference['samples']:,} samples, own error {reference['noise']:.2%} "
        f"(commit {reference['commit']})."
    )
    own = scene.get("mitsuba_reference")
    if own:
        text += (
            f" Mitsuba's BSDF is another: its error is against its own picture of "
            f"{own['samples']:,} samples (own error {own['noise']:.2%}), which differs from the "
            f"reference by {own['difference']:.1%}."
        )
    return f"{text} Load before: {scene['load']:.1f}."
