"""Random procedural textures, with all their settings."""

from __future__ import annotations

from .dice import Dice

_FACTOR = {"Gabor": ("Value", "Phase", "Intensity"), "Voronoi": ("Distance",), "WhiteNoise": (0,)}
_ALL = "Noise", "Wave", "Checker", "Gradient", "Brick", "Gabor", "Voronoi"
_COLORED = "Noise", "Checker", "Magic", "Brick", "Wave", "Voronoi", "Gradient"


def factor(dice: Dice, tree, place):
    """A number, of most textures from 0 to 1, at a place."""
    kind = dice.of(*_ALL)
    return _made(dice, tree, kind, place, dice.of(*_FACTOR.get(kind, ("Fac",))))


def colored(dice: Dice, tree, place):
    """A colour at a place."""
    kind = dice.of(*_COLORED)
    output = "Color"
    if kind == "Voronoi" and dice.glows and dice.chance(0.3):
        output = "Position"
    return _made(dice, tree, kind, place, output)


def _made(dice, tree, kind, place, output):
    if dice.glows:
        dice.tell(kind.lower())
    node = tree.node(f"ShaderNodeTex{kind}")
    inputs = {"Vector": place} | _SETTINGS[kind](dice, node)
    for name, value in inputs.items():
        socket = _enabled(node.inputs, name)
        if socket is not None:
            tree.link(value, socket)
    if isinstance(output, str) and _enabled(node.outputs, output) is None:
        output = next(i for i, s in enumerate(node.outputs) if s.enabled)
    return node.outputs[output] if isinstance(output, int) else _enabled(node.outputs, output)


def _enabled(sockets, name):
    named = [s for s in sockets if s.enabled and name in (s.identifier, s.name)]
    return named[0] if named else None


def _noise(dice, node):
    node.noise_dimensions = dice.of("1D", "2D", "3D", "3D", "4D")
    others = ("MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HYBRID_MULTIFRACTAL", "HETERO_TERRAIN")
    node.noise_type = dice.of(*others) if dice.glows else "FBM"
    node.normalize = not dice.glows or dice.chance(0.5)
    inputs = {"Detail": dice.between(0.0, 4.0), "Distortion": dice.edge(0.0, 1.0)}
    inputs |= {"Roughness": dice.edge(0.0, 1.0), "Lacunarity": dice.between(1.2, 3.0)}
    inputs |= {"Offset": dice.between(0.0, 1.0), "Gain": dice.between(0.5, 2.0)}
    return inputs | {"Scale": dice.spread(1.0, 6.0), "W": dice.between(-3.0, 3.0)}


def _wave(dice, node):
    node.wave_type, node.wave_profile = dice.of("BANDS", "RINGS"), dice.of("SIN", "SAW", "TRI")
    node.bands_direction = dice.of("X", "Y", "Z", "DIAGONAL")
    node.rings_direction = dice.of("X", "Y", "Z", "SPHERICAL")
    inputs = {"Distortion": dice.edge(0.0, 3.0), "Detail": dice.between(0.0, 3.0)}
    inputs |= {"Detail Scale": dice.between(0.5, 2.0), "Detail Roughness": dice.between(0.0, 1.0)}
    return inputs | {"Scale": dice.spread(1.0, 6.0), "Phase Offset": dice.between(-3.0, 3.0)}


def _checker(dice, node):
    return {"Scale": dice.spread(1.0, 6.0), "Color1": dice.color(), "Color2": dice.color()}


def _gradient(dice, node):
    kinds = "LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL", "QUADRATIC_SPHERE", "RADIAL"
    node.gradient_type = dice.of(*kinds)
    return {}


def _brick(dice, node):
    node.offset, node.offset_frequency = dice.between(0.0, 1.0), dice.whole(1, 3)
    node.squash, node.squash_frequency = dice.between(0.5, 1.5), dice.whole(1, 3)
    inputs = {"Color1": dice.color(), "Color2": dice.color(), "Mortar": dice.color()}
    inputs |= {"Mortar Size": dice.between(0.0, 0.1), "Mortar Smooth": dice.edge(0.0, 1.0)}
    inputs |= {"Bias": dice.edge(-1.0, 1.0), "Brick Width": dice.between(0.3, 0.8)}
    return inputs | {"Row Height": dice.between(0.1, 0.4), "Scale": dice.spread(1.0, 6.0)}


def _gabor(dice, node):
    node.gabor_type = dice.of("2D", "3D")
    inputs = {"Scale": dice.spread(1.0, 5.0), "Frequency": dice.between(0.5, 3.0)}
    inputs |= {"Anisotropy": dice.edge(0.0, 1.0), "Orientation 2D": dice.between(-3.0, 3.0)}
    return inputs | {"Orientation 3D": dice.vector(-1.0, 1.0)}


def _voronoi(dice, node):
    node.voronoi_dimensions = dice.of("1D", "2D", "3D", "3D", "4D")
    node.feature = dice.of("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS")
    node.distance = dice.of("EUCLIDEAN", "MANHATTAN", "CHEBYCHEV", "MINKOWSKI")
    node.normalize = dice.chance(0.5)
    inputs = {"Smoothness": dice.edge(0.0, 1.0), "Exponent": dice.between(0.5, 4.0)}
    inputs |= {"Randomness": dice.edge(0.0, 1.0), "Detail": dice.of(0.0, dice.between(0.0, 3.0))}
    inputs |= {"Roughness": dice.between(0.0, 1.0), "Lacunarity": dice.between(1.2, 3.0)}
    return inputs | {"Scale": dice.spread(1.0, 6.0), "W": dice.between(-3.0, 3.0)}


def _magic(dice, node):
    node.turbulence_depth = dice.whole(0, 5)
    return {"Scale": dice.spread(1.0, 6.0), "Distortion": dice.between(0.0, 2.0)}


_SETTINGS = {
    "Noise": _noise,
    "Wave": _wave,
    "Checker": _checker,
    "Gradient": _gradient,
    "Brick": _brick,
    "Gabor": _gabor,
    "Voronoi": _voronoi,
    "Magic": _magic,
}
