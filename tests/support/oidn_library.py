"""Where the bpy module of this environment keeps Open Image Denoise, without importing it."""

import importlib.util
from pathlib import Path

import pytest


def library() -> str:
    """Its path; the test is left out where there is no bpy module."""
    spec = importlib.util.find_spec("bpy")
    if spec is None:
        pytest.skip("there is no bpy module")
    (path,) = (Path(spec.origin).parent / "lib").glob("libOpenImageDenoise.*")
    return str(path)
