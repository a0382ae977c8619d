"""What a measurement was made on: processor, cores, versions, commit, load."""

from __future__ import annotations

import os
import platform
import subprocess
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("bpy", "numpy", "numba", "embreex")


def describe() -> dict:
    """Names and numbers for the head of the report."""
    return {
        "processor": processor(),
        "cores": cores(),
        "memory_gb": round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9),
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        "versions": {name: _version(name) for name in PACKAGES},
        "commit": commit(),
    }


def processor() -> str:
    """The CPU's model, with the widest vectors it has."""
    model, flags = platform.machine(), ""
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        key, _, value = line.partition(":")
        if key.strip() == "model name":
            model = value.strip()
        if key.strip() == "flags":
            flags = value
    widest = next((name for name in ("avx512f", "avx2", "avx") if name in flags.split()), "")
    return f"{model} ({widest})" if widest else model


def cores() -> int:
    """How many this process may use."""
    return len(os.sched_getaffinity(0))


def load() -> float:
    """Processes that ran or waited in the last minute, on average: 0 on a quiet machine."""
    return os.getloadavg()[0]


def commit() -> str:
    """The checkout's commit, with + where the shipped code differs from it."""
    try:
        name = _git("rev-parse", "--short", "HEAD")
        changed = _git("status", "--porcelain", "--", "core", "iwis_addon")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return f"{name}+" if changed else name


def _git(*arguments: str) -> str:
    return subprocess.check_output(
        ["git", "-C", ROOT, *arguments], text=True, stderr=subprocess.DEVNULL
    ).strip()


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "unknown"
