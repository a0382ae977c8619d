"""Why whole scenes differ that do, by name: what was found out."""

WHY: dict[str, str] = {}
