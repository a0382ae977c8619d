"""How much memory this process may still take, as far as the system tells."""

from __future__ import annotations

import ctypes
import sys
from pathlib import Path

_CGROUP = Path("/sys/fs/cgroup")


def free_memory_bytes() -> int | None:
    """Bytes that can be had without swapping; of a container its own. None: not known."""
    if sys.platform == "win32":
        return _of_windows()
    if sys.platform != "linux":
        return None
    known = [n for n in (_of_linux(), _of_container()) if n is not None]
    return min(known, default=None)


def _of_linux() -> int | None:
    try:
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    except (OSError, ValueError):
        pass
    return None


def _of_container(folder: Path = _CGROUP) -> int | None:
    """Of control groups version 2; what caches of files hold can be had."""
    try:
        limit = (folder / "memory.max").read_text().strip()
        if limit == "max":
            return None
        used = int((folder / "memory.current").read_text())
        kept = dict(line.split() for line in (folder / "memory.stat").read_text().splitlines())
        return max(int(limit) - used + int(kept.get("inactive_file", 0)), 0)
    except (OSError, ValueError):
        return None


class _MemoryStatus(ctypes.Structure):
    _fields_ = (
        ("length", ctypes.c_uint32),
        ("load", ctypes.c_uint32),
        *((name, ctypes.c_uint64) for name in ("total", "free", "a", "b", "c", "d", "e")),
    )


def _of_windows() -> int | None:
    status = _MemoryStatus(length=ctypes.sizeof(_MemoryStatus))
    known = ctypes.windll.kernel32.GlobalMemoryStatusEx(ctypes.byref(status))
    return status.free if known else None
