"""White furnace: under light of 1 from everywhere a surface shows its albedo. Through render()."""

import numpy as np
import pytest

from iwis.core.scene import MULTI_GGX
from support.scenes import (
    camera_above,
    camera_at,
    constant_world,
    diffuse,
    floor,
    glossy,
    make_picture,
    make_scene,
    principled,
    sphere,
)

ALBEDO = np.array([0.8, 0.5, 0.2])
SHAPES = {
    "plane": floor(),
    "sphere": sphere(rings=24),
    # Interpolated normals: what a flat face hides of the rounded one's half sphere is 3e-4.
    "smooth sphere": sphere(rings=24, smooth=True),
}


def _mean(part, material, camera, **settings):
    """(mean colour, mean I_s) over the pixels that show the surface."""
    scene = make_scene([part], [material], constant_world(), camera)
    layers, _ = make_picture(scene, stop_rule="FIXED", **settings)
    shown = layers["depth"][..., 0] < 1e9
    return layers["combined"][shown][:, :3].mean(0), layers["unoccluded"][shown].mean(0)


@pytest.mark.parametrize("shape", SHAPES)
def test_unbiased_shows_the_albedo(shape):
    """To 1e-3: 200 pixels and more of 1024 samples have a standard error of 1.5e-4 (measured)."""
    mean, _ = _mean(SHAPES[shape], diffuse(ALBEDO), camera_above(half=0.65), max_samples=1024)
    np.testing.assert_allclose(mean, ALBEDO, atol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["plane", "sphere"])
@pytest.mark.parametrize(("coefficients", "tolerance"), [(1.0, 1e-3), (0.05, 3e-3)])
def test_paper_shows_the_albedo(shape, coefficients, tolerance, table_dir):
    """I_s to 1e-4 (it is the mean of the Lambert slice), I_d to 1e-3; to 3e-3 at 5 %.

    What is lost: samples go down the slice of the nearest normal, up to 2.3 degrees off, and those
    that dip below the face count as hidden, (2.3 degrees)^2 / 4 = 4e-4 of a cosine; at 5 % the
    cosine's cells are coarse at the horizon and hold more of them than they should.
    """
    mean, unoccluded = _mean(
        SHAPES[shape],
        diffuse(ALBEDO),
        camera_above(half=0.65),
        max_samples=256,
        estimator="PAPER",
        coefficients=coefficients,
        cache_dir=table_dir,
    )
    np.testing.assert_allclose(unoccluded, ALBEDO, rtol=1e-4)
    np.testing.assert_allclose(mean, ALBEDO, atol=tolerance)
    assert (mean <= unoccluded).all()


@pytest.mark.parametrize("roughness", [0.1, 0.3, 0.5, 0.8, 1.0])
@pytest.mark.parametrize("kind", ["metal", "glossy"])
def test_multiple_scattering_loses_nothing(kind, roughness):
    """A white MULTI_GGX surface seen from 22 degrees above it reflects all, at every roughness.

    3e-3: the albedo tables that say what is lost are good to 1e-3 (tests of the BRDF), the standard
    error of 256 pixels of 512 samples is 5e-4.
    """
    white = {"distribution": MULTI_GGX, "base_color": (1.0, 1.0, 1.0), "roughness": roughness}
    material = principled(metallic=1.0, **white) if kind == "metal" else glossy(1.0) | white
    camera = camera_at((0.0, -3.0, 1.2), (0.0, 0.0, 0.0), half=0.2)
    mean, _ = _mean(floor(), material, camera, max_samples=512)
    np.testing.assert_allclose(mean, 1.0, atol=3e-3)


@pytest.mark.parametrize("alpha", [0.05, 0.3, 1.0])
def test_single_scattering_loses_some(alpha):
    """Plain GGX reflects no more than 1, and less the rougher it is."""
    camera = camera_at((0.0, -3.0, 1.2), (0.0, 0.0, 0.0), half=0.2)
    mean, _ = _mean(floor(), glossy(alpha, (1.0, 1.0, 1.0)), camera, max_samples=256)
    assert 0.4 < mean[1] < 1.001


def test_direct_passes_are_light_without_colour():
    """Diffuse Direct x Diffuse Color + Glossy Direct x Glossy Color + Emission = Combined."""
    material = principled(base_color=(0.7, 0.4, 0.1), emission=(0.1, 0.0, 0.3))
    scene = make_scene([floor()], [material], constant_world((0.5, 1.0, 2.0)), camera_above())
    layers, _ = make_picture(scene, max_samples=64)
    total = layers["emission"].copy()
    for lobe in ("diffuse", "glossy"):
        total += layers[f"{lobe}_direct"] * layers[f"{lobe}_color"]
    np.testing.assert_allclose(total, layers["combined"][..., :3], rtol=1e-5)  # float32
    # Light of one colour from everywhere, and no shadow: its irradiance / pi is the light itself.
    mean = layers["diffuse_direct"].mean((0, 1))
    np.testing.assert_allclose(mean, [0.5, 1.0, 2.0], rtol=5e-3)  # 256 x 64 samples
