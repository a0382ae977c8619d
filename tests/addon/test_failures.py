"""Whatever fails: exit code 1, no file, no crash; with PNG and with OpenEXR.

Each case runs in a process of its own, for a crash at exit is what must not be. The failure is put
in from outside, at the place where the real one would be.
"""

import subprocess
import sys

import pytest

SCRIPT = """
import sys
import bpy
import iwis
from support.iwis_render import use_format

iwis.register()
scene = bpy.context.scene  # the factory's cube, camera and lamp
scene.render.engine = "IWIS"
scene.render.resolution_x = scene.render.resolution_y = 32
scene.iwis.tile_px, scene.iwis.max_samples = 8, 4
use_format(scene, sys.argv[2])
scene.render.filepath = sys.argv[1]
{failure}
code = 0
try:
    bpy.ops.render.render(write_still=True)
except RuntimeError as error:
    print("MESSAGE", str(error).strip())
    code = 1
scene.render.engine = "BLENDER_WORKBENCH"
iwis.unregister()
sys.exit(code)
"""

EXPORT = """
import iwis.iwis_addon.session as session
def export_scene(*arguments, **options):
    raise {error}
session.export_scene = export_scene
"""
CORE = """
import iwis.core.render
def render(*arguments):
    raise {error}
iwis.core.render.render = render
"""
LATE = """
import iwis.core.render
from iwis.core.render import render as real
def render(scene, settings, sink, cache):
    tiles = []
    def write_tile(tile, write=sink.write_tile):
        tiles.append(tile)
        if len(tiles) == 3:
            raise MemoryError("at the third tile")
        write(tile)
    sink.write_tile = write_tile
    return real(scene, settings, sink, cache)
iwis.core.render.render = render
"""
SINK = """
from iwis.iwis_addon.sink import BlenderSink
def write_tile(self, tile):
    raise RuntimeError("tile refused")
BlenderSink.write_tile = write_tile
"""
CASES = {
    "missing package": ("sys.modules['embreex'] = None", "Python package embreex is missing"),
    "broken package": (
        "import embreex; sys.modules['embreex'] = None\n"
        "import iwis.iwis_addon.dependencies as d; d.missing = lambda: []",
        "embreex does not load",
    ),
    "odd environment": (
        "import os; os.environ['NUMBA_NUM_THREADS'] = '0'",
        "numba does not load (ValueError: Number of threads specified must be > 0.). Unset what is "
        "wrong of the environment: NUMBA_NUM_THREADS=0",
    ),
    "export": (EXPORT.format(error="ValueError('World: texel is negative')"), "World: texel"),
    "export, unforeseen": (EXPORT.format(error="KeyError('oops')"), "KeyError"),
    "core": (CORE.format(error="OSError('cannot read tables')"), "cannot read tables"),
    "core, unforeseen": (CORE.format(error="ZeroDivisionError()"), "ZeroDivisionError"),
    "core, no memory": (CORE.format(error="MemoryError()"), "not enough memory: render smaller"),
    "core, after two tiles": (LATE, "not enough memory: at the third tile"),
    "sink": (SINK, "tile refused"),
    "interrupted": (CORE.format(error="KeyboardInterrupt()"), "interrupted"),
    "no camera": ("bpy.data.objects.remove(scene.camera)", "camera"),
}


def run(failure, path, file_format):
    """Render with a failure; the finished process."""
    return subprocess.run(
        [sys.executable, "-c", SCRIPT.format(failure=failure), str(path), file_format],
        capture_output=True,
        text=True,
        timeout=280,  # the first render on a machine compiles the kernels
        check=False,
        cwd=__file__.rpartition("/addon/")[0],  # for support
    )


@pytest.mark.slow
@pytest.mark.parametrize("file_format", ["PNG", "OPEN_EXR_MULTILAYER"])
@pytest.mark.parametrize("case", CASES)
def test_failure_stops_the_job(case, file_format, tmp_path):
    """Exit code 1, the message, and nothing saved."""
    failure, message = CASES[case]
    done = run(failure, tmp_path / "out", file_format)
    assert done.returncode == 1, done
    assert "MESSAGE" in done.stdout and message in done.stdout.partition("MESSAGE")[2], done
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("file_format", ["PNG", "OPEN_EXR_MULTILAYER"])
def test_twin_without_a_failure_saves(file_format, tmp_path):
    """The script above renders when nothing is put in: its failures are the failures' own."""
    done = run("", tmp_path / "out", file_format)
    assert done.returncode == 0, done
    assert len(list(tmp_path.iterdir())) == 1


def _succeeds(script):
    """What a process with bpy said that ran the script and ended with 0."""
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done
    return done


@pytest.mark.slow
def test_registering_succeeds_without_packages(tmp_path):
    """Without numba and embreex the add-on registers, and says on stderr what to do."""
    script = (
        "import sys; sys.modules['numba'] = sys.modules['embreex'] = None\n"
        "import bpy, iwis; iwis.register()\n"
        "assert bpy.context.scene.iwis.max_samples > 0\n"
        "from iwis.iwis_addon.panels_status import IWIS_PT_warnings\n"
        "bpy.context.scene.render.engine = 'IWIS'\n"
        "assert IWIS_PT_warnings.poll(bpy.context)\n"
        "bpy.context.scene.render.engine = 'BLENDER_WORKBENCH'\n"
        "iwis.unregister()"
    )
    done = _succeeds(script)
    assert "numba and embreex are missing" in done.stderr and "Install the IWIS" in done.stderr


@pytest.mark.slow
def test_second_copy_is_refused_while_the_first_is_enabled(tmp_path):
    """By a line that names the first, which stays whole; the second may have its turn later."""
    script = (
        "import bpy, importlib.util, sys, iwis\n"
        "spec = importlib.util.spec_from_file_location('copy_of_iwis', iwis.__file__)\n"
        "copy = importlib.util.module_from_spec(spec); sys.modules['copy_of_iwis'] = copy\n"
        "spec.loader.exec_module(copy)\n"
        "iwis.register()\n"
        "try:\n    copy.register()\n"
        "except RuntimeError as error:\n    print('MESSAGE', error)\n"
        "bpy.context.scene.render.engine = 'IWIS'\n"
        "assert bpy.context.scene.iwis.max_samples > 0\n"
        "bpy.context.scene.render.engine = 'BLENDER_WORKBENCH'\n"
        "iwis.unregister(); copy.register(); copy.unregister(); iwis.register(); iwis.unregister()"
    )
    done = _succeeds(script)
    assert "MESSAGE IWIS is already enabled, as the add-on 'iwis': disable that" in done.stdout
    assert "has been registered before" not in done.stdout + done.stderr
