"""Whether two exports, or two parts of one, are equal."""

from __future__ import annotations

import dataclasses

import numpy as np


def same(a, b) -> bool:
    """Whether two exports are equal, however deep their arrays lie; identity is seen at once."""
    if a is b:
        return True
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.shape == b.shape and a.dtype == b.dtype and np.array_equal(a, b)
    if isinstance(a, (list, tuple)):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if dataclasses.is_dataclass(a):
        names = (field.name for field in dataclasses.fields(a))
        return all(same(getattr(a, name), getattr(b, name)) for name in names)
    return bool(a == b)
