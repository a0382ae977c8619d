"""core/settings.py: what is not allowed is refused by name; texts become settings."""

import dataclasses
import math

import pytest

from iwis.core.settings import (
    CHOICES,
    DENOISE_CHOICES,
    LIMITS,
    DenoiseSettings,
    RenderSettings,
    settings_from_strings,
)


def test_defaults_are_those_documented():
    """E = .1 is the paper's; MAX is 256, for the paper's 100 cuts pixels that see little."""
    assert dataclasses.asdict(RenderSettings()) == {
        "error_threshold": 0.1,
        "max_samples": 256,
        "target_samples": 64,
        "time_limit": 0.0,
        "batch_size": 8,
        "estimator": "UNBIASED",
        "stop_rule": "PERCEPTUAL",
        "coefficients": 0.05,
        "pixel_filter": "BLACKMAN_HARRIS",
        "filter_width": 1.5,
        "transparent_max_bounces": 8,
        "decorrelation": "OWEN",
        "seed": 0,
        "threads": 0,
        "tile_px": 64,
        "cache_dir": "",
    }


@pytest.mark.parametrize("name", LIMITS)
def test_numbers_outside_their_limits_are_refused_by_name(name):
    """Just outside either end, NaN, infinity, a text, a truth value and nothing at all."""
    low, high = LIMITS[name]
    step = 1 if isinstance(low, int) else 1e-9
    for value in (low - step, high + max(step, high * 1e-9), math.nan, math.inf, "8", True, None):
        with pytest.raises(ValueError, match=f"setting {name}: "):
            RenderSettings(**{name: value})


@pytest.mark.parametrize("name", LIMITS)
def test_numbers_at_their_limits_are_taken(name):
    """Both ends belong to the range."""
    for value in LIMITS[name]:
        assert getattr(RenderSettings(**{name: value}), name) == value


def test_a_budget_needs_an_end():
    """A mean count or seconds: with neither it would be over before it began."""
    RenderSettings(stop_rule="BUDGET", target_samples=0, time_limit=0.5)
    with pytest.raises(ValueError, match="BUDGET needs target_samples or time_limit above 0"):
        RenderSettings(stop_rule="BUDGET", target_samples=0)


@pytest.mark.parametrize("name", [n for n, (low, _) in LIMITS.items() if isinstance(low, int)])
def test_whole_numbers_refuse_fractions(name):
    """8.5 samples, and 8.0 too: a float where a count belongs is a mistake."""
    with pytest.raises(ValueError, match=f"setting {name}: 8.0 is not a whole number"):
        RenderSettings(**{name: 8.0})


@pytest.mark.parametrize("name", CHOICES)
def test_unknown_choices_are_refused_with_those_there_are(name):
    """The message lists what could be chosen."""
    with pytest.raises(ValueError, match=f"setting {name}: 'HUGE' is none of {CHOICES[name][0]}"):
        RenderSettings(**{name: "HUGE"})


@pytest.mark.parametrize("name", DENOISE_CHOICES)
def test_unknown_choices_of_the_denoiser_are_refused(name):
    """As those of sampling."""
    with pytest.raises(ValueError, match=f"setting {name}: 'HUGE' is none of"):
        DenoiseSettings(**{name: "HUGE"})
    with pytest.raises(ValueError, match="setting denoise: 1 is neither True nor False"):
        DenoiseSettings(denoise=1)


def test_a_list_is_no_choice():
    """Something that cannot be hashed or compared is refused like the rest."""
    with pytest.raises(ValueError, match="setting estimator"):
        RenderSettings(estimator=["PAPER"])


def test_from_strings_reads_every_kind():
    """Whole numbers, numbers, choices in any case, paths as they are, yes and no."""
    settings, denoise = settings_from_strings(
        {
            "max_samples": "12",
            "error_threshold": "5e-2",
            "estimator": "paper",
            "cache_dir": "/Tmp/Mixed Case",
            "denoise": "true",
            "denoise_quality": "fast",
        }
    )
    assert denoise == DenoiseSettings(denoise=True, denoise_quality="FAST")
    assert settings == RenderSettings(
        max_samples=12, error_threshold=0.05, estimator="PAPER", cache_dir="/Tmp/Mixed Case"
    )


@pytest.mark.parametrize(
    ("pairs", "message"),
    [
        ({"samples": "8"}, "no setting 'samples'; there are error_threshold, "),
        ({"max_samples": "8.5"}, "setting max_samples: '8.5' is not a whole number"),
        ({"max_samples": ""}, "setting max_samples: '' is not a whole number"),
        ({"error_threshold": "low"}, "setting error_threshold: 'low' is not a number"),
        ({"error_threshold": "nan"}, "setting error_threshold: nan is outside"),
        ({"threads": "1000000"}, "setting threads: 1000000 is outside 0 ... 1024"),
        ({"denoise": "yes please"}, "setting denoise: 'yes please' is neither True nor False"),
        ({"stop_rule": "never"}, "setting stop_rule: 'NEVER' is none of PERCEPTUAL, PAPER, FIXED"),
    ],
)
def test_from_strings_names_what_is_wrong(pairs, message):
    """One message with the setting, the value and what would do."""
    with pytest.raises(ValueError, match=message):
        settings_from_strings(pairs)


def test_absurd_but_legal_settings_are_taken():
    """E = 0 and MAX < n are the renderer's business, not a mistake."""
    settings = RenderSettings(error_threshold=0.0, max_samples=3, batch_size=8)
    assert settings.max_samples < settings.batch_size


def test_settings_cannot_be_changed():
    """A render may rely on them while it runs."""
    with pytest.raises(dataclasses.FrozenInstanceError):
        RenderSettings().seed = 3
