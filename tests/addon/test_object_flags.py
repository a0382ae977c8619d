"""export/objects/object_flags.py: of an instance and of a collection, as Cycles has them."""

import bpy
import pytest

from iwis.core.scene import CAMERA_RAYS, HOLDOUT, SHADOW_CATCHER, SHADOW_RAYS
from support.above import BENT, QUADS, add_mesh, look_from_above
from support.trace_scene import export_as_render

BOTH = CAMERA_RAYS | SHADOW_RAYS


@pytest.fixture
def above(scene):
    """An empty file seen from above."""
    look_from_above(scene)
    return scene


@pytest.fixture
def thing(above):
    """An object in a collection of its own, which the scene does not have."""
    obj = add_mesh(above, BENT, QUADS, "Thing")
    collection = bpy.data.collections.new("Own")
    collection.objects.link(obj)
    above.collection.objects.unlink(obj)
    return obj


def _flags(scene) -> list[int]:
    found = export_as_render(scene).geometry.inventory.instances
    return [i.flags for i in found if i.name == "Thing"]


@pytest.mark.parametrize(
    "setting, value, of_thing, of_instancer",
    [
        ("is_holdout", True, BOTH, BOTH | HOLDOUT),
        ("is_shadow_catcher", True, BOTH | SHADOW_CATCHER, BOTH | SHADOW_CATCHER),
        ("visible_camera", False, SHADOW_RAYS, SHADOW_RAYS),
        ("visible_shadow", False, CAMERA_RAYS, CAMERA_RAYS),
    ],
)
def test_flags_of_an_instance(above, thing, setting, value, of_thing, of_instancer):
    """Rays see what they see of both; it is a holdout if its instancer is one."""
    empty = bpy.data.objects.new("Instancer", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", bpy.data.collections["Own"]
    above.collection.objects.link(empty)
    assert _flags(above) == [BOTH]
    setattr(thing, setting, value)
    assert _flags(above) == [of_thing]
    setattr(thing, setting, not value)
    setattr(empty, setting, value)
    assert _flags(above) == [of_instancer]


@pytest.mark.parametrize(
    "settings, wanted",
    [
        ({"holdout": True}, BOTH | HOLDOUT),
        ({"indirect_only": True}, SHADOW_RAYS),
        ({"holdout": True, "indirect_only": True}, BOTH | HOLDOUT),
    ],
)
def test_flags_of_a_collection(above, thing, settings, wanted):
    """The view layer makes all of its objects holdouts, or hides them from the camera."""
    above.collection.children.link(bpy.data.collections["Own"])
    for key, value in settings.items():
        setattr(above.view_layers[0].layer_collection.children["Own"], key, value)
    assert _flags(above) == [wanted]
