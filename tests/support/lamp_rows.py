"""Rows of lamps (core.lamps.make_lamps) for tests."""

import numpy as np

TILTED = np.array(
    [[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]]
)  # columns: right, up, -forward


def area(kind, position, width, height, frame=TILTED, **fields):
    """A row of an area lamp that shines along the third column of frame, turned round."""
    sides = {"right": frame[:, 0], "up": frame[:, 1], "forward": -frame[:, 2]}
    return {"kind": kind, "position": position, "size": (width, height), **sides} | fields
