"""What can be baked, and what Blender calls its parts."""

# Items of an EnumProperty: Cycles' kinds, but for what refracts.
KINDS = [
    ("COMBINED", "Combined", "All light and emission of the surface"),
    ("AO", "Ambient Occlusion", "How much of an even sky is seen, as far as the world says"),
    ("SHADOW", "Shadow", "The share of the light that nothing blocks"),
    ("POSITION", "Position", "Places in world space"),
    ("NORMAL", "Normal", "Shading normals"),
    ("UV", "UV", "Places on the active UV map"),
    ("ROUGHNESS", "Roughness", "The mean roughness of the surface"),
    ("EMIT", "Emit", "Emission alone"),
    ("ENVIRONMENT", "Environment", "The world, seen from the origin towards the surface"),
    ("DIFFUSE", "Diffuse", "The diffuse part of the surface"),
    ("GLOSSY", "Glossy", "The glossy part of the surface"),
]

# Blender's bits of a bake's parts.
PARTS = {"EMIT": 2, "DIFFUSE": 4, "GLOSSY": 8, "DIRECT": 64, "COLOR": 256}


def is_baked(kind: str) -> bool:
    """Whether IWIS bakes a kind of Blender's."""
    return any(kind == own for own, _, _ in KINDS)


def parts_of(bits: int) -> frozenset[str]:
    """Names in PARTS of Blender's bits; -1 has all of them."""
    return frozenset(name for name, bit in PARTS.items() if bits & bit)
