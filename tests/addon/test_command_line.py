"""python -m iwis, each time in a process of its own: exit codes, files, figures."""

import json
import os
import subprocess
import sys

import bpy
import pytest

from iwis.core.exr import read_exr_layers
from iwis.core.settings import RenderSettings
from iwis.iwis_addon import cli

SECONDS = 280  # the first render on a machine compiles the kernels


def iwis(*arguments, **environment):
    """Run the command; its exit code, stdout and stderr."""
    return subprocess.run(
        [sys.executable, "-m", "iwis", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=SECONDS,
        check=False,
        env={**os.environ, **environment},
    )


@pytest.fixture
def blend(cube_scene, tmp_path):
    """The cube as a file, set to another engine: the command line chooses IWIS itself."""
    cube_scene.render.engine = "BLENDER_WORKBENCH"
    path = tmp_path / "cube.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def assert_fails(done, word):
    """Exit code 1, and one line on stderr that says what is wrong."""
    assert done.returncode == 1, done
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("iwis: error: ") and word in lines[0]


def test_help_and_version_need_no_blender():
    """They answer at once and name every setting."""
    done = iwis("render", "--help")
    assert done.returncode == 0
    assert all(name in done.stdout for name in RenderSettings.__dataclass_fields__)
    assert "denoise_quality" in done.stdout
    assert iwis("--help").returncode == 0
    assert iwis("--version").stdout.startswith("iwis ")


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("render",),
        ("render", "a.blend"),
        ("render", "a.blend", "-o", "a.tga"),
        ("render", "a.blend", "-o", "a.exr", "--set", "sed=3"),
        ("render", "a.blend", "-o", "a.exr", "--set", "seed"),
        ("render", "a.blend", "-o", "a.exr", "--set", "threads=1000000"),
        ("render", "a.blend", "-o", "a.exr", "--set", "error_threshold=nan"),
        ("render", "a.blend", "-o", "a.exr", "--resolution", "0x5"),
        ("render", "a.blend", "-o", "a.exr", "-s", "1"),
        ("render", "a.blend", "-o", "a.exr", "-s", "3", "-e", "1"),
        ("render", "a.blend", "-o", "a.exr", "-f", "1", "-s", "1", "-e", "2"),
    ],
)
def test_wrong_usage_exits_with_2(arguments, capsys):
    """argparse says what is wrong; nothing is opened."""
    with pytest.raises(SystemExit) as caught:
        cli.main(list(arguments))
    assert caught.value.code == 2
    assert "error: " in capsys.readouterr().err


@pytest.mark.slow
def test_one_frame_with_figures(blend, tmp_path):
    """The EXR has the passes, STATS.json what is documented, stdout says what was rendered."""
    out, stats = tmp_path / "a_{b}_##.exr", tmp_path / "new" / "stats.json"
    options = ["--resolution", "20x16"]
    for setting in ("max_samples=6", "stop_rule=fixed", "pixel_filter=center"):
        options += ["--set", setting]
    done = iwis("render", blend, "-o", out, "-f", 3, "--stats", stats, *options)
    assert done.returncode == 0, done
    layers = read_exr_layers(tmp_path / "a_{b}_03.exr")
    assert layers["ViewLayer.Combined"].shape == (16, 20, 4)
    figures = json.loads(stats.read_text())
    assert (figures["width"], figures["height"]) == (20, 16)
    hits = (layers["ViewLayer.IWIS Samples"] > 0).sum()
    assert figures["samples"] == {"total": 6 * hits, "mean": 6.0, "max": 6}
    assert figures["shaded_pixels"] == hits and figures["primary_rays"] == 20 * 16
    phases = {"export", "tables", "bvh", "sampling", "denoising", "output"}
    assert set(figures["seconds"]) == set(figures["cpu_seconds"]) == phases
    assert figures["peak_memory_bytes"] > 1e7 and not figures["cancelled"]
    assert "frame 3: 20x16, 6.0 samples a pixel (at most 6)" in done.stdout


@pytest.mark.slow
def test_several_frames(blend, tmp_path):
    """Without # in the name the frames get four digits; the figures are a list."""
    stats = tmp_path / "stats.json"
    done = iwis("render", blend, "-o", tmp_path / "b.png", "-s", 4, "-e", 5, "--stats", stats)
    assert done.returncode == 0, done
    assert (tmp_path / "b0004.png").exists() and (tmp_path / "b0005.png").exists()
    assert [frame["frame"] for frame in json.loads(stats.read_text())["frames"]] == [4, 5]


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["exr", "png"])
def test_no_camera(cube_scene, tmp_path, suffix):
    """Nothing is saved and one line says why."""
    bpy.data.objects.remove(cube_scene.camera)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "c.blend"))
    out = tmp_path / f"c.{suffix}"
    assert_fails(iwis("render", tmp_path / "c.blend", "-o", out), "camera")
    assert not out.exists()


def test_file_that_is_not_there_or_no_blend(tmp_path):
    """Both are named."""
    out = tmp_path / "a.exr"
    assert_fails(
        iwis("render", tmp_path / "no.blend", "-o", out), "no.blend: there is no such file"
    )
    broken = tmp_path / "broken.blend"
    broken.write_text("not a blend")
    assert_fails(iwis("render", broken, "-o", out), "broken.blend: cannot be opened")


def test_output_that_cannot_be_written(blend, tmp_path):
    """It is found out before the render."""
    (tmp_path / "file").write_text("")
    done = iwis("render", blend, "-o", tmp_path / "file" / "a.exr")
    assert_fails(done, "cannot be written")
