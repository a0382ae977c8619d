"""Hair of particle systems: strands, in the space of the object that they grow on.

Blender tells of a key of a strand by one call for each (0.8 us); its parts are as Cycles takes
them.
"""

from __future__ import annotations

from itertools import chain

import numpy as np

from .strand_tubes import Strands


def hair_modifiers(obj, in_window: bool) -> list:
    """The modifiers of an evaluated object whose strands are to be seen."""
    return [
        modifier
        for modifier in obj.modifiers
        if modifier.type == "PARTICLE_SYSTEM"
        and (modifier.show_viewport if in_window else modifier.show_render)
        and modifier.particle_system.settings.type == "HAIR"
        and modifier.particle_system.settings.render_type == "PATH"
    ]


class ParticleHair:
    """The strands of one modifier. in_window: as many, and as fine, as a window shows them"""

    def __init__(self, obj, modifier, in_window: bool):
        self._obj, self._modifier = obj, modifier
        self.system, self.settings = modifier.particle_system, modifier.particle_system.settings
        parents, children = len(self.system.particles), len(self.system.child_particles)
        if in_window:
            children = children * self.settings.display_percentage // 100
        with_parents = self.settings.child_type == "NONE" or children == 0
        self._numbers = range(0 if with_parents else parents, parents + children)
        steps = self.settings.display_step if in_window else self.settings.render_step
        self._n_keys = (1 << steps) + 1
        if self.settings.kink == "SPIRAL":
            self._n_keys += self.settings.kink_extra_steps
        self._strands = None

    def key(self) -> tuple:
        """What decides the strands beside the geometry that Blender says has changed."""
        s = self.settings
        size = s.radius_scale, s.root_radius, s.tip_radius, s.shape, s.use_close_tip
        return self.system.name, len(self._numbers), self._n_keys, *size

    def take(self, strands: Strands) -> None:
        """Use strands that read() gave before: nothing that decides them has changed."""
        self._strands = strands

    def read(self) -> Strands:
        n, k = len(self._numbers), self._n_keys
        of_key, obj = self.system.co_hair, self._obj
        places = (
            of_key(object=obj, particle_no=number, step=step)
            for number in self._numbers
            for step in range(k)
        )
        flat = np.fromiter(chain.from_iterable(places), np.float64, 3 * n * k)
        matrix = np.linalg.pinv(np.array(obj.matrix_world, np.float64))
        places = flat.reshape(n, k, 3) @ matrix[:3, :3].T + matrix[:3, 3]
        keys = np.empty((n, k, 4), np.float32)
        keys[..., :3] = places
        keys[..., 3] = self._radii(places)
        first = np.arange(0, n * k + 1, k, dtype=np.int64)
        self._strands = Strands(keys.reshape(-1, 4), first)
        return self._strands

    def _radii(self, places):
        """(n, k): from root to tip, by how far along a key is."""
        s = self.settings
        along = np.zeros(places.shape[:2])
        along[:, 1:] = np.cumsum(np.linalg.norm(np.diff(places, axis=1), axis=2), axis=1)
        total = along[:, -1:]
        part = 1.0 - np.divide(along, total, out=np.zeros_like(along), where=total > 0.0)
        part = np.clip(part, 0.0, 1.0)
        if s.shape < 0.0:
            part = part ** (1.0 + s.shape)
        elif s.shape > 0.0:
            part = part ** (1.0 / max(1.0 - s.shape, 1e-6))
        root, tip = (0.5 * s.radius_scale * end for end in (s.root_radius, s.tip_radius))
        radii = part * (root - tip) + tip
        if s.use_close_tip:
            radii[:, -1] = 0.0
        return radii

    def values(self, name: str):
        """As StrandSource's own: of the roots."""
        kind, _, rest = name.partition(":")
        mesh = self._obj.data
        if kind == "generated":
            size, middle = np.array(mesh.texspace_size), np.array(mesh.texspace_location)
            size = np.where(size != 0.0, size, 1.0)
            roots = self._strands.keys[self._strands.first[:-1], :3]
            return ((roots - middle) / (2.0 * size) + 0.5).astype(np.float32), False
        if kind == "uv":
            names = [layer.name for layer in mesh.uv_layers]
            active = next((x.name for x in mesh.uv_layers if x.active_render), None)
            return self._on_emitter("uv_on_emitter", "uv_no", names, rest or active)
        if kind in ("color", "attribute") and rest:
            names = [layer.name for layer in mesh.vertex_colors]
            return self._on_emitter("mcol_on_emitter", "vcol_no", names, rest)
        return None

    def _on_emitter(self, function, argument, names, name):
        if name not in names:
            return None
        particles = self.system.particles
        ask, last = getattr(self.system, function), len(particles) - 1
        found = []
        for number in self._numbers:
            particle = particles[min(number, last)]
            where = {"particle_no": number, argument: names.index(name)}
            found.append(tuple(ask(self._modifier, particle=particle, **where)))
        return np.array(found, np.float32), False
