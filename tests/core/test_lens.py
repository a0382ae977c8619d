"""lens.py and the lens in camera.py: the aperture, the plane of focus, the blur."""

import dataclasses

import numpy as np
import pytest

from iwis.core.camera.camera import rays_through, view_depth
from iwis.core.camera.lens import aperture_point, blur_widths
from iwis.core.camera.pixel_filter import LENS, unit_points
from iwis.core.scene import PANORAMIC, Lens, Panorama
from support.scenes import camera_above, camera_at

RADIUS, FOCUS = 0.05, 3.0
LENS_OPEN = Lens(RADIUS, FOCUS)
CAMERAS = {
    "perspective": camera_at((3.0, -2.0, 1.5), (0.0, 0.5, 0.2), width=8, height=6, half=0.7),
    "orthographic": camera_above(width=8, height=6, half=2.0, z=5.0),
}
CAMERAS["panoramic"] = dataclasses.replace(
    CAMERAS["perspective"],
    kind=PANORAMIC,
    window=(0.0, 1.0, 0.0, 1.0),
    panorama=Panorama("EQUIRECTANGULAR", (-np.pi, np.pi, -np.pi / 2, np.pi / 2)),
)
CAMERAS["mirror ball"] = dataclasses.replace(
    CAMERAS["panoramic"], panorama=Panorama("MIRRORBALL", ())
)


def _grid(n):
    u, v = (np.mgrid[:n, :n] + 0.5) / n
    return np.stack([u.ravel(), v.ravel()], -1)


def _aperture(blades, rotation, n=200):
    return np.array([aperture_point(u, v, blades, rotation) for u, v in _grid(n)])


@pytest.mark.parametrize("blades", [0, 2, 3, 5, 8])
def test_the_aperture_is_filled_evenly(blades):
    """Centre of gravity 0, and the second moments of a disc or of an inscribed polygon."""
    points = _aperture(blades, 0.4)
    corner = np.pi / blades if blades > 2 else 0.0
    # of area: r^2 / 4 of a disc; (2 + cos(2 pi / n)) / 12 of a polygon with corners at 1
    moment = (2.0 + np.cos(2.0 * corner)) / 12.0 if blades > 2 else 0.25
    np.testing.assert_allclose(points.mean(axis=0), 0.0, atol=2e-4)  # of 200 x 200 cells
    np.testing.assert_allclose((points**2).mean(axis=0), moment, rtol=1e-3)
    assert (points[:, 0] * points[:, 1]).mean() == pytest.approx(0.0, abs=2e-4)


@pytest.mark.parametrize("blades", [3, 5, 6])
def test_a_polygon_has_the_corners_of_its_blades(blades):
    """All points are inside each edge; the area is that of the polygon, by a histogram."""
    rotation = 0.3
    points = _aperture(blades, rotation, 400)
    for k in range(blades):
        middle = rotation + 2.0 * np.pi * k / blades
        out = points @ (np.cos(middle), np.sin(middle))
        assert out.max() <= np.cos(np.pi / blades) + 1e-12
    cells = np.histogram2d(*points.T, bins=40, range=[[-1, 1], [-1, 1]])[0]
    area = (cells > 0).sum() * 0.05**2
    # cells at the rim count as whole ones: half of the rim too much
    rim = 2.0 * blades * np.sin(np.pi / blades) * 0.05
    expected = 0.5 * blades * np.sin(2.0 * np.pi / blades)
    assert expected <= area <= expected + rim


def test_the_lens_points_of_a_pixel_cover_the_lens():
    """16 passes put one point into each of 4 x 4 cells, and neighbours have other points."""
    columns, rows = np.arange(5), np.zeros(5, np.int64)
    points = np.array([unit_points(columns, rows, k, 0, LENS) for k in range(16)])
    for own in points.transpose(1, 0, 2):
        assert len({tuple(cell) for cell in (own * 4).astype(int)}) == 16
    assert len(np.unique(points[0], axis=0)) == 5
    assert not np.allclose(points[0], unit_points(columns, rows, 0, 0))


@pytest.mark.parametrize("name", CAMERAS)
@pytest.mark.parametrize("blades", [0, 5])
def test_what_is_in_focus_stays_sharp(name, blades):
    """Rays from all over the lens meet on the plane of focus, a panorama's on a sphere."""
    camera = CAMERAS[name]
    opened = dataclasses.replace(camera, lens=Lens(RADIUS, FOCUS, blades, 0.3, 1.7), clip_start=0.1)
    lens_uv = _grid(8)
    x, y = np.full(len(lens_uv), 2.7), np.full(len(lens_uv), 3.4)
    rays = rays_through(opened, x, y, lens_uv)
    centre = rays_through(camera, x[:1], y[:1])
    start, ahead = np.float64(centre.origins[0]), np.float64(centre.directions[0])
    along = FOCUS - view_depth(camera, start[None])[0]
    if name in ("perspective", "orthographic"):
        along /= -ahead @ camera.camera_to_world[:3, 2]
    focus = start + along * ahead
    to_focus = focus - rays.origins
    miss = np.cross(to_focus, rays.directions)
    np.testing.assert_allclose(miss, 0.0, atol=5e-6)  # float32 of some metres
    assert np.ptp(rays.origins, axis=0).max() > 0.5 * RADIUS


@pytest.mark.parametrize("name", CAMERAS)
def test_the_lens_has_its_radius_and_centre(name):
    """Back at the lens, rays are spread over a disc across the view, half as wide by its ratio."""
    camera = dataclasses.replace(
        CAMERAS[name], lens=Lens(RADIUS, FOCUS, ratio=2.0), clip_start=0.0, clip_end=9.0
    )
    lens_uv = _grid(64)
    x, y = np.full(len(lens_uv), 3.2), np.full(len(lens_uv), 2.6)
    rays = rays_through(camera, x, y, lens_uv)
    eye = rays_through(dataclasses.replace(camera, lens=None), x[:1], y[:1]).origins[0]
    spread = np.float64(rays.origins) - eye
    np.testing.assert_allclose(spread.mean(axis=0), 0.0, atol=1e-4 * RADIUS + 1e-6)
    sizes = np.sqrt(np.linalg.svd(spread, compute_uv=False) ** 2 / len(spread))
    # the standard deviations of a disc along its axes are half of its radii
    np.testing.assert_allclose(sizes, [RADIUS / 2, RADIUS / 4, 0.0], atol=2e-3 * RADIUS)
    assert (np.abs(rays.reach - 9.0) < 2.0).all()


def test_orthographic_rays_through_a_lens_begin_on_the_near_plane():
    """Whatever their slope; and end on the far one."""
    camera = dataclasses.replace(
        CAMERAS["orthographic"], lens=Lens(0.8, 2.0), clip_start=1.0, clip_end=4.0
    )
    x, y, lens_uv = np.full(64, 4.2), np.full(64, 2.6), _grid(8)
    rays = rays_through(camera, x, y, lens_uv)
    np.testing.assert_allclose(view_depth(camera, rays.origins), 1.0, atol=1e-5)
    assert np.ptp(rays.directions, axis=0).max() > 0.5


@pytest.mark.parametrize(("name", "side"), [("panoramic", 1.0), ("mirror ball", -1.0)])
def test_a_panoramas_blades_turn_as_in_cycles(name, side):
    """Of rays that start at the lens' right and at its top: the other way round in a mirror."""
    camera = dataclasses.replace(CAMERAS[name], lens=LENS_OPEN, clip_start=0.0)
    lens_uv = np.array([[0.9, 0.5], [0.5, 0.9]])  # right of the centre, above it
    x, y = np.full(2, 2.7), np.full(2, 3.4)
    centre = rays_through(dataclasses.replace(camera, lens=None), x[:1], y[:1])
    right, up = np.float64(rays_through(camera, x, y, lens_uv).origins) - centre.origins[0]
    turned = np.cross(right, up) @ centre.directions[0]
    assert turned == pytest.approx(side * (0.8 * RADIUS) ** 2, rel=1e-3)  # float32 of some metres


def test_without_a_lens_point_the_picture_is_sharp():
    """The lens' centre: the rays of the closed lens, bit for bit."""
    for camera in CAMERAS.values():
        opened = dataclasses.replace(camera, lens=LENS_OPEN)
        x, y = np.array([0.5, 3.3]), np.array([1.5, 2.2])
        for a, b in zip(rays_through(opened, x, y), rays_through(camera, x, y), strict=True):
            np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("name", ["perspective", "orthographic"])
def test_a_point_is_spread_over_as_many_pixels_as_told(name):
    """blur_widths against the places where rays that meet in a point cross the window."""
    camera = dataclasses.replace(CAMERAS[name], lens=LENS_OPEN, clip_start=0.0)
    depth, left, right = 1.2, *camera.window[:2]
    lens_uv = _grid(64)
    x, y = np.full(len(lens_uv), 4.0), np.full(len(lens_uv), 3.0)
    rays = rays_through(camera, x, y, lens_uv)
    axes = camera.camera_to_world[:3, :3]
    ahead = -np.float64(rays.directions) @ axes[:, 2]
    local = (rays.origins - camera.camera_to_world[:3, 3]) @ axes
    reached = local + (depth + local[:, 2:]) / ahead[:, None] * (rays.directions @ axes)
    across = np.ptp(reached[:, 0]) / (depth if name == "perspective" else 1.0)
    pixels = across / ((right - left) / camera.width)
    told = blur_widths(camera, np.array([depth, FOCUS]))
    assert told[0] == pytest.approx(pixels, rel=0.02)  # 64 x 64 points do not reach the rim
    assert told[1] == pytest.approx(0.0, abs=1e-12)
