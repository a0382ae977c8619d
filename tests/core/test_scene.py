"""core/scene.py: arrays are checked once, at the door, by name."""

import dataclasses

import numpy as np
import pytest

from iwis.core.scene import EnvironmentMap
from support.scenes import camera_above, diffuse, floor, gradient_world, make_mesh, make_scene


def _scene():
    return make_scene([floor()], [diffuse()], gradient_world(), camera_above())


@pytest.mark.parametrize(
    "name", ["vertices", "triangles", "corner_normals", "material_index", "object_index"]
)
@pytest.mark.parametrize("spoil", [lambda a: a.astype(np.float64), lambda a: np.asfortranarray(a)])
def test_mesh_arrays_of_another_kind_are_refused(name, spoil):
    """Another dtype or order would compile every kernel again, or be read wrongly."""
    mesh = make_mesh(floor(), floor(z=1.0))
    bad = spoil(getattr(mesh, name))
    if bad.dtype == getattr(mesh, name).dtype and bad.flags.c_contiguous:
        bad = np.repeat(bad, 2, axis=0)[::2]  # one axis is in both orders: take a stride instead
    with pytest.raises(ValueError, match=f"^{name} must be C-contiguous"):
        dataclasses.replace(mesh, **{name: bad})


def test_mesh_arrays_of_unequal_length_are_refused():
    """One row a triangle."""
    mesh = make_mesh(floor())
    with pytest.raises(ValueError, match=r"material_index must be .* \(2,\), got int32 \(1,\)"):
        dataclasses.replace(mesh, material_index=np.zeros(1, np.int32))


@pytest.mark.parametrize("value", [-1, 4])
def test_triangles_that_name_no_vertex_are_refused(value):
    """Before Embree reads past the table."""
    scene = _scene()
    triangles = scene.mesh.triangles.copy()
    triangles[1, 2] = value
    mesh = dataclasses.replace(scene.mesh, triangles=triangles)
    with pytest.raises(ValueError, match="names a vertex that is not there"):
        dataclasses.replace(scene, mesh=mesh)


@pytest.mark.parametrize("value", [-1, 1])
@pytest.mark.parametrize("what", ["material", "object"])
def test_triangles_that_name_no_material_or_object_are_refused(what, value):
    """Before a kernel reads past the table."""
    scene = _scene()
    index = np.array([0, value], np.int32)
    mesh = dataclasses.replace(scene.mesh, **{f"{what}_index": index})
    with pytest.raises(ValueError, match=f"names an? {what} that is not there"):
        dataclasses.replace(scene, mesh=mesh)


@pytest.mark.parametrize(
    ("radiance", "message"),
    [
        (np.zeros((4, 8), np.float32), r"radiance must be \(h, w, 3\)"),
        (np.zeros((4, 8, 4), np.float32), r"radiance must be \(h, w, 3\)"),
        (np.zeros((0, 8, 3), np.float32), r"radiance must be \(h, w, 3\)"),
        (np.zeros((4, 8, 3)), "radiance must be C-contiguous float32"),
        (np.full((4, 8, 3), -np.inf, np.float32), "world studio: .* finite"),
        (np.full((4, 8, 3), np.nan, np.float32), "world studio: .* finite"),
        (np.full((4, 8, 3), np.inf, np.float32), "world studio: .* finite"),
    ],
    ids=["gray", "rgba", "empty", "float64", "below all", "nan", "infinite"],
)
def test_bad_radiance_is_refused(radiance, message):
    """With the world's name where its values are at fault."""
    with pytest.raises(ValueError, match=message):
        EnvironmentMap(radiance=radiance, name="studio")


@pytest.mark.parametrize("field", ["world_to_map", "strength"])
def test_bad_world_arrays_are_refused(field):
    """By name."""
    with pytest.raises(ValueError, match=f"{field} must be"):
        gradient_world(**{field: np.ones(2, np.float32)})


@pytest.mark.parametrize("region", [(0, 0, 17, 16), (-1, 0, 4, 4), (4, 4, 4, 8), (0, 8, 4, 4)])
def test_camera_regions_outside_the_frame_are_refused(region):
    """Empty and reversed ones too."""
    with pytest.raises(ValueError, match="is not inside 16x16"):
        camera_above(region=region)


def test_unknown_camera_kinds_are_refused():
    """A panorama is not silently a perspective."""
    with pytest.raises(ValueError, match="camera kind 'PANO' is unknown"):
        dataclasses.replace(camera_above(), kind="PANO")


def test_empty_mesh_is_a_scene():
    """Nothing to hit is no error."""
    scene = make_scene([], [], gradient_world(), camera_above())
    assert len(scene.mesh.triangles) == 0
