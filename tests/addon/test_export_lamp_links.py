"""Light linking as Blender keeps it: collections of receivers and blockers. Pictures beside Cycles'
are cases of the parity suite."""

import bpy
import numpy as np
import pytest
from parity.link_cases import collection

from iwis.iwis_addon.export import LiveExport, export_scene
from iwis.iwis_addon.export.placed.mesh import ExportCache
from support.above import look_from_above

NAMES = ("A", "B", "C")


@pytest.fixture
def scene(scene):
    """Three squares, a lamp and a camera."""
    look_from_above(scene)
    scene.world = bpy.data.worlds.new("Grey")
    for x, name in enumerate(NAMES):
        bpy.ops.mesh.primitive_plane_add(size=0.5, location=(x, 0.0, 0.0))
        bpy.context.object.name = name
    add_lamp("Lamp")
    return scene


def add_lamp(name):
    lamp = bpy.data.objects.new(name, bpy.data.lights.new(name, "POINT"))
    lamp.data.energy, lamp.location, lamp.visible_camera = 10.0, (0.0, 0.0, 2.0), False
    bpy.context.scene.collection.objects.link(lamp)
    return lamp


def exported():
    lines, geometry = [], []
    graph = bpy.context.evaluated_depsgraph_get()
    found = export_scene(graph, warnings=lines, geometry=geometry)
    return found, [one.name for one in geometry[0].inventory.instances], lines


def names_of(mask, names):
    return None if mask is None else {n for n, on in zip(names, mask, strict=True) if on}


def receivers_of(linked):
    """Names of the objects that the lamp lights, with that collection; None: all."""
    bpy.data.objects["Lamp"].light_linking.receiver_collection = linked
    found, names, lines = exported()
    assert lines == []
    return names_of(found.lamp_links[found.lamps.link[0]].receivers, names)


def test_without_links_there_are_none(scene):
    """A lamp is about all objects."""
    found, _, _ = exported()
    assert found.lamps.link.tolist() == [-1] and found.lamp_links == ()


@pytest.mark.parametrize(
    ("objects", "state", "expected"),
    [
        (("A",), "INCLUDE", {"A"}),
        (("A",), "EXCLUDE", {"B", "C"}),
        (NAMES, "EXCLUDE", set()),
        (NAMES, "INCLUDE", None),
        ((), "INCLUDE", None),
    ],
)
def test_objects_in_or_out(scene, objects, state, expected):
    """What is included is all there is; of exclusions alone all others are."""
    assert receivers_of(collection("R", objects, state)) == expected


def test_what_is_excluded_is_never_included(scene):
    """One of each: the child collection includes what its parent excludes."""
    child = collection("Child", ("A", "B"))
    assert receivers_of(collection("R", ("A",), "EXCLUDE", (child,))) == {"B"}


def test_a_childs_own_states_say_nothing(scene):
    """The state of the child among its parent's children is that of all that is in it."""
    inner = collection("Inner", ("A",), "EXCLUDE")
    outer = collection("Outer", children=(inner,), child_state="EXCLUDE")
    assert receivers_of(collection("R", ("C",), children=(outer,))) == {"A", "C"}


def test_blockers_are_read_likewise(scene):
    """Receivers are all of them."""
    bpy.data.objects["Lamp"].light_linking.blocker_collection = collection("B", ("B",))
    found, names, _ = exported()
    (link,) = found.lamp_links
    assert link.receivers is None and names_of(link.blockers, names) == {"B"}


def test_lamps_share_links(scene):
    """Two lamps with the same collections have one link, a third without has none."""
    linked = collection("R", ("A",))
    for name in ("Lamp", "Second"):
        lamp = bpy.data.objects.get(name) or add_lamp(name)
        lamp.light_linking.receiver_collection = linked
    add_lamp("Third")
    found, _, _ = exported()
    assert sorted(found.lamps.link.tolist()) == [-1, 0, 0] and len(found.lamp_links) == 1


def test_links_of_what_does_not_shine_mean_nothing(scene):
    """Any object may have some; of a square that is no light they cost nothing."""
    bpy.data.objects["A"].light_linking.blocker_collection = collection("B", ("B",))
    found, _, lines = exported()
    assert found.lamp_links == () and lines == []


@pytest.mark.parametrize("named", ["Copies", "A", "both"])
def test_copies_are_known_by_their_maker_or_by_themselves(scene, named):
    """Where links know the empty that makes copies, it stands for them; else their object does."""
    own = bpy.data.collections.new("Own")
    square = bpy.data.objects["A"]
    scene.collection.objects.unlink(square)
    own.objects.link(square)
    for k, name in enumerate(("Copies", "Others")):
        empty = bpy.data.objects.new(name, None)
        empty.instance_type, empty.instance_collection = "COLLECTION", own
        empty.location = (k, 0.0, 0.0)
        scene.collection.objects.link(empty)
    linked = collection("R", ("A", "Copies") if named == "both" else (named,))
    bpy.data.objects["Lamp"].light_linking.receiver_collection = linked
    found, names, _ = exported()
    receivers = found.lamp_links[0].receivers
    copies = [k for k, name in enumerate(names) if name == "A"]
    assert receivers[copies].tolist() == [True, named != "Copies"]
    assert not receivers[[k for k, name in enumerate(names) if name != "A"]].any()


def test_a_window_sees_links_change(scene):
    """The rendered view's next scene has the new link; without a change it is equal."""
    live, cache = LiveExport(), ExportCache()

    def look():
        live.begin([])
        graph = bpy.context.evaluated_depsgraph_get()
        return export_scene(graph, warnings=[], cache=cache, live=live)

    before = look()
    bpy.data.objects["Lamp"].light_linking.receiver_collection = collection("R", ("A",))
    bpy.context.view_layer.update()
    after = look()
    assert before.lamp_links == () and len(after.lamp_links) == 1
    np.testing.assert_array_equal(after.lamp_links[0].receivers, look().lamp_links[0].receivers)
