"""A render's job at each slice of the shutter's time, where objects move or change their shape."""

from __future__ import annotations

import dataclasses

import numpy as np

from ..data.object_motion import Pose
from ..lamplight.posed_lamps import posed_lamps
from ..scene import Scene
from ..surfaces.near_rays import with_near_rays
from .tile_job import Job


def scene_at(scene: Scene, number: int) -> Scene:
    """A scene with motion as it is in one slice; all arrays are shared, but those of faces that
    shine and move."""
    motion = scene.motion
    row = np.full(len(scene.object_pass_index), -1, np.int32)
    row[motion.objects] = np.arange(len(motion.objects), dtype=np.int32)
    forward = motion.matrices[number]
    time = float(motion.times[number])
    pose = Pose(row, forward, np.linalg.inv(forward), time, motion.shapes)
    return dataclasses.replace(scene, pose=pose, lamps=posed_lamps(scene, pose))


def with_slices(job: Job) -> Job:
    """The job with one for each slice; without motion as it is."""
    if job.scene.motion is None:
        return job
    slices = []
    for number in range(len(job.scene.motion.times)):
        scene = scene_at(job.scene, number)
        accel = job.accel.at(number, scene)
        scene = with_near_rays(scene, job.settings, accel)
        slices.append(dataclasses.replace(job, scene=scene, accel=accel))
    return dataclasses.replace(job, slices=tuple(slices))
