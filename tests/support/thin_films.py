"""What films reflect as core/bsdf/thin_film.py has it, of plain numbers."""

import numpy as np

from iwis.core.bsdf.microfacet import f0_of_ior
from iwis.core.bsdf.thin_film import dielectric_film, metal_film
from iwis.core.bsdf.thin_film_tables import REC709

_F = np.float32
GOLD = (0.14, 0.37, 1.44), (3.97, 2.5, 1.9)  # index and extinction


def fresnel_of(ior):
    """A row of Lobes.fresnel."""
    f0 = float(f0_of_ior(_F(ior)))
    return tuple(_F(x) for x in (ior * ior - 1.0, f0, 1.0 / (1.0 - f0)))


def three(value):
    """A tuple of three float32."""
    return tuple(_F(x) for x in np.broadcast_to(value, 3))


def dielectric(thickness, index, ior, cosine, space=REC709):
    """What a film on a dielectric of index ior reflects: (3,)."""
    fresnel = fresnel_of(ior)
    film = _F(thickness), _F(index), _F(space)
    return np.array(dielectric_film(film, fresnel, three(fresnel[1]), _F(cosine)))


def metal(thickness, index, first, second, cosine, code=REC709):
    """What a film on a metal reflects: (3,); first, second: index and extinction, or its colors."""
    film = _F(thickness), _F(index), _F(code)
    return np.array(metal_film(film, three(first), three(second), _F(cosine)))


def edge_of(base, tint):
    """What a metal reflects at the cosine 1/7."""
    base = np.asarray(base)
    return (base + (1.0 - base) * (6.0 / 7.0) ** 5) * tint
