"""Shaders that let light through: transparent, translucent, and glass.

Glass is seen through without refraction, and lets shadow rays through: with direct light alone
Cycles shows black where a refracted ray ends in the body, and behind it.
"""

from __future__ import annotations

import numpy as np

from ....core.scene import PRINCIPLED, TRANSLUCENT
from .surface_parts import BLACK, DISTRIBUTIONS, ONE, WHITE, ZERO, SurfaceBuilder, is_constant

_STRAIGHT = "light goes straight through, without refraction"


class ClearShaders(SurfaceBuilder):
    """What a ShaderReader knows of them."""

    def _translucent(self, node, groups, weight):
        color = self._builder.color(node, "Color", groups)
        self._close(node, groups, weight, TRANSLUCENT, base_color=color, diffuse_roughness=ZERO)

    def _transparent(self, node, groups, weight):
        color = self._builder.color(node, "Color", groups)
        if not is_constant(color) or np.ptp(color) > 0.0:
            self.parts.tinted.append(node)
        self._passes(node, groups, weight)

    def _passes(self, node, groups, weight):
        """Add what goes straight through: the node's color."""
        color = self._builder.color(node, "Color", groups)
        self.parts.transparent.append(self._times(weight, color))

    def _alpha(self, node, groups, weight):
        """What Principled's alpha leaves of a weight; the rest passes through."""
        alpha = self._builder.number(node, "Alpha", groups)
        if is_constant(alpha) and alpha >= 1.0:
            return weight
        passing, kept = self._shares(weight, alpha)
        self.parts.transparent.append(passing)
        return kept

    def _glass(self, node, groups, weight):
        self._warn(node, f"{node.bl_label}: {_STRAIGHT}")
        weight = self._times(weight, self._builder.color(node, "Color", groups))
        number = self._builder.number
        own = {"ior": number(node, "IOR", groups), "roughness": number(node, "Roughness", groups)}
        own["specular_tint"] = WHITE
        film = self._film(node, groups)
        self._pane(node, groups, weight, WHITE, DISTRIBUTIONS[node.distribution], film, **own)

    def _refraction(self, node, groups, weight):
        self._warn(node, f"{node.bl_label}: {_STRAIGHT}")
        self._passes(node, groups, weight)

    def _transmission(self, node, groups, weight, params, grain, film):
        """Add what of Principled is glass; what is left of a weight for the rest.

        grain: of its metal; glass reflects as if it were round
        """
        share = self._builder.number(node, "Transmission Weight", groups)
        metallic = params["metallic"]
        if (is_constant(share) and share <= 0.0) or (is_constant(metallic) and metallic >= 1.0):
            return weight
        self._warn(node, f"Transmission Weight: {_STRAIGHT}")
        rest, clear = self._shares(weight, share)
        distribution = DISTRIBUTIONS[node.distribution]
        if not (is_constant(metallic) and metallic <= 0.0):
            clear, metal = self._shares(clear, metallic)
            own = params | {"metallic": ONE}
            self._close(node, groups, metal, PRINCIPLED, distribution, grain, film, **own)
        # Of the base color a ray takes the root at each of the two surfaces that it goes through.
        gamma = {"Color": params["base_color"], "Gamma": np.float32(0.5)}
        tint = self._builder.run("ShaderNodeGamma", "Color", **gamma)
        own = {name: params[name] for name in ("roughness", "ior", "specular_tint")}
        self._pane(node, groups, clear, tint, distribution, film, **own)
        return rest

    def _pane(self, node, groups, weight, tint, distribution, film, **params):
        """Add a surface of glass: its reflection, and the rest, which goes straight through."""
        inputs, settings = {"Weight": weight, "Tint": tint}, {}
        if film is not None:
            inputs |= {"Thickness": film.thickness, "Film IOR": film.ior}
            settings["space"] = film.space
        inputs |= {"IOR": params["ior"], "Roughness": params["roughness"]}
        normal = self._builder.normal(node, "Normal", groups)
        if normal is not None:
            inputs["Normal"] = normal
        through, reflected = self._builder.run_at_points(
            "through_glass", "", "reflected", settings=settings, **inputs
        )
        self.parts.transparent.append(through)
        params |= {"base_color": BLACK, "metallic": ZERO, "specular_level": np.float32(0.5)}
        self._close(node, groups, reflected, PRINCIPLED, distribution, film=film, **params)
