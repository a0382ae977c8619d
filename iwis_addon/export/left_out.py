"""What is not rendered, and what is said of it."""

from __future__ import annotations

UNSUPPORTED_TYPES = {
    "VOLUME": "volumes",
    "GPENCIL": "Grease Pencil",
    "GREASEPENCIL": "Grease Pencil",
}


class LeftOut:
    """Names of what is not rendered, gathered so that each reason is one message."""

    def __init__(self):
        self._names: dict[str, dict[str, None]] = {}

    def add(self, reason: str, name: str):
        self._names.setdefault(reason, {})[name] = None

    def messages(self, shown=5):
        for reason, names in self._names.items():
            first = ", ".join(list(names)[:shown])
            more = f" and {len(names) - shown} more" if len(names) > shown else ""
            yield f"{reason}: {first}{more}"
