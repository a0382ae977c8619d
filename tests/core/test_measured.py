"""Measured BRDFs as a material: energy, reciprocity, the furnace, all modes; files and fits."""

import dataclasses

import numpy as np
import pytest

from iwis.core.bsdf.lobe_setup import setup_lobes
from iwis.core.bsdf.measured import join_measured, read_measured
from iwis.core.paper_mode.paper_tables import TableBuilder
from iwis.core.sampling.unbiased_rays import UnbiasedSampler
from iwis.core.scene import FIT_ALBEDO, NO_MEASURED
from iwis.core.settings import RenderSettings
from support.brdf_points import directions, evaluated, reflected, sphere_quadrature
from support.merl import brdfs, eval_table, glossy_table, lambert_table, measured, write_merl
from support.samplers import all_rays, pixel_points, random_sequence
from support.scenes import (
    camera_above,
    camera_at,
    constant_world,
    diffuse,
    floor,
    gradient_world,
    make_materials,
    make_picture,
    make_scene,
    sphere,
    varied_scene,
)
from support.warps import light_of

GLOSSY = glossy_table()
BRDFS = brdfs(GLOSSY, lambert_table())


def _lobes(cosines, tint=(1.0, 1.0, 1.0), row=0):
    wo = directions(cosines)
    up = np.tile(np.float32([0, 0, 1]), (len(wo), 1))
    return setup_lobes(make_materials(*[measured(tint, row)] * len(wo)), up, up, wo, BRDFS)


def test_value_is_tint_times_table_times_cosine(rng):
    """Diffuse part and rest add up to it; neither is negative. rtol: float32 angles."""
    lobes = _lobes([0.9, 0.4], (1.0, 0.5, 2.0))
    wi = rng.normal(size=(500, 3))
    wi[:, 2] = np.abs(wi[:, 2]) + 0.05
    wi = np.float32(wi / np.linalg.norm(wi, axis=1, keepdims=True))
    for p in range(2):
        value = evaluated(lobes, p, wi)
        truth = eval_table(GLOSSY, lobes.wo[p], wi) * (1.0, 0.5, 2.0) * wi[:, 2:]
        np.testing.assert_allclose(value[:, :3] + value[:, 3:], truth, rtol=2e-3, atol=1e-4)
        assert (value >= 0.0).all()
    below = wi * np.float32([1, 1, -1])
    assert not evaluated(lobes, 0, below).any()


def test_energy_is_the_tables(rng):
    """A Lambert table reflects its albedo from everywhere; 2e-3: quadrature at the horizon."""
    lobes = _lobes([1.0, 0.7, 0.3, 0.05], row=1)
    for p in range(4):
        light = reflected(lobes, p)
        np.testing.assert_allclose(light[:3] + light[3:], (0.8, 0.5, 0.2), rtol=2e-3)
    np.testing.assert_allclose(
        lobes.diffuse + lobes.glossy_color, np.tile((0.8, 0.5, 0.2), (4, 1)), rtol=6e-3
    )


def test_brdf_is_reciprocal(rng):
    """brdf(wo, wi) = brdf(wi, wo) through the lobes, each cosine divided out."""
    a, b = directions([0.8, 0.35]) * np.float32([[1, 1, 1], [-1, 1, 1]])
    up = np.tile(np.float32([0, 0, 1]), (2, 1))
    lobes = setup_lobes(make_materials(*[measured()] * 2), up, up, np.stack([a, b]), BRDFS)
    there, back = evaluated(lobes, 0, b[None]), evaluated(lobes, 1, a[None])
    there, back = ((v[0, :3] + v[0, 3:]) / z for v, z in ((there, b[2]), (back, a[2])))
    np.testing.assert_allclose(there, back, rtol=1e-4)


def test_fit_knows_the_albedo():
    """To 1 %: the fit's grid has 128^2 directions; from straight above to grazing."""
    wi, solid_angle = sphere_quadrature()
    wi, solid_angle = wi[wi[:, 2] > 0.0], solid_angle[wi[:, 2] > 0.0]
    for k in (24, 12, 3):
        wo = directions([k / 24.0])
        weight = (wi[:, 2] * solid_angle)[:, None]
        albedo = (eval_table(GLOSSY, wo, wi) * weight).sum(axis=0)
        np.testing.assert_allclose(BRDFS.fit[0, k, FIT_ALBEDO : FIT_ALBEDO + 3], albedo, rtol=0.01)


def _furnace_truth(cos_o):
    """Albedo seen from that cosine, by quadrature of the naive reader: (3,)."""
    wi, solid_angle = sphere_quadrature()
    above = wi[:, 2] > 0.0
    value = eval_table(GLOSSY, directions([cos_o]), wi[above])
    return (value * (wi[above, 2] * solid_angle[above])[:, None]).sum(axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["UNBIASED", "PAPER"])
@pytest.mark.parametrize("height", [3.0, 0.6])
def test_furnace_shows_what_quadrature_says(estimator, height, table_dir):
    """To .5 %, from above and from the side, under light of 1 from everywhere."""
    camera = camera_at((0.0, -1.5, height), (0.0, 0.0, 0.0), half=0.02)
    scene = make_scene([floor()], [measured()], constant_world(), camera, measured=BRDFS)
    layers, _ = make_picture(
        scene,
        estimator=estimator,
        stop_rule="FIXED",
        max_samples=512,
        cache_dir=table_dir,
    )
    truth = _furnace_truth(height / np.hypot(1.5, height))
    seen = layers["unoccluded" if estimator == "PAPER" else "combined"][..., :3].mean((0, 1))
    np.testing.assert_allclose(seen, truth, rtol=5e-3)


def test_passes_add_up_to_the_picture():
    """Diffuse and glossy, each times its colour, as a compositor does it. float32."""
    scene = make_scene(
        [sphere(smooth=True)], [measured()], gradient_world(), camera_above(), measured=BRDFS
    )
    layers, _ = make_picture(scene)
    light = sum(layers[f"{k}_direct"] * layers[f"{k}_color"] for k in ("diffuse", "glossy"))
    shown = layers["depth"][..., 0] < 1e9
    np.testing.assert_allclose(light[shown], layers["combined"][shown][:, :3], rtol=1e-5)
    assert layers["diffuse_direct"][shown].mean() > 0.1 < layers["glossy_direct"][shown].mean()


def test_samples_follow_light_times_brdf(rng):
    """Weights of UNBIASED's samples on an open floor vary little: CoV below .5 (1.2 by the light).

    Fitted lobes, not the table, make the product: the rest is their misfit.
    """
    scene = make_scene(
        [floor()], [measured()], gradient_world(), camera_above(2, 2), measured=BRDFS
    )
    pixels = pixel_points(scene)
    sequence = random_sequence(rng, 4, 512, "OWEN")
    light = light_of(scene.environment)
    sampler = UnbiasedSampler(pixels.points, pixels.lobes, light, sequence, pixels.accel.offset)
    rays = all_rays(sampler, np.arange(1), 512)
    weights = (rays.diffuse + rays.glossy).mean(axis=1)
    assert weights.std() / weights.mean() < 0.5


def test_scene_of_all_kinds_takes_a_measured_material(table_dir):
    """Beside other materials, both modes: its pixels change, the others stay to the last bit.

    UNBIASED: all of a cell of 8 x 8 pixels that has one may change, for its rays teach them.
    """
    plain = varied_scene(width=20, height=14)
    rows = [column.copy() for column in plain.materials]
    columns = make_materials(measured())
    for column, new in zip(rows, columns, strict=True):
        column[2] = new[0]
    materials = type(plain.materials)(*rows)
    mixed = dataclasses.replace(plain, materials=materials, measured=BRDFS)
    for estimator in ("UNBIASED", "PAPER"):
        shared = dict(estimator=estimator, stop_rule="FIXED", max_samples=8, cache_dir=table_dir)
        before, _ = make_picture(plain, **shared)
        after, _ = make_picture(mixed, **shared)
        own = after["material_index"][..., 0] == 12.0
        changed = np.abs(after["combined"] - before["combined"]).max(axis=2)
        assert (changed[own] > 1e-3).any()
        others = ~own
        if estimator == "UNBIASED":
            for row, column in np.ndindex(2, 3):
                cell = np.s_[8 * row : 8 * row + 8, 8 * column : 8 * column + 8]
                others[cell] = not own[cell].any()
        assert others.any()
        np.testing.assert_allclose(changed[others], 0.0, atol=1e-6)  # sums of three channels


def test_material_without_its_table_is_refused():
    """At the door."""
    with pytest.raises(ValueError, match="measured BRDF that is not there"):
        make_scene([floor()], [measured(row=3)], constant_world(), camera_above(), measured=BRDFS)


def test_file_is_read_fitted_and_kept(tmp_path):
    """The fit is found again by the file's hash; rows join in order."""
    path = write_merl(tmp_path / "a.binary", GLOSSY)
    first = read_measured(path, tmp_path / "tables")
    kept = list((tmp_path / "tables").glob("fit-*.npz"))
    assert len(kept) == 1
    again = read_measured(path, tmp_path / "tables")
    np.testing.assert_array_equal(first.fit, again.fit)
    assert first.keys == again.keys
    both = join_measured([first, BRDFS])
    assert [len(part) for part in both] == [3, 3, 3]
    assert join_measured([]) is NO_MEASURED


@pytest.mark.slow
def test_paper_table_is_kept_by_the_files_hash(tmp_path):
    """Built once with progress, then found; another file gets another table."""
    told = []
    settings = RenderSettings(estimator="PAPER", cache_dir=str(tmp_path))
    light = light_of(constant_world())
    arguments = (light.lookup, make_materials(measured(), diffuse()), settings, 2)
    builder = TableBuilder()
    builder.tables(*arguments, lambda fraction, text: told.append((fraction, text)), BRDFS)
    assert any("measured" in note for note in builder.notes)
    fractions = [fraction for fraction, text in told if "measured" in text]
    assert len(fractions) > 10
    assert fractions[-1] == 1.0
    again = TableBuilder()
    again.tables(*arguments, measured=BRDFS)
    assert again.notes == []
