"""Writes docs/benchmarks.md and its plots from the results of the suite (JSON)."""

from __future__ import annotations

import json
from pathlib import Path

from configurations import EDGE_RADIUS_PX, SCENES
from sections import SECTIONS, of_part


def write(folder: Path, page: Path, pictures: Path) -> None:
    """The page, of whatever results there are in a folder."""
    results = read(folder)
    link = pictures.relative_to(page.parent).as_posix()
    lines = head(results)
    for section in SECTIONS:
        lines += section(results, pictures, link)
    page.write_text("\n".join(lines).rstrip() + "\n")


def read(folder: Path) -> dict[str, dict]:
    """part or scene.part -> what was measured; the suite's scenes first."""
    found = {path.stem: json.loads(path.read_text()) for path in sorted(folder.glob("*.json"))}
    order = {name: k for k, name in enumerate(SCENES)}
    return dict(
        sorted(found.items(), key=lambda item: order.get(item[0].split(".")[0], len(order)))
    )


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
        f"  the mean; pixels with an edge within {EDGE_RADIUS_PX:g} px of their centre left out",
        "",
    ]
