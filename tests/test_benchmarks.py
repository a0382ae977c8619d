"""benchmarks/: the errors it computes, what it concludes from curves, its harness in small."""

import dataclasses
import json
import math

import ball
import bench_scaling
import numpy as np
import part_rays
import pytest
import report
import tables
from configurations import CONFIGURATIONS, CYCLES, FIXED, QUICK, base_settings
from converged import converge, kept, key_of, own_noise
from metrics import cost_at, cost_beyond, error_at, errors, measured_pixels
from pictures import save_jpeg
from run_core import METHODS, CoreRun
from run_iwis import IwisRun
from run_mitsuba import describe, square_count

ALL = np.ones((20, 20), bool)


@pytest.fixture(scope="module")
def run():
    """Renders of a small ball."""
    scene = ball.scene(ball.ball(2000), ball.environment(512), 24)
    return IwisRun(scene, base_settings(threads=1))


def _grey(values):
    return np.repeat(np.asarray(values, np.float64)[..., None], 3, axis=-1)


def test_errors_of_a_picture_that_is_a_tenth_too_bright():
    """Every error is known where each pixel is 1.1 times its reference."""
    reference = _grey(np.full((20, 20), 2.0))
    found = errors(1.1 * reference, reference, ALL)
    assert found.mre == pytest.approx(0.1)
    assert found.p99 == pytest.approx(0.1)
    assert found.bias == pytest.approx(0.1)
    assert found.relmse == pytest.approx(0.2**2 / (2.0**2 + 0.01 * 2.0**2))


def test_black_pixels_and_the_background_are_not_measured():
    """A reference below .1 % of the mean of the object's pixels is left out."""
    values = np.full((20, 20), 1.0)
    values[0], values[1, 0] = 0.0, 5e-4
    mask = ALL.copy()
    mask[5] = False
    assert measured_pixels(_grey(values), mask).sum() == 400 - 20 - 1 - 20


def test_costs_are_read_from_straight_lines_in_log_log():
    """On error = cost^-1/2 every cost is known, between points and beyond them."""
    costs = [1.0, 4.0, 16.0]
    found = [cost**-0.5 for cost in costs]
    assert cost_at(0.4, costs, found) == pytest.approx(0.4**-2)
    assert cost_at(0.1, costs, found) is None
    assert cost_beyond(0.2, costs, found) == pytest.approx(25.0)
    assert cost_beyond(0.01, costs, found) is None  # 625 times the last: too far
    assert error_at(9.0, costs, found) == pytest.approx(1.0 / 3.0)
    assert error_at(100.0, costs, found) is None


def test_noise_of_a_reference_is_that_of_its_mean(rng):
    """Two halves with independent normal errors: their mean's error is known."""
    sigma, shape = 0.02, (300, 300)
    halves = [_grey(1.0 + sigma * rng.standard_normal(shape)) for _ in range(2)]
    wanted = sigma / math.sqrt(2.0) * math.sqrt(2.0 / math.pi)
    # 90 000 pixels: a relative standard error of .25 %
    assert own_noise(*halves, np.ones(shape, bool)) == pytest.approx(wanted, rel=0.01)


def test_reference_is_made_until_it_is_good_and_then_kept(tmp_path, rng):
    """More pictures are added until the noise is small; a second call makes none."""
    calls = []

    def render(samples, seed):
        calls.append(seed)
        return _grey(1.0 + 0.1 * rng.standard_normal((20, 20))), samples, 0.0

    def make():
        return converge(render, ALL, QUICK, 1.0, "abc")

    path = tmp_path / "references" / "one.npz"
    first = kept(path, make)
    assert first.noise <= QUICK.reference_noise
    assert len(calls) == len(set(calls)) > 2
    assert first.samples == len(calls) * QUICK.reference_samples
    made = len(calls)
    again = kept(path, make)
    assert len(calls) == made
    assert again.commit == "abc"
    np.testing.assert_array_equal(again.mean, first.mean)


def test_key_of_a_reference_changes_with_the_light(run):
    """Another HDRI, another reference."""
    other = dataclasses.replace(run.scene, environment=ball.environment(512, seed=1))
    assert key_of(run.scene, QUICK) == key_of(dataclasses.replace(run.scene), QUICK)
    assert key_of(run.scene, QUICK) != key_of(other, QUICK)


def test_ball_is_closed_and_its_normals_point_out():
    """Every triangle and every normal looks away from the centre."""
    mesh = ball.ball(10_000)
    assert abs(len(mesh.triangles) / 10_000 - 1.0) < 0.05
    corners = mesh.vertices[mesh.triangles]
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((face * corners.mean(axis=1)).sum(axis=-1) > 0.0).all()
    assert ((mesh.corner_normals * corners).sum(axis=-1) > 0.0).all()


@pytest.mark.slow
def test_every_estimator_of_the_core_makes_the_same_picture(run):
    """Light, BSDF and MIS sampling and WIS agree with the product within 2 % of the mean.

    WIS is allowed 5 %: it keeps 5 % of the coefficients.
    """
    film, _ = run.render(stop_rule="FIXED", max_samples=256)
    wanted = film.layers["combined"][..., :3]
    hit = film.layers["depth"][..., 0] < 1e9
    core = CoreRun(run.scene, run.cache, threads=1)
    for method in METHODS:
        found = errors(core.render(method, 256).rgb, wanted, hit)
        assert abs(found.bias) < (0.05 if method == "wis" else 0.02), method


def test_recorded_rays_are_those_of_the_render(run):
    """Every shadow ray of a render is recorded, in a form that embreex takes."""
    recorder = part_rays.record(run, stop_rule="FIXED", max_samples=8)
    with part_rays.without_guides():
        _, stats = run.render(stop_rule="FIXED", max_samples=8)
    assert sum(len(batch.origins) for batch in recorder.shadow) == stats.shadow_rays
    assert all(batch.directions.dtype == np.float32 for batch in recorder.shadow)
    lengths = np.concatenate([np.linalg.norm(b.directions, axis=1) for b in recorder.shadow])
    np.testing.assert_allclose(lengths, 1.0, atol=1e-5)  # float32


def test_mitsuba_gets_shared_normals_of_smooth_meshes_and_none_of_flat_ones(run):
    """A smooth mesh keeps its vertices; a flat one has no normals; the size is the camera's."""
    smooth = describe(run.scene)
    assert len(smooth["vertices0"]) == len(run.scene.mesh.vertices) == len(smooth["normals0"])
    mesh = run.scene.mesh
    flat = np.ascontiguousarray(np.repeat(mesh.corner_normals[:, :1], 3, axis=1))
    changed = dataclasses.replace(run.scene, mesh=dataclasses.replace(mesh, corner_normals=flat))
    assert "normals0" not in describe(changed)
    assert json.loads(smooth["bsdf0"])["bsdf"]["type"] == "diffuse"
    assert smooth["size"].tolist() == [24, 24]


def test_counts_of_mitsuba_are_squares_near_what_is_wanted():
    """4, 9, 16, 36, 64 ...: full grids of strata."""
    assert [square_count(n) for n in (4, 8, 16, 32, 64, 128, 1000)] == [
        4,
        9,
        16,
        36,
        64,
        144,
        1024,
    ]


def _points(name, factor):
    """A curve of error = factor / sqrt(cpu), 4 to 256 samples of .01 s."""
    return [
        {
            "configuration": name,
            "value": float(n),
            "samples": float(n),
            "cpu": 0.01 * n,
            "mre": math.hypot(factor / math.sqrt(n), 0.01),  # with the reference's noise
            "relmse": 0.0,
            "p99": 5.0 * factor / math.sqrt(n),
            "bias": 0.0,
            "penumbra_bias": 0.0,
        }
        for n in (4, 16, 64, 256)
    ]


@pytest.fixture
def scene_result():
    """What part_error.py writes, made up: Cycles needs nine times the samples of IWIS."""
    return {
        "width": 20,
        "height": 20,
        "triangles": 1000,
        "object_pixels": 300,
        "edge_pixels": 3,
        "measured_pixels": 297,
        "reference": {"noise": 0.01, "samples": 1024, "cpu": 1.0, "commit": "abc"},
        "load": 0.0,
        "seconds": 1.0,
        "points": _points(FIXED, 0.4) + _points(CYCLES, 1.2),
    }


def test_ratios_of_the_table_are_those_of_the_curves(scene_result):
    """At .1 both are inside their curves: nine; .015 is less than twice the noise."""
    found = tables.curves(scene_result)
    assert found[FIXED].cost(0.1)[0] == pytest.approx(0.16)
    assert found[CYCLES].cost(0.1)[0] == pytest.approx(1.44)
    assert found[FIXED].cost(0.015) == (None, "noise")
    assert tables.common_error(found) == 0.1
    row = next(line for line in tables.cost_table(scene_result) if line.startswith(f"| {FIXED}"))
    assert "| 0.16 | 9.0 |" in row
    assert found[FIXED].value_for(0.64) == pytest.approx(64.0)
    assert found[FIXED].value_for(5.12) == pytest.approx(512.0)


@pytest.mark.slow
def test_page_is_written_of_whatever_results_there_are(tmp_path, scene_result):
    """The page has a scene's table and picture, and no section without results."""
    folder, pictures = tmp_path / "results", tmp_path / "pictures"
    folder.mkdir()
    pictures.mkdir()
    (folder / "machine.json").write_text(json.dumps({"processor": "Abacus", "cores": 2}))
    (folder / "statue_diffuse.error.json").write_text(json.dumps(scene_result))
    report.write(folder, tmp_path / "page.md", pictures)
    page = (tmp_path / "page.md").read_text()
    assert "Abacus" in page
    assert "### Diffuse statue" in page
    assert "## Start-up" not in page
    assert (pictures / "bench_error.png").stat().st_size < 120_000


@pytest.mark.slow
def test_cases_of_scaling_answer_with_what_the_page_shows():
    """One tiny value of each case."""
    assert bench_scaling.of_pixels(16)["each"] > 0.0
    assert bench_scaling.of_samples(4)["cpu"] > 0.0
    found = bench_scaling.of_triangles(2000)
    assert found["table_bytes"] / found["triangles"] == pytest.approx(62.0, rel=0.05)
    assert bench_scaling.of_hdri(512)["image_bytes"] == 512 * 256 * 12


def test_jpegs_stay_small(tmp_path, rng):
    """Noise, which compresses worst, stays below the limit."""
    panel = rng.random((100, 100, 3))
    save_jpeg(tmp_path / "a.jpg", panel, panel, names=["a", "b"], height=100, most_bytes=20_000)
    assert 0 < (tmp_path / "a.jpg").stat().st_size <= 20_000


def test_names_of_configurations_are_their_own():
    """Curves are found by name."""
    names = [configuration.name for configuration in CONFIGURATIONS]
    assert len(set(names)) == len(names)
    assert CONFIGURATIONS[0].value(3) == 32


@pytest.mark.slow
def test_export_bench_sees_what_it_measures():
    """In small: the triangles asked for, a table a triangle, and figures for the next frame."""
    pytest.importorskip("bpy")
    import bench_export
    from apart import in_own_process

    found = {
        name: in_own_process(bench_export.__file__, name, 200)
        for name in ("moving_triangles", "instances")
    }
    assert found["moving_triangles"]["triangles"] == 212
    assert found["moving_triangles"]["next_wall"] > 0.0
    places = found["instances"]["objects"]
    assert found["instances"]["triangles"] == 12 * places
    # A triangle: 3 corners, 9 normals, 2 rows; 8 vertices for 12 triangles.
    assert found["instances"]["table_bytes"] == 12 * places * 56 + 8 * places * 12


def test_exports_are_told_where_they_were_run():
    """A line a scene, bytes a triangle and an instance; nothing where the part was not run."""
    from export_section import export_section

    row = {"objects": 10, "triangles": 120, "wall": 0.5, "cpu": 0.6, "next_wall": 0.25}
    names = ("triangles", "moving_triangles", "objects", "linked_objects")
    memory = {"table_bytes": 7680, "bvh_bytes": 7440, "bvh_peak_bytes": 12000}
    memory |= {"export_bytes": 7680 + 11000, "peak_bytes": 2e6}
    results = {"load": 1.0, **dict.fromkeys(names, row), "instances": {**row, **memory}}
    text = "\n".join(export_section({"export": results}, None, None))
    assert text.count("| 10 | 120 | 0.50 | 0.60 | 0.25 |") == 5
    assert "64 bytes a triangle for the table, 62 for the hierarchy (100 while" in text
    assert "1100 bytes an instance" in text
    assert export_section({}, None, None) == []
