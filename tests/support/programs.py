"""Scenes of tests/support/scenes.py whose materials are programs."""

import dataclasses

import numpy as np

from iwis.core.data.program import Closure, Program, Shaders, SurfaceData
from iwis.core.scene import BLACK, GGX

TINT = np.float32([0.9, 0.5, 0.1])


def with_programs(scene, *programs):
    """The scene with one program, or None, for each of its materials; meshes have no tables."""
    n_objects = len(scene.object_pass_index)
    surface = SurfaceData(
        row=np.full(len(scene.mesh.triangles), -1, np.int32),
        object_to_world=np.tile(np.eye(4), (n_objects, 1, 1)),
        mirrored=np.zeros(n_objects, bool),
        color=np.ones((n_objects, 4), np.float32),
        random=np.zeros(n_objects, np.float32),
        pass_index=np.zeros(n_objects, np.float32),
    )
    shaders = Shaders(
        programs=programs,
        surface=surface,
        material_pass_index=np.zeros(len(programs), np.float32),
    )
    return dataclasses.replace(scene, shaders=shaders)


def pane(color=TINT) -> Program:
    """A lone Transparent BSDF."""
    nothing = Closure(BLACK, GGX, np.ones(3, np.float32), {})
    return Program(ops=(), closures=(nothing,), transparent=color)
