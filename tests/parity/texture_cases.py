"""Procedural textures."""

from .cases import shown
from .scene import find_socket


def _texture(kind, output, **settings):
    """A procedural texture at object coordinates; settings: properties, and inputs by name."""

    def make(tree):
        node = tree.node(kind)
        tree.link(tree.coordinates(), node.inputs["Vector"])
        for name, value in settings.items():
            if hasattr(node, name):
                setattr(node, name, value)
        for name, value in settings.items():
            if not hasattr(node, name):
                tree.link(value, find(node, name))
        return tree.made("ShaderNodeVectorMath", 0, {0: node.outputs[output]}, operation="ABSOLUTE")

    def find(node, name):
        return next(s for s in node.inputs if s.name == name and s.enabled)

    return make


for _dimensions in ("1D", "2D", "3D", "4D"):
    for _output in (0, 1):
        shown(
            f"Noise {_dimensions} {'Color' if _output else 'Fac'}",
            _texture(
                "ShaderNodeTexNoise",
                _output,
                noise_dimensions=_dimensions,
                Scale=2.3,
                Detail=3.5,
                **({"W": 0.7} if _dimensions in ("1D", "4D") else {}),
            ),
        )
for _type, _orientation in (("2D", 0.4), ("3D", (0.5, -0.7, 0.3))):
    for _output in ("Value", "Phase", "Intensity"):
        for _anisotropy in (1.0, 0.4):
            _settings = {"Scale": 2.3, "Frequency": 1.7, "Anisotropy": _anisotropy}
            shown(
                f"Gabor {_type}, {_output}, anisotropy {_anisotropy:g}",
                _texture(
                    "ShaderNodeTexGabor",
                    _output,
                    gabor_type=_type,
                    Orientation=_orientation,
                    **_settings,
                ),
            )
for _kind in ("MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HYBRID_MULTIFRACTAL", "HETERO_TERRAIN"):
    shown(
        f"Noise {_kind}", _texture("ShaderNodeTexNoise", 0, noise_type=_kind, Scale=2.0, Detail=2.5)
    )
shown("Noise distorted", _texture("ShaderNodeTexNoise", 1, Scale=2.0, Distortion=1.3))
shown(
    "Noise, not normalized",
    _texture("ShaderNodeTexNoise", 0, normalize=False, Scale=2.0, Roughness=0.8),
)
for _dimensions in ("1D", "2D", "3D", "4D"):
    for _feature in ("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS"):
        shown(
            f"Voronoi {_dimensions} {_feature}",
            _texture(
                "ShaderNodeTexVoronoi",
                "Radius" if _feature == "N_SPHERE_RADIUS" else "Distance",
                voronoi_dimensions=_dimensions,
                feature=_feature,
                Scale=2.0,
                **({"W": 0.4} if _dimensions in ("1D", "4D") else {}),
            ),
        )
    for _output in ("Color", "Position" if _dimensions != "1D" else "W"):
        shown(
            f"Voronoi {_dimensions} {_output}",
            _texture("ShaderNodeTexVoronoi", _output, voronoi_dimensions=_dimensions, Scale=2.0),
        )
for _metric in ("MANHATTAN", "CHEBYCHEV", "MINKOWSKI"):
    shown(
        f"Voronoi {_metric}",
        _texture("ShaderNodeTexVoronoi", "Distance", distance=_metric, Scale=2.0),
    )
shown(
    "Voronoi fractal",
    _texture("ShaderNodeTexVoronoi", "Distance", Scale=1.5, Detail=2.5, normalize=True),
)
shown(
    "Voronoi fractal edges",
    _texture("ShaderNodeTexVoronoi", "Distance", feature="DISTANCE_TO_EDGE", Scale=1.5, Detail=1.5),
)
shown("Checker", _texture("ShaderNodeTexChecker", 0, Scale=2.6))
for _kind in (
    "LINEAR",
    "QUADRATIC",
    "EASING",
    "DIAGONAL",
    "RADIAL",
    "QUADRATIC_SPHERE",
    "SPHERICAL",
):
    shown(f"Gradient {_kind}", _texture("ShaderNodeTexGradient", 0, gradient_type=_kind))
for _kind, _direction in (
    ("BANDS", "X"),
    ("BANDS", "DIAGONAL"),
    ("RINGS", "Z"),
    ("RINGS", "SPHERICAL"),
):
    for _profile in ("SIN", "SAW", "TRI"):
        shown(
            f"Wave {_kind} {_direction} {_profile}",
            _texture(
                "ShaderNodeTexWave",
                0,
                wave_type=_kind,
                wave_profile=_profile,
                Scale=0.4,
                **{f"{_kind.lower()}_direction": _direction},
            ),
        )
shown("Wave distorted", _texture("ShaderNodeTexWave", 0, Scale=0.4, Distortion=3.0, Detail=2.0))
for _depth in (0, 2, 5, 10):
    shown(
        f"Magic {_depth}",
        _texture("ShaderNodeTexMagic", 0, turbulence_depth=_depth, Scale=0.7, Distortion=1.2),
    )
shown(
    "Magic, far from the origin",
    lambda t: t.made("ShaderNodeTexMagic", 0, {"Vector": t.coordinates("Camera"), "Scale": 1.367}),
)
shown("Brick", _texture("ShaderNodeTexBrick", 0, Scale=1.5))
shown(
    "Brick squashed",
    _texture("ShaderNodeTexBrick", 0, Scale=1.5, squash=0.6, squash_frequency=3, offset=0.3),
)
for _dimensions in ("1D", "2D", "3D", "4D"):

    def _white(tree, dimensions=_dimensions):
        cells = tree.made(
            "ShaderNodeVectorMath", 0, {0: tree.coordinates(), 1: (0.5, 0.5, 0.5)}, operation="SNAP"
        )
        node = tree.node("ShaderNodeTexWhiteNoise", noise_dimensions=dimensions)
        if dimensions == "1D":
            cells = tree.made("ShaderNodeSeparateXYZ", 0, {0: cells})
        tree.link(cells, find_socket(node.inputs, "W" if dimensions == "1D" else "Vector"))
        return node.outputs["Color"]

    shown(f"White Noise {_dimensions}", _white)
