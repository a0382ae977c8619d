"""python -m iwis on bad input: exit codes, one line on stderr, what is kept after an interrupt.

One process runs the commands of all tests that need no process of their own.
"""

import json
import os
import signal
import subprocess
import sys

import pytest

from iwis.core.exr import read_exr_layers
from support import bad_scenes as bad

SECONDS = 280  # the first render on a machine compiles the kernels
BATCH = """
import contextlib, io, json, sys
from iwis.iwis_addon import cli
results = {}
for name, arguments in json.loads(sys.argv[1]).items():
    stderr = io.StringIO()
    with contextlib.redirect_stderr(stderr):
        try:
            code = cli.main(arguments)
        except SystemExit as error:
            code = error.code
    results[name] = code, stderr.getvalue()
open(sys.argv[2], "w").write(json.dumps(results))
"""

# Name -> change of the scene, output in the test's folder, further arguments,
# exit code, words of the only line on stderr that is not argparse's usage.
COMMANDS = {
    "hdri missing": (bad.hdri_missing, "a.exr", (), 0, ("Sky", "gone.hdr", "Pink")),
    "hdri with nan": (bad.hdri_with_nan, "a.png", (), 0, ("Sky", "1 of 128 texels are NaN")),
    "no world": (bad.no_world, "a.exr", (), 0, ("no world", "add one")),
    "no camera": (bad.no_camera, "a.exr", (), 1, ("no camera", "add one")),
    "no objects": (bad.no_objects, "a.exr", (), 0, ()),
    "no view layer": (bad.no_view_layer, "a.exr", (), 1, ("no view layer is on",)),
    "empty border": (bad.empty_border, "a.exr", (), 1, ("the render border holds no pixel",)),
    "damaged mesh": (bad.damaged_mesh, "a.exr", (), 1, ("Mesh Damaged", "validate()")),
    "new folder": (None, "new/folder/a.exr", (), 0, ()),
    "output is a folder": (None, "folder.exr", (), 1, ("folder.exr: is a folder",)),
    "output in a file": (None, "file/a.exr", (), 1, ("is a file, not a folder",)),
    "no room, EXR": (None, "full.exr", (), 1, ("full.exr", "is cut short: the disk is full")),
    "no room, PNG": (None, "full.png", (), 1, ("full.png", "is cut short: the disk is full")),
    "no room, figures": (None, "a.exr", ("--stats", "/dev/full"), 1, ("No space left",)),
    "cache folder": (
        None,
        "a.exr",
        ("--set", "estimator=paper", "--set", "coefficients=.01", "--set", "cache_dir=/proc/x"),
        0,
        ("cache folder /proc/x/tables", "Choose another"),
    ),
    "threads": (None, "a.exr", ("--set", "threads=1000000"), 2, ("threads", "0 ... 1024")),
    "samples": (None, "a.exr", ("--set", "max_samples=many"), 2, ("max_samples", "whole number")),
    "error": (None, "a.exr", ("--set", "error_threshold=-1"), 2, ("error_threshold", "outside")),
    "estimator": (None, "a.exr", ("--set", "estimator=best"), 2, ("none of PAPER, UNBIASED",)),
    "no setting": (None, "a.exr", ("--set", "E=0"), 2, ("no setting 'E'", "error_threshold")),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bad")
    (folder / "folder.exr").mkdir()
    (folder / "file").touch()
    for suffix in ("exr", "png"):
        (folder / f"full.{suffix}").symlink_to("/dev/full")
    return folder


@pytest.fixture(scope="module")
def results(folder):
    """Name -> (exit code, stderr, the output's path) of all commands."""
    commands = {}
    for number, (name, (change, output, arguments, *_)) in enumerate(COMMANDS.items()):
        if "/" not in output and output.startswith("a."):
            output = f"{number}{output}"
        blend = bad.save_cube_scene(folder / f"{number}.blend", change)
        commands[name] = ["render", str(blend), "-o", str(folder / output), *arguments]
    answer = folder / "answer.json"
    batch = subprocess.run(
        [sys.executable, "-c", BATCH, json.dumps(commands), str(answer)],
        capture_output=True,
        text=True,
        timeout=SECONDS,
        check=False,
    )
    assert batch.returncode == 0, batch
    results = json.loads(answer.read_text())
    return {name: (*results[name], commands[name][3]) for name in commands}


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_command_says_what_is_wrong(results, name):
    """The exit code, one line that says what, where and what to do, and a picture or none."""
    *_, expected, words = COMMANDS[name]
    code, stderr, output = results[name]
    assert code == expected, stderr
    lines = [line for line in stderr.splitlines() if "iwis" in line.lower() and "usage" not in line]
    assert len(lines) == bool(words), stderr
    assert all(word in lines[0] for word in words), stderr
    assert "Traceback" not in stderr
    if code == 0:
        assert os.path.getsize(output) > 0
    elif name != "no room, figures":
        assert not os.path.isfile(output)


INTERRUPT = """
import os, signal, sys, threading, time
from iwis.iwis_addon import cli

where, number, struck = sys.argv[1], int(sys.argv[2]), []

def strike(reached):
    if reached == where and not struck:  # a second signal would end the process at once
        struck.append(True)
        # What compiles for the first time is not waited for at the end.
        threading.Thread(target=time.sleep, args=(1000.0,), name="iwis-early").start()
        os.kill(os.getpid(), number)

class Importing:
    def find_spec(self, name, path=None, target=None):
        if name == "bpy":
            sys.meta_path.remove(self)
            strike("loading")

sys.meta_path.insert(0, Importing())
if where != "loading":
    import iwis.iwis_addon.session as session
    import iwis.iwis_addon.sink as sink
    real_export, real_progress = session.export_scene, sink.BlenderSink.progress

    def export_scene(*arguments, **options):
        strike("export")
        return real_export(*arguments, **options)

    def progress(self, progress):
        if progress.phase != "sampling" or progress.tiles_done == 2:
            strike(progress.phase)
        real_progress(self, progress)

    session.export_scene, sink.BlenderSink.progress = export_scene, progress
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
sys.exit(cli.main(sys.argv[3:]))
"""


def interrupted(folder, where, number, *arguments, lines=1):
    """Render 256 x 256 pixels of 4096 samples (a minute or two), struck when a phase begins.

    lines: of stderr that are expected
    """
    blend = bad.save_cube_scene(folder / "cube.blend", None)
    settings = ("stop_rule=fixed", "max_samples=4096", "tile_px=8", "threads=1")
    done = subprocess.run(
        [
            *(sys.executable, "-c", INTERRUPT, where, str(int(number)), "render", str(blend)),
            *("-o", str(folder / "out_#.exr"), "--resolution", "256x256"),
            *(part for setting in settings for part in ("--set", setting)),
            *arguments,
        ],
        capture_output=True,
        text=True,
        timeout=SECONDS,
        check=False,
    )
    assert done.returncode == 1, done
    assert len(done.stderr.splitlines()) == lines, done.stderr
    return done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    ("where", "number"),
    [
        ("loading", signal.SIGINT),
        ("export", signal.SIGINT),
        ("bvh", signal.SIGTERM),
        ("tables", signal.SIGINT),
    ],
)
def test_interrupt_before_the_first_tile_saves_nothing(tmp_path, where, number):
    """Whatever is going on, even while modules are loaded: exit code 1 and one line."""
    assert "interrupted" in interrupted(tmp_path, where, number)
    assert not list(tmp_path.glob("*.exr"))


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupt_keeps_what_is_done(tmp_path, number):
    """The picture has the tiles that were done: some, not all."""
    assert "holds what was done" in interrupted(tmp_path, "sampling", number)
    samples = read_exr_layers(tmp_path / "out_1.exr")["ViewLayer.IWIS Samples"]
    assert 0.0 < (samples > 0.0).mean() < 0.5


@pytest.mark.slow
def test_interrupt_while_denoising_keeps_the_noisy_picture(tmp_path):
    """All of it, with a warning; the process waits for the library, and ends as it should."""
    few = ("--set", "max_samples=4", "--set", "denoise=true")
    stderr = interrupted(tmp_path, "denoising", signal.SIGINT, *few, lines=2)
    assert "keeps its noise" in stderr and "holds what was done" in stderr
    layers = read_exr_layers(tmp_path / "out_1.exr")
    combined = layers["ViewLayer.Combined"]
    assert (combined == layers["ViewLayer.Noisy Image"]).all() and combined[..., 3].all()


@pytest.mark.slow
@pytest.mark.parametrize("last", ["1", "3"])
def test_interrupt_ends_an_animation(tmp_path, last):
    """The frame at work keeps its tiles, under a name that no frame has which is done; the next one
    is not begun."""
    stderr = interrupted(tmp_path, "sampling", signal.SIGTERM, "-s", "1", "-e", last)
    assert "what was done of frame 1 by then is in" in stderr and "out_1-partial.exr" in stderr
    assert [path.name for path in tmp_path.glob("*.exr")] == ["out_1-partial.exr"]
    samples = read_exr_layers(tmp_path / "out_1-partial.exr")["ViewLayer.IWIS Samples"]
    assert 0.0 < (samples > 0.0).mean() < 0.5


@pytest.mark.slow
def test_second_interrupt_ends_the_process():
    """Who is in a hurry need not wait: the default of the signal is back."""
    script = (
        "import os, signal\n"
        "from iwis.iwis_addon.interrupts import interrupts\n"
        "with interrupts() as interrupted:\n"
        "    os.kill(os.getpid(), signal.SIGTERM)\n"
        "    assert interrupted.is_set()\n"
        "    os.kill(os.getpid(), signal.SIGTERM)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], timeout=SECONDS, check=False)
    assert done.returncode == -signal.SIGTERM


def test_ignored_signals_stay_ignored():
    """As a shell's background jobs ignore Ctrl-C; and afterwards all is as it was."""
    from iwis.iwis_addon.interrupts import interrupts

    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interrupts() as interrupted:
            signal.raise_signal(signal.SIGINT)
            assert not interrupted.is_set()
            assert signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    finally:
        signal.signal(signal.SIGINT, before)
