"""The render passes: one table, read by the compositor's sockets, the render result and the panels.

The names are Cycles' own, so that a compositor tree does not care which of the two rendered.
Blender 5.0 gave most of them new ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from ..core.data.asked_passes import channels_of
from ..core.denoising.denoise import DATA_LAYERS, NOISY
from ..core.film import LAYERS

NAMES_OF_5 = bpy.app.version >= (5, 0, 0)


@dataclass(frozen=True, slots=True)
class Pass:
    """One row of TABLE.

    layer: name in core.film.LAYERS; mattes and what the denoiser knows have others
    name: what Blender, its compositor and its EXR files call it
    channel_ids: one letter a channel; kind: COLOR, VECTOR or VALUE, the socket's type
    flag: property of the view layer that asks for it, or of `view_layer.iwis`; "" = always there
    group: DATA, LIGHT, IWIS or CRYPTOMATTE, the panel that shows the flag; AOV,
        LIGHT_GROUPS
    first: the channel of the layer that it begins with
    """

    layer: str
    name: str
    channel_ids: str
    kind: str
    flag: str
    group: str
    first: int = 0

    @property
    def owned(self) -> bool:
        """Whether the flag is the add-on's own property, not Blender's."""
        return self.flag in OWN_FLAGS

    def wanted(self, view_layer) -> bool:
        """Whether the view layer asks for this pass."""
        if not self.flag:
            return True
        return getattr(view_layer.iwis if self.owned else view_layer, self.flag)

    def pixels(self, layers: dict) -> np.ndarray:
        """Its channels of a tile's or film's layers, float32 (h, w, channels)."""
        return layers[self.layer][..., self.first : self.first + len(self.channel_ids)]


def _row(layer, name, channel_ids, kind, flag, group, name_in_4=None):
    channels = (LAYERS | DATA_LAYERS)[layer]
    if len(channel_ids) != channels:
        raise ValueError(f"pass {name}: {channel_ids} are not {channels} channels")
    return Pass(layer, name if NAMES_OF_5 else name_in_4 or name, channel_ids, kind, flag, group)


OWN_FLAGS = (
    "use_pass_samples",
    "use_pass_error",
    "use_pass_unoccluded",
    "use_pass_visibility",
    "use_pass_shadow_catcher",
    "use_pass_sample_count",
    "use_pass_denoising_data",
)

# fmt: off
TABLE = (
    _row("combined", "Combined", "RGBA", "COLOR", "", "DATA"),
    _row("depth", "Depth", "Z", "VALUE", "use_pass_z", "DATA"),
    _row("mist", "Mist", "Z", "VALUE", "use_pass_mist", "DATA"),
    _row("position", "Position", "XYZ", "VECTOR", "use_pass_position", "DATA"),
    _row("normal", "Normal", "XYZ", "VECTOR", "use_pass_normal", "DATA"),
    _row("vector", "Vector", "XYZW", "VECTOR", "use_pass_vector", "DATA"),
    _row("uv", "UV", "UVA", "VECTOR", "use_pass_uv", "DATA"),
    _row("object_index", "Object Index", "X", "VALUE", "use_pass_object_index", "DATA", "IndexOB"),
    _row("material_index", "Material Index", "X", "VALUE", "use_pass_material_index", "DATA",
         "IndexMA"),
    _row("diffuse_direct", "Diffuse Direct", "RGB", "COLOR", "use_pass_diffuse_direct", "LIGHT",
         "DiffDir"),
    _row("diffuse_color", "Diffuse Color", "RGB", "COLOR", "use_pass_diffuse_color", "LIGHT",
         "DiffCol"),
    _row("glossy_direct", "Glossy Direct", "RGB", "COLOR", "use_pass_glossy_direct", "LIGHT",
         "GlossDir"),
    _row("glossy_color", "Glossy Color", "RGB", "COLOR", "use_pass_glossy_color", "LIGHT",
         "GlossCol"),
    _row("emission", "Emission", "RGB", "COLOR", "use_pass_emit", "LIGHT", "Emit"),
    _row("environment", "Environment", "RGB", "COLOR", "use_pass_environment", "LIGHT", "Env"),
    _row("ambient_occlusion", "Ambient Occlusion", "RGB", "COLOR", "use_pass_ambient_occlusion",
         "LIGHT", "AO"),
    _row("samples", "IWIS Samples", "X", "VALUE", "use_pass_samples", "IWIS"),
    _row("error", "IWIS Error", "X", "VALUE", "use_pass_error", "IWIS"),
    _row("unoccluded", "IWIS Unoccluded", "RGB", "COLOR", "use_pass_unoccluded", "IWIS"),
    _row("visibility", "IWIS Visibility", "X", "VALUE", "use_pass_visibility", "IWIS"),
    _row("shadow_catcher", "Shadow Catcher", "RGB", "COLOR", "use_pass_shadow_catcher", "IWIS"),
    _row("sample_count", "Debug Sample Count", "X", "VALUE", "use_pass_sample_count", "IWIS"),
)
# fmt: on
_DATA = "use_pass_denoising_data", "DATA"
DENOISING_DATA = (
    _row("denoising_normal", "Denoising Normal", "XYZ", "VECTOR", *_DATA),
    _row("denoising_albedo", "Denoising Albedo", "RGB", "COLOR", *_DATA),
    _row("denoising_depth", "Denoising Depth", "Z", "VALUE", *_DATA),
)
# There where the picture is denoised, as in Cycles.
NOISY_IMAGE = Pass(NOISY, "Noisy Image", "RGBA", "COLOR", "", "DATA")

# Kinds of Cryptomatte, each as many passes as the view layer's levels ask for -> their flags.
MATTES = {
    "Object": "use_pass_cryptomatte_object",
    "Material": "use_pass_cryptomatte_material",
    "Asset": "use_pass_cryptomatte_asset",
}

_GROUP, _AOV = "light_group:", "aov:"  # what layers of light groups and AOVs begin with


def wanted_passes(scene, view_layer) -> list[Pass]:
    """The passes of a view layer: what it asks for, its mattes, AOVs and light groups, and what
    denoising adds."""
    rows = [row for row in (*TABLE, *DENOISING_DATA) if row.wanted(view_layer)]
    if is_denoised(scene, view_layer):
        rows.append(NOISY_IMAGE)
    for kind in wanted_mattes(view_layer):
        rows += matte_passes(kind, channels_of(view_layer.pass_cryptomatte_depth))
    rows += [aov_pass(aov.name, 4 if aov.type == "COLOR" else 1) for aov in wanted_aovs(view_layer)]
    return rows + [group_pass(group.name) for group in view_layer.lightgroups]


def is_denoised(scene, view_layer) -> bool:
    """Whether a final render of the view layer is to be denoised."""
    return scene.iwis.denoise and view_layer.iwis.use_denoising


def wanted_mattes(view_layer) -> list[str]:
    """The kinds of MATTES that the view layer asks for."""
    return [kind for kind, flag in MATTES.items() if getattr(view_layer, flag)]


def matte_layer(kind: str) -> str:
    """The layer of a kind of MATTES."""
    return f"crypto_{kind.lower()}"


def matte_passes(kind: str, channels: int) -> list[Pass]:
    """A kind of MATTES that has so many channels, four a pass."""
    own = "rgba", "COLOR", MATTES[kind], "CRYPTOMATTE"
    return [
        Pass(matte_layer(kind), f"Crypto{kind}{k // 4:02d}", *own, first=k)
        for k in range(0, channels, 4)
    ]


def group_layer(name: str) -> str:
    """The layer of a light group."""
    return f"{_GROUP}{name}"


def group_pass(name: str) -> Pass:
    """What the lights of a group bring to the picture."""
    return Pass(group_layer(name), f"Combined_{name}", "RGB", "COLOR", "", "LIGHT_GROUPS")


def wanted_aovs(view_layer) -> list:
    """The AOVs of a view layer that have a pass: those whose names clash with others have none."""
    return [aov for aov in view_layer.aovs if aov.is_valid and aov.name]


def aov_layer(name: str) -> str:
    """The layer of an AOV."""
    return f"{_AOV}{name}"


def aov_pass(name: str, channels: int) -> Pass:
    """What nodes of materials write: a colour with its share of the pixel, or a number."""
    ids, kind = ("RGBA", "COLOR") if channels == 4 else ("X", "VALUE")
    return Pass(aov_layer(name), name, ids, kind, "", "AOV")


def passes_of(layers: dict) -> list[Pass]:
    """All that a film's layers have: of TABLE, of denoising, mattes, AOVs and light groups."""
    rows = [row for row in (*DENOISING_DATA, NOISY_IMAGE) if row.layer in layers]
    for kind in MATTES:
        if matte_layer(kind) in layers:
            rows += matte_passes(kind, layers[matte_layer(kind)].shape[2])
    names = [layer.removeprefix(_GROUP) for layer in layers if layer.startswith(_GROUP)]
    aovs = [
        aov_pass(layer.removeprefix(_AOV), pixels.shape[2])
        for layer, pixels in layers.items()
        if layer.startswith(_AOV)
    ]
    return [*TABLE, *rows, *aovs, *map(group_pass, names)]


def register_passes(engine, scene, view_layer) -> None:
    """Tell Blender which sockets the view layer's Render Layers node has."""
    for row in wanted_passes(scene, view_layer):
        engine.register_pass(
            scene, view_layer, row.name, len(row.channel_ids), row.channel_ids, row.kind
        )


def add_passes(engine, scene, view_layer) -> list[Pass]:
    """Add the wanted passes to the render result; Combined is there already. Return all of them."""
    rows = wanted_passes(scene, view_layer)
    for row in rows:
        if row.layer != "combined":
            engine.add_pass(row.name, len(row.channel_ids), row.channel_ids, layer=view_layer.name)
    return rows
