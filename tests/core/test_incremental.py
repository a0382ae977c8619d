"""core/sampling/incremental.py: the paper's loop stops when it should and counts what it saw."""

import numpy as np
import pytest

from iwis.core.sampling.incremental import sample_points
from iwis.core.sampling.stop_rule import relative_error
from iwis.core.settings import RenderSettings
from support.scenes import make_picture, varied_scene


class ScriptedLight:
    """Sampler and Accel of points whose samples' visibility and light are written down.

    seen: bool (n_points, n_samples); light: float (n_points, n_samples), of each sample
    left_out: bool, likewise: samples that carry nothing and get no ray
    """

    def __init__(self, seen, light=None, left_out=None):
        self.seen = np.asarray(seen)
        self.light = np.ones(self.seen.shape) if light is None else light
        self.left_out = np.zeros_like(self.seen) if left_out is None else left_out
        self.calls = []

    def lit(self):
        return np.ones(len(self.seen), np.bool_)

    def unoccluded(self):
        return None

    def sample(self, active, first, counts, rays):
        self.calls.append((active.copy(), first, counts.max()))
        n = 0
        for p, count in zip(active, counts, strict=True):
            for k in range(first, first + count):
                if not self.left_out[p, k]:
                    rays.point[n] = p
                    rays.origins[n] = (p, k, 0)
                    rays.diffuse[n], rays.glossy[n] = 0.75 * self.light[p, k], 0.25
                    rays.glossy[n] *= self.light[p, k]
                    n += 1
        return n

    def occluded(self, origins, directions):
        return ~self.seen[origins[:, 0].astype(int), origins[:, 1].astype(int)]


def _run(script, **settings):
    defaults = {"max_samples": script.seen.shape[1], "stop_rule": "FIXED"}
    settings = RenderSettings(**(defaults | settings))
    return sample_points(script, len(script.seen), script, settings)


def _equation_7(seen):
    """e_d of raw visibilities, as printed; infinite while nothing is seen."""
    v = np.asarray(seen, np.float64)
    with np.errstate(divide="ignore"):
        return np.sqrt(((v - v.mean()) ** 2).sum() / v.sum() ** 2) if v.any() else np.inf


def test_error_equals_equation_7(rng):
    """With constant light, for 1 to 24 samples of every visibility."""
    for n in (1, 7, 24):
        seen = rng.random((60, n)) < rng.random((60, 1))
        for batch_size in (1, 5, 24):
            sums, _ = _run(ScriptedLight(seen, np.full(seen.shape, 3.7)), batch_size=batch_size)
            expected = [_equation_7(row) for row in seen]
            # float64 sums of equal squares cancel to 1e-16 where all is seen: its root is 1e-8
            np.testing.assert_allclose(sums.error, expected, rtol=1e-6, atol=1e-7)


def test_error_is_infinite_while_nothing_is_seen():
    """Not 0, not NaN: such a pixel goes on to MAX."""
    sums, _ = _run(ScriptedLight(np.zeros((1, 16), bool)), stop_rule="PAPER", batch_size=4)
    assert np.isinf(sums.error[0]) and sums.count[0] == 16
    assert relative_error(8, 0.0, 0.0) == np.inf


def test_error_of_unequal_samples_is_its_generalisation(rng):
    """sum (f - mean f)^2 / (sum f)^2 with f the light that was seen, left-out samples as 0."""
    seen, light = rng.random((40, 20)) < 0.6, rng.random((40, 20))
    left_out = rng.random((40, 20)) < 0.2
    sums, traced = _run(ScriptedLight(seen, light, left_out))
    f = np.where(seen & ~left_out, light, 0.0)
    expected = np.sqrt(((f - f.mean(1, keepdims=True)) ** 2).sum(1)) / f.sum(1)
    np.testing.assert_allclose(sums.error, expected, rtol=1e-6)  # float32 light
    assert traced == (~left_out).sum()


def test_sums_are_what_was_seen(rng):
    """N, K, and the light by lobe, seen and not."""
    seen, light = rng.random((30, 12)) < 0.5, rng.random((30, 12))
    sums, _ = _run(ScriptedLight(seen, light), batch_size=5)
    assert (sums.count == 12).all()
    np.testing.assert_array_equal(sums.visible, seen.sum(1))
    total = np.where(seen, light, 0.0).sum(1)
    for values, expected in (
        (sums.diffuse, 0.75 * total),
        (sums.glossy, 0.25 * total),
        (sums.unoccluded, light.sum(1)),
    ):
        np.testing.assert_allclose(values, np.repeat(expected[:, None], 3, 1), rtol=1e-6)  # float32


@pytest.mark.parametrize("batch_size", [1, 4, 8, 30])
@pytest.mark.parametrize("threshold", [0.05, 0.1, 0.3])
def test_pixels_stop_at_the_first_round_whose_error_is_small_enough(batch_size, threshold, rng):
    """Counts are a multiple of n, or MAX (30, not a multiple of 4 or 8), as in algorithm 1."""
    seen = rng.random((200, 30)) < rng.random((200, 1))
    script = ScriptedLight(seen)
    sums, _ = _run(script, stop_rule="PAPER", batch_size=batch_size, error_threshold=threshold)
    for row, count in zip(seen, sums.count, strict=True):
        ends = [*range(batch_size, 30, batch_size), 30]
        stops = [n for n in ends if _equation_7(row[:n]) <= threshold]
        assert count == (stops[0] if stops else 30)


def test_samples_are_never_taken_twice(rng):
    """Rounds follow each other; a pixel that has stopped does not come back."""
    script = ScriptedLight(rng.random((50, 30)) < rng.random((50, 1)))
    _run(script, stop_rule="PAPER", batch_size=8)
    assert [(first, count) for _, first, count in script.calls] == [
        (0, 8),
        (8, 8),
        (16, 8),
        (24, 6),
    ]
    for (before, _, _), (after, _, _) in zip(script.calls, script.calls[1:], strict=False):
        assert set(after) <= set(before)
    assert len(script.calls[0][0]) == 50 > len(script.calls[-1][0]) > 0


def test_max_below_n_is_one_short_round():
    """MAX = 3, n = 8: three samples."""
    script = ScriptedLight(np.ones((2, 3), bool))
    sums, traced = _run(script, batch_size=8, stop_rule="PAPER")
    assert sums.count.tolist() == [3, 3] and traced == 6


def test_a_threshold_of_zero_never_stops_before_max():
    """Not even a pixel that has seen all of its samples."""
    sums, _ = _run(ScriptedLight(np.ones((1, 30), bool)), stop_rule="PAPER", error_threshold=0.0)
    assert sums.count[0] == 30


def test_unlit_points_get_no_sample(rng):
    """Points that no light can reach stay at zero, without a ray."""

    class HalfDark(ScriptedLight):
        def lit(self):
            return np.array([True, False, True])

    script = HalfDark(np.ones((3, 8), bool))
    sums, traced = _run(script)
    assert sums.count.tolist() == [8, 0, 8] and traced == 16
    assert not sums.diffuse[1].any() and np.isinf(sums.error[1])


def test_known_unoccluded_light_replaces_the_samples():
    """I_s of the tables, times N, so that the mean is I_s."""

    class Known(ScriptedLight):
        def unoccluded(self):
            return np.float32([[1.0, 2.0, 3.0]])

    sums, _ = _run(Known(np.ones((1, 8), bool)))
    np.testing.assert_array_equal(sums.unoccluded / sums.count[:, None], [[1.0, 2.0, 3.0]])


def test_cancel_keeps_what_is_there():
    """Asked before each round; sums are those of the rounds that were done."""
    answers = iter([False, False, True])
    script = ScriptedLight(np.tile(np.arange(64) % 2 == 0, (2, 1)))
    settings = RenderSettings(max_samples=64, batch_size=8, stop_rule="PAPER", error_threshold=1e-3)
    sums, traced = sample_points(script, 2, script, settings, lambda: next(answers))
    assert sums.count.tolist() == [16, 16] and traced == 32
    assert sums.visible.tolist() == [8, 8]


def test_cancel_is_seen_between_the_batches_of_a_round():
    """A fixed count is one round: it does not keep anybody waiting."""
    answers = iter([False, True, True])
    script = ScriptedLight(np.ones((20, 1000), bool))
    settings = RenderSettings(max_samples=1000, stop_rule="FIXED")
    sums, traced = sample_points(script, 20, script, settings, lambda: next(answers))
    assert sums.count.tolist() == [1000] * 8 + [0] * 12 and traced == 8000


@pytest.mark.parametrize("estimator", ["UNBIASED", "PAPER"])
def test_three_rounds_of_8_equal_one_of_24(estimator, table_dir):
    """Bit for bit, in every layer of a picture with five materials and shadows."""
    scene = varied_scene()
    settings = {"estimator": estimator, "stop_rule": "FIXED", "max_samples": 24}
    one, _ = make_picture(scene, batch_size=24, cache_dir=table_dir, **settings)
    for batch_size in (8, 7):
        many, _ = make_picture(scene, batch_size=batch_size, cache_dir=table_dir, **settings)
        for name, layer in one.items():
            np.testing.assert_array_equal(many[name], layer, err_msg=name)


@pytest.mark.parametrize("estimator", ["UNBIASED", "PAPER"])
@pytest.mark.parametrize("stop_rule", ["PERCEPTUAL", "PAPER"])
def test_pictures_obey_the_rule(stop_rule, estimator, table_dir):
    """In the layers: counts at which a pixel may end, or MAX; more where half is hidden. PAPER:
    error <= E, or MAX."""
    settings = {"error_threshold": 0.1, "max_samples": 60, "batch_size": 8, "stop_rule": stop_rule}
    layers, stats = make_picture(
        varied_scene(), estimator=estimator, cache_dir=table_dir, **settings
    )
    samples, error = layers["samples"][..., 0], layers["error"][..., 0]
    shaded = samples > 0
    stopped = shaded & (samples < 60)
    assert stopped.any() and (samples == 60).any()
    if stop_rule == "PAPER":
        assert (error[stopped] <= 0.1).all() and (samples[stopped] % 8 == 0).all()
    else:
        assert set(np.unique(samples[stopped])) <= {8, 12, 16, 24, 32, 48}
        assert (error[shaded] > 0.0).all()
    np.testing.assert_array_equal(layers["sample_count"][..., 0], samples / np.float32(60))
    visibility = layers["visibility"][..., 0]
    assert (
        samples[shaded & (visibility < 0.5)].mean() > samples[shaded & (visibility > 0.95)].mean()
    )
    assert stats.samples_total == samples.sum() and stats.samples_max == samples.max() == 60
