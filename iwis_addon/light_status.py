"""What is prepared of the light: in memory, and in the cache folder."""

from __future__ import annotations

import time

from .job import RenderJob
from .preferences import cache_dir, folder_bytes

_SECONDS_BETWEEN_LOOKS = 5.0
_seen: dict = {"at": 0.0, "bytes": 0, "folder": None}


def lines() -> list[str]:
    """What the panel says below the HDRI."""
    said = [_in_memory()]
    size = folder_size()
    if size is not None:
        said.append(f"Cache folder: {size / 1e6:.1f} MB")
    if RenderJob.current is not None and RenderJob.current.records:
        said += RenderJob.current.records[-1].stats.tables
    return said


def _in_memory() -> str:
    if RenderJob.current is None or not RenderJob.current.records:
        return "Tables: prepared at the next render, or read from the cache folder"
    seconds = RenderJob.current.records[-1].stats.seconds["tables"]
    return f"Tables: ready in {seconds:.2f} s at the last render"


def folder_size() -> int | None:
    """Bytes of the cache folder, looked up every few seconds at most; None without one."""
    folder = cache_dir()
    if not folder:
        return None
    if folder != _seen["folder"] or time.monotonic() - _seen["at"] > _SECONDS_BETWEEN_LOOKS:
        _seen.update(at=time.monotonic(), bytes=folder_bytes(folder), folder=folder)
    return _seen["bytes"]
