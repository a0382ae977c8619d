"""core/stats.py: what a render cost."""

import json
import time

import pytest

from iwis.core.stats import PHASES, RenderStats, peak_memory_bytes


def test_phases_add_up(monkeypatch):
    """Wall and CPU seconds of all visits to a phase, each by its own clock."""
    wall, cpu = iter([10.0, 10.5, 20.0, 20.25]), iter([1.0, 1.125, 2.0, 2.125])
    monkeypatch.setattr(time, "perf_counter", lambda: next(wall))
    monkeypatch.setattr(time, "process_time", lambda: next(cpu))
    stats = RenderStats()
    for _ in range(2):
        with stats.phase("bvh"):
            pass
    assert (stats.seconds["bvh"], stats.cpu_seconds["bvh"]) == (0.75, 0.25)
    assert all(stats.seconds[name] == 0.0 for name in PHASES if name != "bvh")


def test_phase_is_counted_when_it_fails():
    """An exception passes through, and its time is not lost."""
    stats = RenderStats()
    with pytest.raises(KeyError), stats.phase("tables"):
        time.sleep(0.01)
        raise KeyError
    assert stats.seconds["tables"] >= 0.01


def test_unknown_phase_is_an_error():
    """A misspelt phase would vanish from the statistics."""
    with pytest.raises(KeyError), RenderStats().phase("sleeping"):
        pass


def test_mean_samples_are_over_shaded_pixels():
    """The world's pixels do not count; none shaded is 0, not an error."""
    assert RenderStats(width=10, height=10, shaded_pixels=4, samples_total=10).samples_mean == 2.5
    assert RenderStats().samples_mean == 0.0


def test_to_dict_is_json_with_the_documented_keys():
    """STATS.json as the command line's users read it."""
    stats = json.loads(json.dumps(RenderStats(warnings=["a"]).to_dict()))
    assert set(stats) == {
        "width",
        "height",
        "shaded_pixels",
        "triangles",
        "samples",
        "shadow_rays",
        "primary_rays",
        "seconds",
        "cpu_seconds",
        "peak_memory_bytes",
        "cancelled",
        "ended_by",
        "warnings",
        "tables",
    }
    assert set(stats["samples"]) == {"total", "mean", "max"}
    assert set(stats["seconds"]) == set(stats["cpu_seconds"]) == set(PHASES)


def test_peak_memory_grows_with_what_is_held():
    """At least the 64 MB that are written to here."""
    block = bytearray(b"\1") * (64 << 20)
    assert peak_memory_bytes() == 0 or peak_memory_bytes() >= len(block)
