"""What made an instance: its place on the instancer, and the particle that it stands for.

Particles as Cycles finds them: by the innermost number of the instance; children have none. Where
there is none all is 0.
"""

from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np

from .object_properties import asks_instancers, outermost_index

ORIGIN = "origin"  # the kind of a table of objects, as those of object_properties.TABLES
PARTICLE = "ShaderNodeParticleInfo"
_NOTHING = np.zeros(4, np.float32)


class Origin(NamedTuple):
    """index: of outermost_index, -1 where no material asks
    values: name -> number, or numbers, where a material asks; else nothing"""

    index: int
    values: dict[str, object]

    def value(self, name: str) -> np.ndarray:
        """float32 (4,): a number three times, a vector filled up by 0."""
        found = np.atleast_1d(np.float32(self.values.get(name, 0.0)))
        if len(found) == 1:
            found = np.repeat(found, 3)
        return np.concatenate([found, _NOTHING])[:4]


class Origins:
    """Reads them of depsgraph.object_instances, as far as materials of the file ask."""

    def __init__(self, scene):
        self._frame = scene.frame_current_final
        self._by_index, (self._by_place, self._by_particle) = asks_instancers(), _asked()

    def of(self, item) -> Origin:
        """That of an item, while it is alive."""
        values = {}
        if item.is_instance and self._by_place:
            generated = 0.5 * np.array(item.orco) - 0.5
            values |= {"Generated": generated, "UV": (*item.uv, 0.0)}
        if item.is_instance and self._by_particle:
            values |= self._particle(item)
        return Origin(outermost_index(item) if self._by_index else -1, values)

    def _particle(self, item) -> dict:
        system, index = item.particle_system, item.persistent_id[0]
        if system is None or not 0 <= index < len(system.particles):
            return {}
        particle = system.particles[index]
        return {
            "Index": index,
            "Age": self._frame - particle.birth_time,
            "Lifetime": particle.lifetime,
            "Location": tuple(particle.location),
            "Size": particle.size,
            "Velocity": tuple(particle.velocity),
            "Angular Velocity": tuple(particle.angular_velocity),
        }


def _asked() -> tuple[bool, bool]:
    """Whether a material asks for an instance's place on its instancer; for its particle."""
    trees = [material.node_tree for material in bpy.data.materials if material.node_tree]
    trees += [tree for tree in bpy.data.node_groups if tree.type == "SHADER"]
    nodes = [node for tree in trees for node in tree.nodes]
    by_place = any(getattr(node, "from_instancer", False) for node in nodes)
    return by_place, any(node.bl_idname == PARTICLE for node in nodes)
