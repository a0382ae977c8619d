"""What a picture's file says of its Cryptomatte passes: whose names the ids stand for.

By the specification of Cryptomatte 1.2.0 [Friedman15], in Blender's result, which writes it into
OpenEXR's header.
"""

from __future__ import annotations

import json

from ..core.data.asked_passes import Matte, name_hash
from .passes import MATTES, matte_layer


def stamp_mattes(result, view_layer: str, mattes: tuple[Matte, ...]) -> None:
    """Add the names of a view layer's mattes to a RenderResult."""
    kinds = {matte_layer(kind): f"{view_layer}.Crypto{kind}" for kind in MATTES}
    for matte in mattes:
        name = kinds[matte.layer]
        key = f"cryptomatte/{name_hash(name):08x}"[: len("cryptomatte/") + 7]
        hashes = {name: f"{name_hash(name):08x}" for name in matte.names}
        fields = {
            "name": name,
            "hash": "MurmurHash3_32",
            "conversion": "uint32_to_float32",
            "manifest": json.dumps(hashes, ensure_ascii=False, separators=(",", ":")),
        }
        for field, value in fields.items():
            result.stamp_data_add_field(field=f"{key}/{field}", value=value)
