"""Whether a saved picture is whole, by what its file says of itself: a full disk cuts it short.

An OpenEXR file lists where each of its chunks begins. Writers leave room for that list, write the
chunks, and fill it in last. Only headers are read, and no library is asked: Blender's own would
print, and the OpenEXR package must not be loaded beside it.
"""

from __future__ import annotations

import struct
from pathlib import Path

# Suffixes of formats that say whether they are whole.
KNOWN = {".png", ".exr"}

_PNG_END = b"IEND\xaeB`\x82"
_EXR_MAGIC = b"v/1\x01"
_TILED, _MULTIPART = 0x200, 0x1000  # bits of an OpenEXR file's version
# Lines of a chunk, by the number of the compression.
_LINES = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32, 5: 16, 6: 32, 7: 32, 8: 32, 9: 256, 10: 256, 11: 32}


def is_cut_short(path: Path) -> bool:
    """Whether a file lacks some of its end; False too for formats that cannot be asked.

    Raises OSError where it cannot be read.
    """
    if path.is_fifo():  # nobody would answer
        return False
    suffix = path.suffix.lower()
    with path.open("rb") as file:
        size = file.seek(0, 2)
        if size == 0:
            return True
        if suffix == ".png":
            file.seek(max(size - len(_PNG_END), 0))
            return file.read() != _PNG_END
        file.seek(0)
        if suffix != ".exr":
            return False
        try:
            return _lacks_chunks(file, size)
        except (EOFError, struct.error):
            return True


def _lacks_chunks(file, size: int) -> bool:
    if file.read(4) != _EXR_MAGIC:
        return True
    (version,) = struct.unpack("<i", file.read(4))
    multipart = bool(version & _MULTIPART)
    parts = [_header(file)]
    while multipart and (part := _header(file)):
        parts.append(part)
    counts = [_chunk_count(part) for part in parts]
    if version & _TILED or None in counts:
        return False
    places = struct.unpack(f"<{sum(counts)}Q", file.read(8 * sum(counts)))
    if min(places) == 0 or max(places) >= size:
        return True
    file.seek(max(places) + (4 if multipart else 0))
    if any(part.get("type", b"").startswith(b"deep") for part in parts):
        return False
    _line, length = struct.unpack("<ii", file.read(8))
    return file.tell() + length > size


def _header(file) -> dict[str, bytes]:
    """The attributes of one part by their names; none at the end of all headers."""
    found = {}
    while name := _text(file):
        _text(file)  # its type
        (length,) = struct.unpack("<i", file.read(4))
        found[name] = file.read(length)
    return found


def _text(file) -> str:
    letters = bytearray()
    while (letter := file.read(1)) != b"\0":
        if not letter:
            raise EOFError
        letters += letter
    return letters.decode("latin-1")


def _chunk_count(part: dict[str, bytes]) -> int | None:
    """How many chunks a part has; None where that is not known."""
    if "chunkCount" in part:
        return struct.unpack("<i", part["chunkCount"])[0]
    _x0, y0, _x1, y1 = struct.unpack("<4i", part["dataWindow"])
    lines = _LINES.get(part["compression"][0])
    return None if lines is None else -(-(y1 - y0 + 1) // lines)
