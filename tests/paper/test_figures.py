"""The data of each figure, from a run of a few hundred pixels; no pixel of a plot is looked at."""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest

import iwis
from iwis.paper import inputs as paper_inputs
from iwis.paper import plots, report
from iwis.paper.claims import claims, numbers
from iwis.paper.figure1 import error_maps
from iwis.paper.figure4 import MAX, E, rays_from_scratch
from iwis.paper.figure5 import ADAPTIVE, IIS, OURS, Point, at_samples, part_rows
from iwis.paper.files import read_probe, smooth_mesh
from iwis.paper.inputs import Inputs, Pair
from iwis.paper.materials import fitted_material
from iwis.paper.metrics import light_of, mre
from iwis.paper.plan import SMALL
from iwis.paper.results import compute
from iwis.paper.runs import METHODS
from support.scenes import box, join_parts, sphere

pytestmark = pytest.mark.slow
TINY = SMALL._replace(size=(16, 24), truth=64, counts=(8, 32), coefficients=(0.05,))
TINY = TINY._replace(thresholds=(0.3, 0.1, 0.0))
SUNRISE = Path(iwis.__file__).parent / "sample_blends" / "hdri" / "sunrise.exr"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """One pair: a ball on a slab, of fitted rubber, at sunrise."""
    vertices, triangles = join_parts([sphere(rings=16), box((-1.2, -1.2, -2.0), (1.2, 1.2, -0.9))])[
        :2
    ]
    mesh = smooth_mesh(np.float64(vertices), np.int32(triangles))
    pair = Pair("blue-rubber", "sunrise", read_probe(SUNRISE), fitted_material("blue-rubber"))
    own = Inputs(mesh, (pair,), False, "a ball")
    return compute(own, TINY, cache_dir=str(tmp_path_factory.mktemp("tables")))


def test_error_maps_are_equations_5_to_7():
    """Against the sums over samples as the paper writes them."""
    v = np.repeat([1.0, 0.0], [13, 7])
    spread = ((v - v.mean()) ** 2).sum()
    e_d, sigma_d = error_maps(np.array([0.65]), np.array([3.0]), np.array([20.0]))
    assert e_d[0] == pytest.approx(np.sqrt(spread / v.sum() ** 2))
    assert sigma_d[0] == pytest.approx(np.sqrt(3.0**2 / 20 * spread / 20))
    assert sigma_d[0] / (3.0 * 0.65) == pytest.approx(e_d[0])


def test_figure_1(results):
    """Maps of the lit pixels alone; correlations are correlations; e_d is not e_i."""
    maps = results.maps_of_tables
    assert 20 < maps.mask.sum() < maps.mask.size
    for values in (maps.e_i, maps.e_d, maps.sigma_d):
        assert np.isfinite(values).all()
        assert (values[~maps.mask] == 0.0).all()
        assert values[maps.mask].max() > 0.0
    assert all(-1.0 <= c <= 1.0 for c in (*maps.by_e_d, *maps.by_sigma_d))
    assert maps.by_e_d[0] > 0.2  # 30 samples: e_d knows something


def test_figure_2(results):
    """Old points stay; warped points go where the product is."""
    points, warped = results.warping.points, results.warping.warped
    n = TINY.warped
    assert [len(p) for p in points] == [len(p) for p in warped] == [n, 2 * n, 3 * n]
    for rows in (points, warped):
        for first, later in itertools.pairwise(rows):
            np.testing.assert_array_equal(later[: len(first)], first)
            assert ((later >= 0.0) & (later <= 1.0)).all()
    cells = np.minimum((warped[2] * 64).astype(int), 63)
    density = results.warping.density
    assert density.mean() == pytest.approx(1.0)
    # Points as dense as the product see its mean weighted by itself, E[d^2]; even ones see 1.
    seen = density[cells[:, 1], cells[:, 0]]
    assert np.median(seen) > 1.0


def test_figure_3(results):
    """The samples shown are those that the picture was made of: as many, as many of them seen."""
    picture = results.rendered[0].picture
    for pixel in results.pixels:
        column, row = pixel.pixel
        assert len(pixel.seen) == len(pixel.warped) == picture.samples[row, column]
        seen = picture.visibility[row, column] * len(pixel.seen)
        assert pixel.seen.sum() == pytest.approx(seen, abs=1e-3)
    visible = [pixel.seen.mean() for pixel in results.pixels]
    assert visible[0] > visible[2]
    assert len(results.pixels[0].seen) <= len(results.pixels[2].seen)


def test_figure_4(results):
    """Pixels below MAX have met E; the table-limited reference is the nearer one."""
    one = results.rendered[0]
    samples, v = one.picture.samples, one.picture.visibility
    done = (samples > 0) & (samples < MAX)
    e_d, _ = error_maps(v[done], v[done], samples[done])
    assert done.any()
    assert (e_d <= E + 1e-5).all()  # visibility is float32
    assert (samples[done] % 8 == 0).all()
    assert samples.max() <= MAX
    assert one.mean == pytest.approx(samples.sum() / (samples > 0).sum(), rel=0.05)
    assert one.everywhere == pytest.approx(samples.mean())
    assert one.from_limited < one.from_true
    assert 0.0 < one.limited_from_true
    assert abs(one.bias) < 0.1


def test_rays_from_scratch():
    """Counted by hand: 8; 8 + 16; 8 + 12 for one cut short."""
    assert rays_from_scratch(np.array([0, 8, 16, 12]), 8).tolist() == [0, 8, 24, 20]


def test_figure_5(results):
    """All methods, in order; fixed ones have the counts asked for and get better with more."""
    curves = results.curves.curves
    assert {*METHODS, *IIS, ADAPTIVE, OURS} <= set(curves)
    for points in curves.values():
        means = [p.mean for p in points]
        assert means == sorted(means)
        assert all(np.isfinite(p).all() for p in points)
    for method in METHODS:
        assert [p.mean for p in curves[method]] == pytest.approx(TINY.counts, rel=0.02)
    # A sun in the sky is noise without bounds where the BRDF alone is followed.
    for method in ("light", "MIS", "two-stage"):
        first, last = curves[method]
        assert last.mre < first.mre
    assert curves["WIS"][1].from_limited < curves["WIS"][0].from_limited
    assert curves["IIS100"][-1].mean == pytest.approx(100, rel=0.02)
    assert curves["IIS200"][-1].mean == pytest.approx(200, rel=0.02)


def test_crops_are_of_both_methods_and_the_reference(results):
    """Their errors are those of their own pixels, at about the samples asked for."""
    crops = results.curves.crops
    assert [crop.name for crop in crops] == ["head", "feet"]
    for crop in crops:
        rows = part_rows(results.truth.lit)[crop.name]
        shape = crop.pictures["reference"].shape
        assert {picture.shape for picture in crop.pictures.values()} == {shape}
        assert crop.means["WIS"] == pytest.approx(20, rel=0.05)
        reference = crop.pictures["reference"]
        lit = light_of(reference) > 1e-3 * light_of(reference).max()
        assert mre(crop.pictures["IIS100"], reference, lit) < 0.5
        assert rows.stop > rows.start


def test_curves_are_read_between_their_points():
    """Log-log: a power law is read exactly; beyond the ends there is nothing."""
    points = [Point(n, 1.0 / n, 0.0, 0.0) for n in (8.0, 32.0)]
    assert at_samples(points, 16.0) == pytest.approx(1.0 / 16.0)
    assert np.isnan(at_samples(points, 33.0))


def test_report_has_all(results, tmp_path):
    """Every picture is there and named in the page, every number and claim is in both files."""
    paths = plots.draw_all(results, tmp_path)
    page = report.write(results, paths, tmp_path).read_text()
    data = json.loads((tmp_path / "paper.json").read_text())
    assert len(paths) == 7
    for path in paths.values():
        assert path.stat().st_size > 3000
        assert f"src='{path.name}'" in page
    assert len(data["numbers"]) == len(numbers(results)) == page.count("<tr><td>")
    assert len(data["claims"]) == len(claims(results)) == page.count("<h3>")
    assert "This is not the paper&#x27;s data" in page or "not the paper's data" in page
    assert data["rendered"][0]["mean"] == results.rendered[0].mean
    assert data["tables"][0]["coefficients"] == 0.05


def test_shipped_data_is_whole():
    """Three fits, three panoramas; what a fit reflects is no more than comes in."""
    for material, probe in zip(paper_inputs.MATERIALS, paper_inputs.STAND_INS, strict=True):
        fit = fitted_material(material).fit[0]
        assert (fit[:, :3] > 0.0).all()
        assert fit[:, :3].max() < 1.05
        assert (SUNRISE.parent / f"{probe}.exr").is_file()
