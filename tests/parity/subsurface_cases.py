"""Light from under the surface, by each method."""

import functools

import bpy

from . import cases
from .closure_cases import BLUE, RED, _bent, _clear, _glossy, _mix
from .lit_cases import image_of, noise_of

lit = functools.partial(cases.lit, blurred=True)
NEW = bpy.app.version >= (5, 2)
METHODS = ["RANDOM_WALK", "RANDOM_WALK_SKIN"] + ["RANDOM_WALK_LEGACY"] * NEW
# In the measure of each method, for spheres of 1 m.
SCALES = {"RANDOM_WALK": 0.1 if NEW else 1.0, "RANDOM_WALK_SKIN": 0.4}
SCALES |= {"RANDOM_WALK_LEGACY": 1.0, "BURLEY": 1.0}
# Alike in all channels: where these differ walks leave noise that no small picture can do without.
COLOR, RADIUS = (0.7, 0.7, 0.7), (1.0, 1.0, 1.0)


def _principled(tree, method="RANDOM_WALK", **inputs):
    given = {"Subsurface Weight": 1.0, "Subsurface Scale": SCALES[method]}
    given |= {"Base Color": COLOR, "Subsurface Radius": RADIUS}
    named = {name.replace("_", " "): value for name, value in inputs.items()}
    node = {"subsurface_method": method}
    return tree.made("ShaderNodeBsdfPrincipled", 0, given | named, **node)


def _scattering(tree, method="RANDOM_WALK", **inputs):
    given = {"Scale": SCALES[method], "Radius": RADIUS, "Color": COLOR, **inputs}
    return tree.made("ShaderNodeSubsurfaceScattering", 0, given, falloff=method)


def _case(name, make, **options):
    lit(f"Subsurface: {name}", make, **options)


for _name in METHODS:
    _case(
        f"Principled, {_name.replace('_', ' ').title()}",
        lambda t, method=_name: _principled(t, method, Subsurface_Anisotropy=0.3),
    )
    _case(
        f"scattering node, {_name.replace('_', ' ').title()}",
        lambda t, method=_name: _scattering(t, method),
    )
_case("colors", lambda t: _scattering(t, Color=(0.8, 0.5, 0.3), Radius=(1.0, 0.2, 0.1)))
_case("half of it, metallic", lambda t: _principled(t, Subsurface_Weight=0.5, Metallic=0.4))
_case("share varies", lambda t: _principled(t, Subsurface_Weight=noise_of(t)))
_case("color by an image", lambda t: _principled(t, Base_Color=image_of(t), Roughness=0.3))
_case("bump", lambda t: _principled(t, Normal=_bent(t)))
_case("bump, scattering node", lambda t: _scattering(t, Normal=_bent(t)))
_case("a channel that goes nowhere", lambda t: _principled(t, Subsurface_Radius=(1.0, 0.3, 0.0)))
_case("rough, high index", lambda t: _scattering(t, IOR=2.5, Roughness=0.2))
_case("scatters forward", lambda t: _scattering(t, Anisotropy=0.8))
_case("black and white", lambda t: _scattering(t, Color=(1.0, 0.02, 0.0)))
_case("under a coat", lambda t: _principled(t, Coat_Weight=0.7, Coat_Roughness=0.2))
_case("mixed with gloss", lambda t: _mix(t, 0.4, _scattering(t), _glossy(t)))
_case("mixed with another", lambda t: _mix(t, 0.4, _scattering(t), _scattering(t, Color=BLUE)))
_case("mixed with clear", lambda t: _mix(t, 0.4, _scattering(t, Color=RED), _clear(t)))
_case(
    "Christensen-Burley",
    lambda t: _principled(t, "BURLEY"),
    warns="Christensen-Burley is not supported",
)
