"""The sections of docs/benchmarks.md: each takes the results, writes its plots, returns lines."""

from __future__ import annotations

import plots
import tables
from configurations import CYCLES, DEFAULT, FIXED
from export_section import export_section

TITLES = {
    "statue_diffuse": "Diffuse statue",
    "statue_glossy": "Glossy statue",
    "foliage": "Foliage",
    "interior": "Interior",
}
MEGABYTE = 1e6


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


def summary(results, pictures, link) -> list[str]:
    """One row a scene: the ratios that are aimed at."""
    scenes = of_part(results, "error")
    if not scenes:
        return []
    rays, threads = of_part(results, "rays"), of_part(results, "threads")
    lines = ["## In short", ""]
    lines += [
        "CPU time of Cycles, and of the faster of Mitsuba's ways, over that of IWIS (PERCEPTUAL /",
        "fixed count) to the same error: .05, or the smallest that all allow. Beside it one",
        "thread's CPU time over that of its shadow rays alone, at the counts of the table",
        f"below{_counts(rays)}, and the speed of 2 threads over 1.",
        "",
        "| scene | MRE | Cycles / IWIS | Mitsuba / IWIS | total / rays | threads |",
        "|---|---|---|---|---|---|",
    ]
    for name, scene in scenes.items():
        found = tables.curves(scene)
        error = max(0.05, tables.common_error(found))
        cycles = _over(found, [CYCLES], error)
        mitsuba = _over(found, [n for n in found if n.startswith("Mitsuba")], error)
        counts = rays[name]["counts"] if name in rays else []
        ratio = " / ".join(f"{row['ratio']:.2f}" for row in counts) or "-"
        speedup = f"{threads[name]['speedup']:.2f}" if name in threads else "-"
        lines.append(f"| {title(name)} | {error:g} | {cycles} | {mitsuba} | {ratio} | {speedup} |")
    return [*lines, ""]


def _counts(rays) -> str:
    """The counts of samples of the part rays, in brackets."""
    for scene in rays.values():
        return f" ({' / '.join(str(row['samples']) for row in scene['counts'])})"
    return ""


def _over(found, names, error) -> str:
    """The least cost of some ways over IWIS' two, as text."""
    costs = [found[name].cost(error)[0] for name in names if name in found]
    theirs = min((cost for cost in costs if cost), default=None)
    mine = [found[name].cost(error)[0] if name in found else None for name in (DEFAULT, FIXED)]
    return " / ".join(f"{theirs / cost:.1f}" if theirs and cost else "-" for cost in mine)


def error_section(results, pictures, link) -> list[str]:
    """Tables of cost, tables at equal samples, plots."""
    scenes = of_part(results, "error")
    if not scenes:
        return []
    plots.error_curves(scenes, pictures / "bench_error.png", title)
    lines = ["## Error against CPU time", "", f"![Error against time]({link}/bench_error.png)", ""]
    lines += [
        "The reference's own error is taken off, in squares; `noise`: it is more than half of it;",
        "`≈`: if the curve goes on as it ended; `>`: not reached; `Cycles / it`: how many times as",
        "long Cycles takes.",
        "",
    ]
    for name, scene in scenes.items():
        lines += [f"### {title(name)}", "", _about(scene), "", *tables.cost_table(scene), ""]
        lines += [*tables.points_table(scene), ""]
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


def rays_section(results, pictures, link) -> list[str]:
    """Total over rays."""
    scenes = of_part(results, "rays")
    if not scenes:
        return []
    lines = ["## Beside the shadow rays alone", ""]
    lines += [
        "One thread, fixed counts; `total` has the camera rays in it. The same shadow rays in the",
        "same order and batches: through embreex alone, and by IWIS' own call of the same library,",
        "each asked once.",
        "",
        "| scene | samples | shadow rays | total, CPU s | camera rays | embreex, CPU s | own call "
        "| total / embreex | total / own |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name, r in ((name, row) for name, scene in scenes.items() for row in scene["counts"]):
        each = {way: r[way] / r["shadow_rays"] * 1e6 for way in ("shadow", "shadow_own")}
        lines.append(
            f"| {title(name)} | {r['samples']} | {r['shadow_rays']:,} | {r['total']:.3f} "
            f"| {r['primary']:.3f} | {r['shadow']:.3f} ({each['shadow']:.2f} µs a ray) "
            f"| {r['shadow_own']:.3f} ({each['shadow_own']:.2f} µs) | {r['ratio']:.2f} "
            f"| {r['ratio_own']:.2f} |"
        )
    return [*lines, ""]


def threads_section(results, pictures, link) -> list[str]:
    """One thread against more."""
    scenes = of_part(results, "threads")
    if not scenes:
        return []
    lines = ["## Threads", "", "Wall-clock seconds of sampling; medians, by turns.", ""]
    lines += ["| scene | samples | 1 thread | more | times as fast | CPU s of both | load before |"]
    lines.append("|---|---|---|---|---|---|---|")
    for name, t in scenes.items():
        one, more = t["wall"]
        lines.append(
            f"| {title(name)} | {t['samples']} | {one:.3f} | {more:.3f} ({t['threads'][1]}) "
            f"| {t['speedup']:.2f} | {t['cpu'][0]:.3f}, {t['cpu'][1]:.3f} | {t['load']:.1f} |"
        )
    return [*lines, ""]


def pictures_section(results, pictures, link) -> list[str]:
    """The JPEGs and what they show."""
    scenes = of_part(results, "pictures")
    if not scenes:
        return []
    lines = ["## The same CPU time", ""]
    for name, p in scenes.items():
        lines += [f"![{title(name)} at equal time]({link}/bench_{name}.jpg)", ""]
        for s in p["shots"]:
            lines.append(
                f"- {s['name']}: {s['samples']:.1f} samples, {s['cpu']:.2f} CPU s, "
                f"MRE {s['mre']:.3f}, p99 {s['p99']:.2f}"
            )
        lines.append("")
    lines += ["## Against Cycles, converged", ""]
    lines += [
        "Two pictures a side. `ratio`: the mean difference of a pixel over what the noise of both",
        "explains; red where IWIS is brighter, blue where it is darker.",
        "",
        "| scene | samples | signed | mean absolute | noise | ratio |",
        "|---|---|---|---|---|---|",
    ]
    for name, p in scenes.items():
        c = p["check"]
        lines.append(
            f"| {title(name)} | 2 x {c['samples']} | {c['signed']:+.3%} | {c['mean_absolute']:.2%} "
            f"| {c['noise']:.2%} | {c['ratio']:.2f} |"
        )
    lines.append("")
    lines += [f"![{title(n)}: IWIS, Cycles]({link}/bench_{n}_difference.jpg)\n" for n in scenes]
    return lines


def scaling_section(results, pictures, link) -> list[str]:
    """Cost against size."""
    found = results.get("scaling")
    if not found:
        return []
    plots.scaling_curves(found, pictures / "bench_scaling.png")
    lines = ["## How the cost grows", "", f"![Scaling]({link}/bench_scaling.png)", ""]
    lines += ["A bumpy ball, diffuse, one thread, 32 samples.", ""]
    lines += ["| triangles | BVH, CPU s | BVH, bytes a triangle | table, bytes | sampling, CPU s |"]
    lines.append("|---|---|---|---|---|")
    for row in found["triangles"]:
        n = row["triangles"]
        lines.append(
            f"| {n:,} | {row['bvh_cpu']:.2f} | {row['bvh_bytes'] / n:.0f} "
            f"| {row['table_bytes'] / n:.0f} | {row['cpu']:.3f} |"
        )
    lines += [
        "",
        "| HDRI | image, MB | preparing, CPU s | again | peak, MB more | sampling, CPU s |",
    ]
    lines.append("|---|---|---|---|---|---|")
    for row in found["hdri"]:
        width = row["value"]
        lines.append(
            f"| {width}x{width // 2} | {row['image_bytes'] / MEGABYTE:.0f} "
            f"| {row['prepare_cpu']:.2f} | {row['again_cpu']:.2f} "
            f"| {row['peak_bytes'] / MEGABYTE:.0f} | {row['cpu']:.3f} |"
        )
    for name, what in (("pixels", "picture"), ("samples", "samples")):
        lines += ["", f"| {what} | sampling, CPU s | µs a sample |", "|---|---|---|"]
        for row in found[name]:
            lines.append(f"| {_size(name, row)} | {row['cpu']:.3f} | {row['each'] * 1e6:.2f} |")
    return [*lines, ""]


def _size(name, row) -> str:
    return f"{row['value']}x{row['value']}" if name == "pixels" else str(row["value"])


def startup_section(results, pictures, link) -> list[str]:
    """Seconds since the process began."""
    found = results.get("startup")
    if not found:
        return []
    names = {
        "imports": "modules imported",
        "file_open": "file open",
        "export_starts": "export starts",
        "export_ends": "export ends",
        "first_tile": "first tile in Blender",
        "rendered": "picture written",
        "cpu": "CPU s of the process",
    }
    lines = ["## Start-up", ""]
    lines += [
        "Wall-clock seconds since the process began, diffuse statue; cold: an empty cache folder.",
        "",
        "| | warm | cold |",
        "|---|---|---|",
    ]
    for name, text in names.items():
        lines.append(f"| {text} | {found['warm'][name]:.2f} | {found['cold'][name]:.2f} |")
    after = {k: found[k]["first_tile"] - found[k]["export_ends"] for k in ("warm", "cold")}
    lines.append(f"| **export to first tile** | {after['warm']:.2f} | {after['cold']:.2f} |")
    compiled = found["compiled_by_settings"]
    lines += [
        "",
        f"{found['kernels']} kernels; all choices of settings compiled {len(compiled)} more",
    ]
    lines[-1] += f" ({', '.join(compiled)})." if compiled else "."
    lines.append(f"Load before: {found['load']:.1f}.")
    return [*lines, ""]


SECTIONS = (
    summary,
    error_section,
    pictures_section,
    rays_section,
    threads_section,
    scaling_section,
    startup_section,
    export_section,
)
