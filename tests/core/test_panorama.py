"""core/camera/panorama.py: places of the square look where their projection says, and back.

(tests/parity compares each projection with Cycles.)
"""

import numpy as np
import pytest

from iwis.core.camera.camera import camera_rays, rays_through, view_depth
from iwis.core.camera.panorama import panorama_directions, pixel_angle
from iwis.core.camera.panorama_places import panorama_places
from iwis.core.scene import PANORAMIC, PERSPECTIVE, Camera, Panorama

PI = np.pi
EQUIRECTANGULAR = Panorama("EQUIRECTANGULAR", (-PI, PI, -PI / 2, PI / 2))
POLYNOMIAL = (36.0, 24.0, -1.17351e-5, -0.01998874, -3.3525e-6, 3.0993e-6, -2.61e-8)
KINDS = {
    "whole": EQUIRECTANGULAR,
    "part": Panorama("EQUIRECTANGULAR", (-1.0, 0.5, -0.3, 1.1)),
    "cube face": Panorama("EQUIANGULAR_CUBEMAP_FACE", ()),
    "mirror ball": Panorama("MIRRORBALL", ()),
    "equidistant": Panorama("FISHEYE_EQUIDISTANT", (PI,)),
    "equisolid": Panorama("FISHEYE_EQUISOLID", (PI, 36.0, 24.0, 10.5)),
    "polynomial": Panorama("FISHEYE_LENS_POLYNOMIAL", (PI, *POLYNOMIAL)),
    "narrow polynomial": Panorama("FISHEYE_LENS_POLYNOMIAL", (0.6, *POLYNOMIAL)),
    "cylinder": Panorama("CENTRAL_CYLINDRICAL", (-PI, PI, -1.0, 1.0, 0.0)),
    "turned cylinder": Panorama("CENTRAL_CYLINDRICAL", (-1.0, 1.5, -0.5, 1.0, 0.6)),
}
AHEAD, LEFT, RIGHT, UP, BACK = (0, 0, -1), (-1, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)
DIAGONAL = np.sqrt(0.5)
# (kind, place of the square, direction)
KNOWN = [
    ("whole", (0.5, 0.5), AHEAD),
    ("whole", (0.25, 0.5), LEFT),
    ("whole", (0.75, 0.5), RIGHT),
    ("whole", (0.0, 0.5), BACK),
    ("whole", (0.3, 1.0), UP),
    ("part", (0.0, 0.0), (np.sin(-1.0) * np.cos(0.3), -np.sin(0.3), -np.cos(1.0) * np.cos(0.3))),
    ("part", (1.0, 1.0), (np.sin(0.5) * np.cos(1.1), np.sin(1.1), -np.cos(0.5) * np.cos(1.1))),
    ("cube face", (0.5, 0.5), AHEAD),
    ("cube face", (1.0, 0.5), (DIAGONAL, 0.0, -DIAGONAL)),
    ("cube face", (0.0, 1.0), (-1 / np.sqrt(3), 1 / np.sqrt(3), -1 / np.sqrt(3))),
    ("mirror ball", (0.5, 0.5), AHEAD),
    ("mirror ball", (0.5 + 0.5 * DIAGONAL, 0.5), RIGHT),
    ("mirror ball", (0.5, 0.5 + 0.5 * DIAGONAL), UP),
    ("mirror ball", (1.0, 0.5), BACK),
    ("equidistant", (0.5, 0.5), AHEAD),
    ("equidistant", (1.0, 0.5), RIGHT),
    ("equidistant", (0.5, 0.0), (0, -1, 0)),
    ("equidistant", (0.5, 0.75), (0.0, DIAGONAL, -DIAGONAL)),
    ("equidistant", (1.0, 1.0), (0, 0, 0)),
    ("equisolid", (0.5, 0.5), AHEAD),
    ("equisolid", (0.5 + 21.0 * np.sin(PI / 4) / 36.0 - 1e-12, 0.5), RIGHT),
    ("equisolid", (0.95, 0.5), (0, 0, 0)),
    ("narrow polynomial", (1.0, 1.0), (0, 0, 0)),
    ("cylinder", (0.5, 0.5), AHEAD),
    ("cylinder", (0.75, 0.5), RIGHT),
    ("cylinder", (0.5, 1.0), (0.0, DIAGONAL, -DIAGONAL)),
]


@pytest.mark.parametrize(("name", "place", "direction"), KNOWN)
def test_known_places_look_where_they_should(name, place, direction):
    """Centre, corners and edges; zeros outside the image circle."""
    found = panorama_directions(KINDS[name], [place[0]], [place[1]])[0]
    np.testing.assert_allclose(found, direction, atol=1e-6)  # square roots near 0 of float64


@pytest.mark.parametrize("name", KINDS)
def test_a_direction_leads_back_to_its_place(name):
    """panorama_places undoes panorama_directions; directions are unit or zero."""
    rng = np.random.default_rng(1)
    places = rng.uniform(0.02, 0.98, (500, 2))
    directions = panorama_directions(KINDS[name], places[:, 0], places[:, 1])
    length = np.linalg.norm(directions, axis=1)
    seen = length > 0.0
    assert seen.sum() > 250
    np.testing.assert_allclose(length[seen], 1.0, rtol=1e-12)
    found = panorama_places(KINDS[name], directions[seen])
    np.testing.assert_allclose(found, places[seen], atol=1e-6)  # arccos of float64 near 1


@pytest.mark.parametrize("name", ["whole", "cube face", "cylinder"])
def test_a_pixel_in_the_middle_is_as_wide_as_its_neighbours_are_apart(name):
    """pixel_angle, by the directions of two pixels' centres."""
    camera = _camera(KINDS[name], 200, 100)
    a, b = rays_through(camera, np.array([100.0, 101.0]), np.array([50.0, 50.0])).directions
    angle = np.arccos(np.clip(np.float64(a) @ b, -1.0, 1.0))
    assert pixel_angle(camera) == pytest.approx(angle, rel=1e-2)  # float32 of a small angle


def _camera(panorama, width=8, height=4, **fields):
    place = np.eye(4)
    place[:3, 3] = 1.0, -2.0, 0.5
    known = {"clip_start": 0.5, "clip_end": 4.0, "window": (0.0, 1.0, 0.0, 1.0)}
    return Camera(
        kind=PANORAMIC,
        camera_to_world=place,
        width=width,
        height=height,
        region=(0, 0, width, height),
        panorama=panorama,
        **known | fields,
    )


def test_a_panorama_is_clipped_by_spheres():
    """Rays begin at clip_start from the camera, reach to clip_end, and depth is a distance."""
    camera = _camera(EQUIRECTANGULAR)
    rays = camera_rays(camera, 0, 0, 8, 4)
    np.testing.assert_allclose(view_depth(camera, rays.origins), 0.5, rtol=1e-5)
    ends = rays.origins + rays.reach[:, None] * rays.directions
    np.testing.assert_allclose(view_depth(camera, ends), 4.0, rtol=1e-5)


def test_outside_the_image_circle_is_no_ray():
    """A direction of zeros, and nothing within reach."""
    rays = camera_rays(_camera(KINDS["equidistant"]), 0, 0, 8, 4)
    blind = ~rays.directions.any(axis=1)
    assert 0 < blind.sum() < len(blind)
    assert (rays.reach[blind] == 0.0).all() and (rays.reach[~blind] > 0.0).all()


def test_a_camera_and_its_panorama_go_together():
    """Kind PANORAMIC needs a panorama with all its parameters; other kinds have none."""
    for kind, panorama in (
        (PANORAMIC, None),
        (PERSPECTIVE, EQUIRECTANGULAR),
        (PANORAMIC, Panorama("FISHEYE_EQUIDISTANT", ())),
        (PANORAMIC, Panorama("NEW_KIND", ())),
    ):
        with pytest.raises(ValueError, match="panorama"):
            Camera(
                kind=kind,
                camera_to_world=np.eye(4),
                window=(0.0, 1.0, 0.0, 1.0),
                width=2,
                height=2,
                region=(0, 0, 2, 2),
                clip_start=0.1,
                clip_end=1.0,
                panorama=panorama,
            )
