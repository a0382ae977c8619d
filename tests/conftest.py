"""Holds for every test: this checkout is the one that is tested, random numbers have a seed."""

import sys
import zlib
from pathlib import Path

import numpy as np
import pytest

import iwis

ROOT = Path(__file__).resolve().parent.parent


def pytest_sessionstart():
    """Stop when the environment's editable install points at another checkout."""
    tested = Path(iwis.__file__).resolve().parent
    if tested != ROOT:
        pytest.exit(
            f"these tests are of {ROOT}, but Python imports iwis from {tested}: "
            f"run 'make test', or pip install -e {ROOT} in this environment",
            returncode=3,
        )


def pytest_sessionfinish():
    """Unregister: bpy 4.5 hangs or crashes at exit while a Python render engine is registered."""
    bpy = sys.modules.get("bpy")
    if bpy is None:
        return
    engines = [
        c for c in bpy.types.RenderEngine.__subclasses__() if getattr(c, "bl_idname", "") == "IWIS"
    ]
    if not any(engine.is_registered for engine in engines):
        return
    for scene in bpy.data.scenes:
        if scene.render.engine == "IWIS":
            scene.render.engine = "CYCLES"
    iwis.unregister()


@pytest.fixture
def rng(request) -> np.random.Generator:
    """Random numbers that are a test's own, the same in every run and whatever else runs."""
    return np.random.default_rng(zlib.crc32(request.node.nodeid.encode()))
