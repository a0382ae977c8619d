"""pass_samples.py: how the samples of a pass are shared among the closures of a point."""

import numpy as np
import pytest

from iwis.core.bsdf.lobe_setup import setup_lobes
from iwis.core.geometry.shading import ShadingPoints
from iwis.core.passes.pass_sums import new_pass_sums
from iwis.core.surfaces.seen_points import ClosureLayer, SeenPoints
from iwis.core.tiles import pass_samples
from iwis.core.tiles.pass_samples import PassSampler, shared_counts
from iwis.core.tiles.tile_job import Rect
from support.brdf_points import material
from support.scenes import camera_above, constant_world, diffuse, make_job, make_scene, quad

UP = np.float32([0.0, 0.0, 1.0])


def _layer(of, looks):
    """A layer of points seen from above, by what each looks like."""
    n = len(of)
    normal = np.tile(UP, (n, 1))
    rows = [material(1, **look) for look in looks]
    params = type(rows[0])(*(np.concatenate(column) for column in zip(*rows, strict=True)))
    lobes = setup_lobes(params, normal, normal, normal)
    points = ShadingPoints(*(np.zeros(n, np.int32) for _ in ShadingPoints._fields))
    return ClosureLayer(SeenPoints(points, lobes, np.zeros(n, np.int32)), np.asarray(of))


def _grey(albedo):
    return diffuse((albedo,) * 3)


def test_closures_share_as_they_reflect():
    """All of a lone closure's; else in proportion, one at the least, and never more in all."""
    under = _layer([0, 1, 2, 3], [_grey(0.5), _grey(0.6), _grey(0.9), _grey(0.5)])
    coat = _layer([1, 2, 3], [_grey(0.2), _grey(0.01), _grey(0.5)])
    first, second = shared_counts([under, coat], 8)
    assert first.tolist() == [8, 6, 7, 4] and second.tolist() == [2, 1, 4]


def test_every_closure_has_a_sample_even_where_there_are_too_few():
    """More closures than samples, and closures that reflect nothing."""
    layers = [_layer([0], [_grey(albedo)]) for albedo in (0.0, 0.5, 0.0)]
    assert [own.tolist() for own in shared_counts(layers, 2)] == [[1], [1], [1]]
    dark = [_layer([0], [_grey(0.0)]) for _ in range(2)]
    assert [own.tolist() for own in shared_counts(dark, 8)] == [[4], [4]]


@pytest.mark.parametrize("color", [np.nan, np.inf, -np.inf, -3.0])
def test_colors_that_are_no_colors_take_no_sample_from_others(color):
    """Counts stay counts: a NaN turned into a number would be a count of billions."""
    layers = [_layer([0], [_grey(0.5)]), _layer([0], [_grey(0.5)])]
    layers[1].seen.lobes.diffuse[:] = color
    first, second = shared_counts(layers, 8)
    assert first[0] >= 1 and second[0] >= 1 and first[0] + second[0] == 8


@pytest.mark.parametrize("most", [64, 44])
def test_samples_of_a_closure_follow_each_other_from_pass_to_pass(monkeypatch, most):
    """A closure that takes 2 of 8 samples takes numbers 0 and 1, then 2 and 3. With those of every
    eighth and ninth number, Sobol's points left half of the square empty for good."""
    plate = quad((-2.0, -2.0, 0.0), (4.0, 0.0, 0.0), (0.0, 4.0, 0.0))
    scene = make_scene([plate], [diffuse()], constant_world(), camera_above(8, 8))
    job = make_job(scene, pixel_filter="BOX", max_samples=most)
    taken = {"under": [], "coat": []}

    def note(job, seen, rect, sums, bounds, rule, guides, first):
        name = "under" if seen.lobes.diffuse[0, 0] > 0.3 else "coat"
        taken[name] += [*zip(first.tolist(), rule.plan.tolist(), strict=True)]
        return 0

    monkeypatch.setattr(pass_samples, "add_samples", note)
    sampler = PassSampler(job, Rect(0, 0, 8, 8), np.zeros(64, np.int32), new_pass_sums(64))
    layers = [_layer([0], [_grey(0.6)]), _layer([0], [_grey(0.2)])]
    passes = -(-most // 8)
    for number in range(passes):
        sampler._sample(job, layers, np.array([number]))
    for name, share in (("under", 6), ("coat", 2)):
        expected = [(number * share, (number + 1) * share) for number in range(passes)]
        if most % 8:  # the last pass has half of its samples
            expected[-1] = (expected[-1][0], expected[-1][0] + share // 2)
        assert taken[name] == expected
