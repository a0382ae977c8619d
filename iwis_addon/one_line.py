"""One message, one line: names and paths may hold line breaks."""

from __future__ import annotations

_BREAKS = str.maketrans({"\n": "\\n", "\r": "\\r", "\t": "\\t"})


def one_line(text: str) -> str:
    """The text with line breaks and tabs written as Python writes them."""
    return text.translate(_BREAKS)
