"""The end of a process does not wait for IWIS' threads after an interrupt, and only then."""

import subprocess
import sys
import time

import pytest

SCRIPT = """
import sys, threading, time
from iwis.iwis_addon.leave import end_with_failure, end_without_waiting

name, told, seconds, temporary = sys.argv[1:]
threading.Thread(target=time.sleep, args=(float(seconds),), name=name).start()
if told == "told":
    end_without_waiting(temporary)
if told == "failed":
    end_with_failure(temporary)
print("the last line")
sys.exit(3)
"""
LONG = 60.0  # seconds: as a kernel may take that is compiled for the first time


def _run(name, told, seconds, temporary):
    """(exit code, output, seconds) of a process that ends with a thread of this name at work."""
    began = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, name, told, str(seconds), str(temporary)],
        capture_output=True,
        text=True,
        timeout=LONG,
        check=False,
    )
    return done.returncode, done.stdout, time.monotonic() - began


@pytest.mark.slow
def test_process_ends_while_a_thread_of_ours_works(tmp_path):
    """At once, with code 1, all its lines and nothing left behind."""
    temporary = tmp_path / "blender_abc"
    temporary.mkdir()
    code, text, seconds = _run("iwis-early", "told", LONG, temporary)
    assert code == 1 and text == "the last line\n"
    assert seconds < LONG / 2  # Python and bpy start in two, on a busy machine in ten
    assert not temporary.exists()


@pytest.mark.slow
@pytest.mark.parametrize(("name", "told"), [("iwis-early", "untold"), ("other", "told")])
def test_threads_are_waited_for_otherwise(tmp_path, name, told):
    """Threads of others, and those of a render that nobody interrupted, end as they like."""
    code, text, seconds = _run(name, told, 1.0, tmp_path)
    assert code == 3 and text == "the last line\n" and seconds > 1.0
    assert tmp_path.exists()


@pytest.mark.slow
def test_process_of_an_unsaved_picture_fails(tmp_path):
    """Whatever works or not, when it ends by itself: all that comes until then is done."""
    code, text, _seconds = _run("other", "failed", 0.0, tmp_path / "blender_abc")
    assert code == 1 and text == "the last line\n"


NO_CAMERA = "bpy.context.scene.camera = None; bpy.ops.render.render()"
SCRIPT_OF_BPY = """
import bpy, iwis
iwis.register()
bpy.context.scene.render.engine = "IWIS"
print("the last line", flush=True)
"""


@pytest.mark.slow
@pytest.mark.parametrize(("ending", "code"), [("", 0), (NO_CAMERA, 1), ("iwis.unregister()", 0)])
def test_script_ends_that_does_not_take_the_engine_back(ending, code):
    """Blender 4.5 would wait forever: after the last line, and after an error (there is no camera);
    what a script does take back is not taken back again."""
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT_OF_BPY + ending],
        capture_output=True,
        text=True,
        timeout=LONG,
        check=False,
    )
    assert done.returncode == code and "the last line" in done.stdout
    assert code or "Traceback" not in done.stderr
