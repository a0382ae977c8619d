"""Metals by their indices of refraction: the Metallic BSDF's physical conductor."""

from .closure_cases import lit

# Indices of metals for red, green and blue: of iron (the node's own), gold, chromium.
_METALS = {
    "iron": None,
    "gold": ((0.14, 0.37, 1.44), (3.97, 2.5, 1.9)),
    "a brittle one": ((2.3, 2.66, 2.44), (2.93, 3.07, 1.15)),
    "chromium": ((3.2, 3.1, 2.3), (3.3, 3.3, 3.1)),
}


def _conductor(metal, roughness):
    def make(tree):
        inputs = {"Roughness": roughness}
        if _METALS[metal] is not None:
            inputs["IOR"], inputs["Extinction"] = _METALS[metal]
        options = {"fresnel_type": "PHYSICAL_CONDUCTOR"}
        return tree.made("ShaderNodeBsdfMetallic", 0, inputs, **options)

    return make


for _metal in _METALS:
    for _roughness in (0.15, 0.5):
        lit(
            f"Metallic BSDF, {_metal} by its indices, roughness {_roughness}",
            _conductor(_metal, _roughness),
        )


def _varying_metal(tree):
    """From gold to chromium."""
    names = ("IOR", "Extinction")
    inputs = {"Roughness": 0.3}
    for number, name in enumerate(names):
        ends = {"A": _METALS["gold"][number], "B": _METALS["chromium"][number]}
        mixed = {"Factor": tree.axis("X")} | ends
        inputs[name] = tree.made("ShaderNodeMix", "Result", mixed, data_type="VECTOR")
    options = {"fresnel_type": "PHYSICAL_CONDUCTOR"}
    return tree.made("ShaderNodeBsdfMetallic", 0, inputs, **options)


lit("Metallic BSDF, indices vary", _varying_metal)
