"""The report's section of exports: what comes before the core, and the memory of instances."""

_EXPORTS = {
    "triangles": "one mesh with UVs, custom normals, an image; nothing changes",
    "moving_triangles": "the same, and a box that moves",
    "objects": "objects with a mesh each; one moves",
    "linked_objects": "objects that share a mesh; one moves",
    "instances": "instances of geometry nodes",
}


def export_section(results, pictures, link) -> list[str]:
    """What comes before the core, and the memory of instances."""
    found = results.get("export")
    if not found:
        return []
    lines = ["## Export", ""]
    lines += [
        "Seconds from an evaluated scene to the core's arrays; medians. The next frame has a",
        "new graph: meshes are read and compared, what has changed is placed.",
        "",
        "| scene | objects | triangles | wall s | CPU s | next frame, wall s |",
        "|---|---|---|---|---|---|",
    ]
    for name, text in _EXPORTS.items():
        row = found[name]
        following = f"{row['next_wall']:.2f}" if "next_wall" in row else "-"
        lines.append(
            f"| {text} | {row['objects']:,} | {row['triangles']:,} | {row['wall']:.2f} "
            f"| {row['cpu']:.2f} | {following} |"
        )
    row = found["instances"]
    n, places = row["triangles"], row["objects"]
    rest = (row["export_bytes"] - row["table_bytes"]) / places
    return [
        *lines,
        "",
        f"Memory of the {places:,} instances, written out in world space: "
        f"{row['table_bytes'] / n:.0f} bytes a triangle for the table, "
        f"{row['bvh_bytes'] / n:.0f} for the hierarchy ("
        f"{row['bvh_peak_bytes'] / n:.0f} while it is built), and {rest:.0f} bytes an instance. "
        f"Peak of the export: {row['peak_bytes'] / 1e6:.0f} MB. "
        f"Load before: {found['load']:.1f}.",
        "",
    ]
