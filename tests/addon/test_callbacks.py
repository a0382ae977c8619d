"""Whoever takes the engine from Blender first ends what other threads render with it."""

import threading

import bpy
import pytest

from iwis.iwis_addon import bake_unsupported, callbacks, cycles_settings, world_bake
from iwis.iwis_addon.job import RenderJob

SECONDS = 20.0  # that no test may wait


class Rendering(threading.Thread):
    """As a thread of Blender's in a callback, which looks for a cancel as a user's Esc is one."""

    def __init__(self, listens: bool):
        super().__init__(daemon=True)
        self._listens, self.inside, self.leave = listens, threading.Event(), threading.Event()
        self.start()
        assert self.inside.wait(SECONDS)

    def run(self):
        with callbacks.inside():
            self.inside.set()
            ends = RenderJob.interrupt if self._listens else self.leave
            ends.wait(SECONDS)


def test_a_callback_of_another_thread_is_ended_and_waited_for():
    """It is told to end, has left when end_all() returns, and the next render may go on."""
    thread = Rendering(listens=True)
    assert callbacks.end_all(SECONDS)
    thread.join(SECONDS)
    assert not thread.is_alive()
    assert not RenderJob.interrupt.is_set()


def test_one_that_does_not_answer_is_not_waited_for_without_end():
    """The time is over, and that is told."""
    thread = Rendering(listens=False)
    assert not callbacks.end_all(0.1)
    thread.leave.set()
    thread.join(SECONDS)
    assert callbacks.end_all(0.1)


def test_a_callback_does_not_wait_for_itself():
    """A handler that disables the add-on in a render of this very thread."""
    with callbacks.inside():
        assert callbacks.end_all(SECONDS)
        assert not RenderJob.interrupt.is_set()


def test_an_exception_leaves_as_well():
    """Nobody waits for a callback that has failed."""
    with pytest.raises(ValueError, match="bad"), callbacks.inside():
        raise ValueError("bad")
    assert not callbacks._inside


@pytest.fixture
def running(monkeypatch):
    """Jobs that Blender is said to run: in background it has none."""
    jobs = set()
    monkeypatch.setattr(callbacks, "_is_running", jobs.__contains__)
    return jobs


def test_each_preview_of_a_job_is_ended(running):
    """The next one of the same job, too, which begins as soon as the first has ended."""
    running.add("RENDER_PREVIEW")
    first, more = Rendering(listens=True), []

    def next_one():
        first.join(SECONDS)
        more.append(Rendering(listens=True))

    follower = threading.Thread(target=next_one)
    follower.start()
    callbacks.end_previews(SECONDS)
    follower.join(SECONDS)
    more[0].join(SECONDS)
    assert not callbacks._inside
    assert not RenderJob.interrupt.is_set()


def test_without_previews_no_render_is_ended(running):
    """A bake or render of another thread goes on."""
    thread = Rendering(listens=False)
    callbacks.end_previews(0.0)
    assert callbacks._inside
    thread.leave.set()
    thread.join(SECONDS)


class Asked(Exception):
    """Raised where previews would be ended."""


@pytest.mark.parametrize("module", [cycles_settings, world_bake, bake_unsupported])
def test_buttons_end_previews_before_they_set_an_engine(scene, module, monkeypatch):
    """Blender would wait for them with Python in its hands, for ever."""

    def asked():
        assert scene.render.engine == "IWIS"
        raise Asked

    monkeypatch.setattr(module, "end_previews", asked)
    scene.render.engine = "IWIS"
    scene.world = bpy.data.worlds.new("World")
    calls = {
        cycles_settings: lambda: cycles_settings.compare_with_cycles(scene, 1),
        world_bake: lambda: world_bake.bake_world(scene, 4, 1),
        bake_unsupported: lambda: bake_unsupported.bake_unsupported(bpy.context, 4, 1),
    }
    with pytest.raises(Asked):
        calls[module]()


@pytest.mark.parametrize("name", ["compare_cycles", "convert_world", "bake_unsupported"])
@pytest.mark.parametrize("job", ["RENDER", "OBJECT_BAKE"])
def test_buttons_that_render_are_grey_while_blender_renders(scene, running, name, job):
    """A render inside of a job of Blender's ends it with a crash."""
    scene.world = bpy.data.worlds.new("World")
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    operator = getattr(bpy.ops.iwis, name)
    assert operator.poll()
    running.add(job)
    assert not operator.poll()
    assert callbacks.cannot_render().startswith("A render" if job == "RENDER" else "A bake")
    running.clear()
    assert callbacks.cannot_render() == ""
