"""What a coat leaves over for what is under it, a pane of glass for what is behind; grain."""

from __future__ import annotations

import numpy as np

from ..data.rows import row_maxima
from ..scene import GGX, MULTI_GGX, PRINCIPLED, MaterialParams
from .values import as_number, as_vector, column, dot, normalized

_LEAST_IOR = np.float32(1.0)


def _albedo(context, distribution, ior, roughness, normal, wo=None, film=None) -> np.ndarray:
    """float32 (n,): of all light, what a clear layer reflects to the viewer, or to wo.

    film: (space, thickness, ior) of a ThinFilm on it
    """
    from ..bsdf.lobe_setup import setup_lobes  # kernels: the exporters load without numba

    n = len(context)
    white, black = np.ones((n, 3), np.float32), np.zeros((n, 3), np.float32)
    coat = MaterialParams(
        model=np.full(n, PRINCIPLED, np.int8),
        distribution=np.full(n, distribution, np.int8),
        base_color=black,
        metallic=np.zeros(n, np.float32),
        roughness=roughness,
        ior=ior,
        specular_level=np.full(n, 0.5, np.float32),
        specular_tint=white,
        emission=black,
        diffuse_roughness=np.zeros(n, np.float32),
    )
    wo = context.wo if wo is None else wo
    lobes = setup_lobes(coat, normal, context.geometric_normal, wo)
    if film is not None:
        from ..bsdf.thin_film_setup import FilmValues, set_film  # kernels too

        set_film(lobes, coat, np.arange(n), FilmValues(*film, None, None))
    return row_maxima(lobes.glossy_color)


def under_coat(context, settings, inputs):
    """Weight of what lies under the coat of a Principled BSDF, as Cycles has it.

    The coat takes its own albedo away; its tint is that of light along the normal, and deeper where
    the way through the coat is longer.
    """
    n = len(context)
    share = np.maximum(as_number(inputs["Coat"], n), 0.0)
    ior, roughness = as_number(inputs["IOR"], n), as_number(inputs["Roughness"], n)
    normal = as_vector(inputs.get("Normal", context.normal), n)
    left = np.clip(1.0 - share * _albedo(context, MULTI_GGX, ior, roughness, normal), 0.0, 1.0)
    cosine = dot(context.wo, normal)
    sine2 = (1.0 - cosine * cosine) / np.maximum(ior, _LEAST_IOR) ** 2
    depth = 1.0 / np.sqrt(np.maximum(1.0 - sine2, 1e-6))
    tint = np.maximum(as_vector(inputs["Tint"], n), 0.0) ** column(depth)
    tint = 1.0 + (tint - 1.0) * column(share)
    return {"": as_vector(inputs["Weight"], n) * column(left) * tint}


def under_sheen(context, settings, inputs):
    """Weight of what lies under the fibres of a Principled BSDF: what they do not reflect."""
    from ..bsdf.sheen import microfiber  # kernels: the exporters load without numba

    n = len(context)
    normal = as_vector(inputs.get("Normal", context.normal), n)
    roughness = np.clip(as_number(inputs["Roughness"], n), 1e-3, 1.0)
    share = (
        np.maximum(as_number(inputs["Sheen"], n), 0.0)
        * microfiber(dot(context.wo, normal), roughness)[2]
    )
    taken = row_maxima(np.maximum(as_vector(inputs["Tint"], n), 0.0)) * share
    return {"": as_vector(inputs["Weight"], n) * column(np.clip(1.0 - taken, 0.0, 1.0))}


def through_glass(context, settings, inputs):
    """The two parts of a weight: what a surface of glass reflects, and what goes straight through.

    "reflected": the factor of a clear layer's closure; "": the rest of Weight, times Tint. The
    camera sees more of the reflection at grazing angles. A shadow ray is told the share of a ray
    along the normal: so the answer is a matter of the place alone (program_ops.py). From inside
    there is no reflection: what would be seen there is the inside of the same body. Thickness, Film
    IOR and the setting space are those of a ThinFilm, where there is one.
    """
    n = len(context)
    weight, tint = (as_vector(inputs[name], n) for name in ("Weight", "Tint"))
    ior, roughness = as_number(inputs["IOR"], n), as_number(inputs["Roughness"], n)
    normal = as_vector(inputs.get("Normal", context.normal), n)
    wo = context.geometric_normal if context.shadow else None
    film = None
    if "Thickness" in inputs:
        own = (as_number(inputs[name], n) for name in ("Thickness", "Film IOR"))
        film = (settings["space"], *own)
    left = np.clip(1.0 - _albedo(context, GGX, ior, roughness, normal, wo, film), 0.0, 1.0)
    inside = np.float32(0.0)
    if not context.shadow:
        inside = np.float32(context.backfacing)
        left = np.maximum(left, inside)
    return {"": weight * tint * column(left), "reflected": weight * column(1.0 - inside)}


def grain(context, settings, inputs):
    """Closure.grain: the tangent, turned about the normal, with the length of Cycles' stretch.

    settings: model, ASPECT (Principled, Metallic) or GLOSSY: how Anisotropy widens the facets
    """
    n = len(context)
    amount, turn = as_number(inputs["Anisotropy"], n), as_number(inputs["Rotation"], n)
    tangent, normal = as_vector(inputs["Tangent"], n), inputs.get("Normal", context.normal)
    if settings["model"] == "GLOSSY":
        amount = np.clip(amount, -0.99, 0.99)
        ratio = np.where(amount < 0.0, 1.0 / (1.0 + amount), 1.0 - amount)
    else:  # alpha / aspect along the tangent, alpha * aspect across
        ratio = 1.0 / np.sqrt(1.0 - 0.9 * np.clip(amount, 0.0, 1.0))
    cosine, sine = np.cos(2.0 * np.pi * turn), np.sin(2.0 * np.pi * turn)
    axis = normalized(as_vector(normal, n))
    along = column(dot(axis, tangent) * (1.0 - cosine)) * axis
    turned = column(cosine) * tangent + column(sine) * np.cross(axis, tangent) + along
    return {"": np.float32(normalized(turned) * column(ratio))}


FUNCTIONS = {
    "grain": grain,
    "under_coat": under_coat,
    "under_sheen": under_sheen,
    "through_glass": through_glass,
}
