"""Light from under the surface: Principled's subsurface, and the Subsurface Scattering BSDF."""

from __future__ import annotations

import bpy

from ....core.data.program import Subsurface
from ....core.scene import DIFFUSE
from ....core.walks.subsurface import LEGACY, SKIN, VAN_DE_HULST
from .clear_shaders import ClearShaders
from .surface_parts import ONE, ZERO, is_constant

# Before Blender 5.2 Random Walk was what is Random Walk (Legacy) there.
_WALK = VAN_DE_HULST if bpy.app.version >= (5, 2) else LEGACY
_METHODS = {"RANDOM_WALK": _WALK, "RANDOM_WALK_LEGACY": LEGACY, "RANDOM_WALK_SKIN": SKIN}


class SubsurfaceShaders(ClearShaders):
    """What a ShaderReader knows of them."""

    def _scatter_under(self, node, groups):
        """Have the last closure, Principled's own, scatter as the node says."""
        share = self._builder.number(node, "Subsurface Weight", groups)
        if is_constant(share) and share <= 0.0:
            return
        skin = node.subsurface_method == "RANDOM_WALK_SKIN"
        names = {name: f"Subsurface {name}" for name in ("Radius", "Scale", "Anisotropy")}
        names["IOR"] = "Subsurface IOR" if skin else "IOR"
        self._under(node, groups, node.subsurface_method, share, names)

    def _subsurface(self, node, groups, weight):
        color = self._builder.color(node, "Color", groups)
        self._close(node, groups, weight, DIFFUSE, base_color=color, diffuse_roughness=ZERO)
        self._under(node, groups, node.falloff, ONE, {})

    def _under(self, node, groups, method, share, names):
        """names: of the inputs, where they are not the values' own"""

        def number(name):
            name = names.get(name, name)  # a method shows only inputs that it reads
            return self._builder.number(node, name, groups) if name in node.inputs else ONE

        if method not in _METHODS:
            self._warn(node, "Christensen-Burley is not supported: rendered as Random Walk")
        roughness = number("Roughness")
        if not names:  # the scattering node's is that of the facets, not its root
            settings = {"operation": "SQRT", "use_clamp": False}
            values = {"Value": roughness, "Value_001": ZERO, "Value_002": ZERO}
            roughness = self._builder.run("ShaderNodeMath", "Value", settings=settings, **values)
        radius = self._builder.vector(node, names.get("Radius", "Radius"), groups)
        own = Subsurface(
            share=share,
            radius=self._builder.scaled(radius, number("Scale")),
            anisotropy=number("Anisotropy") if "Anisotropy" in node.inputs or names else ZERO,
            ior=number("IOR"),
            roughness=roughness,
            method=_METHODS.get(method, LEGACY),
        )
        self.parts.closures[-1] = self.parts.closures[-1]._replace(subsurface=own)
