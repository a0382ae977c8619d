"""One point in a corner, by quadrature: what every unbiased estimator must converge to.

All pixels of these pictures see one point (the camera looks at a hundredth of a millimetre), each
with its own shift: independent estimates. The quadrature shares no code with the samplers but the
world's look-up and Embree, which have tests of their own.
"""

import numpy as np

from iwis.core.embree.accel import Accel
from iwis.core.light.environment import eval_environment_many, make_lookup

from .naive import ggx_brdf_cos, integrate_diffuse, integrate_glossy, texel_directions
from .scenes import (
    box,
    camera_at,
    diffuse,
    floor,
    glossy,
    gradient_world,
    make_scene,
    one_texel_world,
    quad,
)

PIXELS = 20  # of the pictures: PIXELS^2 independent estimates
ALBEDO = np.array([0.8, 0.6, 0.3])
EYE = np.array([0.0, -3.0, 2.0])
MATERIALS = {"diffuse": diffuse(ALBEDO)} | {
    f"alpha {alpha}": glossy(alpha, ALBEDO) for alpha in (0.01, 0.05, 0.2, 1.0)
}
HEIGHT = 32  # of the maps with a sun of one texel: 11 degrees wide
SUNS = {
    "sun over the wall": (26, 37),  # the wall's top hides half of it
    "sun in the mirror": (21, 15),  # where the camera's ray is reflected to
}
SUN, SKY = 1e5, 0.2
WORLDS = {"gradient": gradient_world()} | {
    name: one_texel_world(HEIGHT, *place, SUN, SKY) for name, place in SUNS.items()
}
CASES = [(world, material) for world in WORLDS for material in MATERIALS]


def corner_scene(world: str, material: str):
    """A floor between a wall, a box and a roof; the camera sees the origin."""
    parts = [
        floor(3.0),
        quad((0.5, -1.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 1.0)),
        box((-0.9, -0.2, 0.0), (-0.4, 0.5, 0.6)),
        quad((-0.5, 1.4, 0.9), (1.0, 0.0, 0.0), (0.0, 1.5, 0.2)),
    ]
    camera = camera_at(EYE, (0.0, 0.0, 0.0), PIXELS, PIXELS, half=1e-5)
    return make_scene(parts, [MATERIALS[material], *[diffuse()] * 3], WORLDS[world], camera)


def corner_truth(scene, world: str, material: str):
    """float64 (3,): radiance of the origin towards the camera, by quadrature."""
    lookup, accel = make_lookup(scene.environment), Accel(scene.mesh)
    up, wo = np.array([0.0, 0.0, 1.0]), EYE / np.linalg.norm(EYE)
    alpha = None if material == "diffuse" else float(material.split()[1])

    def free(directions):
        origins = np.tile(np.float32([0.0, 0.0, accel.offset]), (len(directions), 1))
        return ~accel.occluded(origins, directions.astype(np.float32))[:, None]

    def broad_light(directions):
        radiance = np.full((len(directions), 3), SKY, np.float32)
        if world not in SUNS:
            eval_environment_many(lookup, directions.astype(np.float32), radiance)
        return np.where(free(directions), radiance, 0.0)

    if alpha is None:
        total = integrate_diffuse(broad_light, ALBEDO, up, side=700)
    else:
        total = integrate_glossy(broad_light, ALBEDO, alpha, up, wo, side=700)
    if world in SUNS:
        directions, weights = texel_directions(HEIGHT, *SUNS[world])
        if alpha is None:
            reflected = np.maximum(directions[:, 2:], 0.0) * ALBEDO / np.pi
        else:
            reflected = ggx_brdf_cos(directions, ALBEDO, alpha, up, wo)
        total = total + (SUN - SKY) * (weights[:, None] * reflected * free(directions)).sum(0)
    return total
