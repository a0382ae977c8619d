"""core/see_through/opacity.py: what depends on the angle at which a shadow ray meets a surface."""

import dataclasses

import numpy as np
import pytest

from iwis.core.data.program import Closure, Op, Program, Ref
from iwis.core.embree.opacity_grids import ANGLES
from iwis.core.render_cache import RenderCache
from iwis.core.scene import DIFFUSE, GGX
from iwis.core.see_through import opacity, ray_masks
from support.programs import with_programs
from support.scenes import camera_at, constant_world, diffuse, floor, make_scene, sphere

RAYS, _BINS = 100_000, 20
_IOR, _BLEND = np.float32(1.5), np.float32(0.7)
_FRESNEL = Op("ShaderNodeFresnel", {"IOR": _IOR}, {"outputs": {"Fac"}})
_FACING = Op("ShaderNodeLayerWeight", {"Blend": _BLEND}, {"outputs": {"Facing"}})
_BACK = Op("ShaderNodeNewGeometry", {}, {"outputs": {"Backfacing"}})
_INCOMING = Op("ShaderNodeNewGeometry", {}, {"outputs": {"Incoming"}})
_POSITION = Op("ShaderNodeNewGeometry", {}, {"outputs": {"Position"}})
_HALF = np.float32(0.5)
_APART = Op("ShaderNodeSeparateXYZ", {"Vector": Ref(1, "Position")}, {})


def _as_color(of, name):
    return Op("convert", {"Value": Ref(of, name)}, {"source": "NUMBER", "target": "COLOR"})


def _clear(*ops) -> Program:
    """White, and clear by the color that the last of the ops is."""
    closure = Closure(DIFFUSE, GGX, np.ones(3, np.float32), {})
    return Program(ops=ops, closures=(closure,), transparent=Ref(len(ops) - 1, ""))


_PROGRAMS = {
    "Fresnel": _clear(_FRESNEL, _as_color(0, "Fac")),
    "facing": _clear(_FACING, _as_color(0, "Facing")),
    "the back": _clear(_BACK, _as_color(0, "Backfacing")),
    "Fresnel by place": _clear(
        _FRESNEL,
        _POSITION,
        _APART,
        _as_color(2, "X"),
        Op("scale", {"Color": Ref(3, ""), "Factor": Ref(0, "Fac")}, {}),
    ),
}


def _scene(program, part=None):
    """A ball, or a part, clear by a program."""
    camera = camera_at((0.0, 0.0, 4.0), (0.0, 0.01, 0.0), 8, 8, 0.5)
    scene = make_scene([part or sphere(rings=8)], [diffuse()], constant_world(), camera)
    return with_programs(scene, program)


def _rays(rng):
    """From inside and outside a ball of radius 1."""
    origins = rng.normal(size=(RAYS, 3))
    far = rng.choice([0.3, 3.0], (RAYS, 1))
    origins *= far / np.linalg.norm(origins, axis=1, keepdims=True)
    ways = rng.uniform(-1.0, 1.0, (RAYS, 3)) - origins
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    return origins.astype(np.float32), ways.astype(np.float32)


def _hit_by_hit(scene, monkeypatch, *rays):
    with monkeypatch.context() as patch:
        patch.setattr(ray_masks, "can_filter", lambda: False)
        slow = RenderCache().rays(scene)
        assert slow.by_rays
        return slow.occluded(*rays)


def _agree(found, expected, origins, directions):
    """Whether as many rays end, of those of each side and each angle at which they meet the ball:
    within 4.5 standard errors of draws that are not the same, and .006: what a ray's two hits are
    off by, in steps of 255 and between cosines."""
    aside = np.linalg.norm(np.cross(origins, directions), axis=1)
    inside = np.linalg.norm(origins, axis=1) < 1.0
    rows = np.minimum((aside * _BINS).astype(int), _BINS) + (_BINS + 1) * inside
    counts = np.bincount(rows)
    shares = [np.bincount(rows, ended) / np.maximum(counts, 1) for ended in (found, expected)]
    mean = 0.5 * sum(shares)
    error = np.sqrt(2.0 * mean * (1.0 - mean) / np.maximum(counts, 1))
    return (np.abs(shares[0] - shares[1]) < 4.5 * error + 0.006).all()


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("name", _PROGRAMS)
def test_filter_answers_as_the_program_does(name, smooth, rng, monkeypatch):
    """As rays do that are looked at hit by hit."""
    scene = _scene(_PROGRAMS[name], sphere(rings=8, smooth=smooth))
    rays, asked = _rays(rng), RenderCache().rays(scene)
    assert not asked.by_rays
    found, expected = asked.occluded(*rays), _hit_by_hit(scene, monkeypatch, *rays)
    assert 0.02 < expected.mean() < 0.98
    assert _agree(found, expected, *rays)


def test_colors_keep_their_shares(rng, monkeypatch):
    """Red light goes by Fresnel, of green half of that: each color by itself."""
    half = Op("product", {"A": Ref(1, ""), "B": np.float32([1.0, 0.5, 0.0])}, {})
    scene = _scene(_clear(_FRESNEL, _as_color(0, "Fac"), half))
    rays, asked = _rays(rng), RenderCache().rays(scene)
    assert asked.traversal.colored
    blocked = asked.occluded(*rays, np.empty(RAYS, np.uint8))
    for color, factor in enumerate((1.0, 0.5, 0.0)):
        grey = Op("scale", {"Color": Ref(1, ""), "Factor": np.float32(factor)}, {})
        own = _scene(_clear(_FRESNEL, _as_color(0, "Fac"), grey))
        expected = _hit_by_hit(own, monkeypatch, *rays)
        assert _agree((blocked >> color) & 1, expected, *rays)


@pytest.mark.parametrize("change", ["Incoming", "a normal of its own"])
def test_what_depends_on_more_than_the_angle_is_looked_at_hit_by_hit(change):
    program = _clear(_INCOMING)
    if change != "Incoming":
        own = {"IOR": _IOR, "Normal": Ref(0, "Position")}
        program = _clear(_POSITION, _FRESNEL._replace(inputs=own), _as_color(1, "Fac"))
    assert RenderCache().rays(_scene(program)).by_rays


def test_a_pane_has_one_small_grid():
    """However many triangles and maps it has: all are alike."""
    scene = _scene(_PROGRAMS["Fresnel"])
    table = np.random.default_rng(1).random((len(scene.mesh.triangles), 3, 2), np.float32)
    surface = scene.shaders.surface
    surface = dataclasses.replace(
        surface, row=np.arange(len(table), dtype=np.int32), tables={"uv:": table}
    )
    shaders = dataclasses.replace(scene.shaders, surface=surface)
    scene = dataclasses.replace(scene, shaders=shaders)
    found = opacity.bake_opacity(scene, np.ones(len(table), bool))
    assert len(found.side) == 1 and len(found.values) == 3 * ANGLES and found.angled.all()


def test_grids_that_are_too_large_are_coarser(monkeypatch):
    """What they let through in all stays the same, within 4 standard errors of a corner's .29."""
    program = _clear(_POSITION, Op("scale", {"Color": Ref(0, "Position"), "Factor": _HALF}, {}))
    scene = _scene(program, floor(1.0))
    fine = opacity.bake_opacity(scene, np.ones(2, bool), colored=False)
    monkeypatch.setattr(opacity, "MOST_CORNERS", 4000)
    coarse = opacity.bake_opacity(scene, np.ones(2, bool), colored=False)
    assert (coarse.side < fine.side).all() and len(coarse.values) <= 4000
    means = fine.values.mean() / 255.0, coarse.values.mean() / 255.0
    assert abs(means[0] - means[1]) < 4.0 * 0.29 / len(coarse.values) ** 0.5
    monkeypatch.setattr(opacity, "MOST_CORNERS", 20)
    assert (opacity.bake_opacity(scene, np.ones(2, bool), colored=False).row < 0).all()


def test_objects_that_have_moved_are_met_at_their_angle(rng):
    """A pane turned by 75 degrees after its hierarchy was built: Fresnel's share, .2525 there and
    .04 before, within 4 standard errors."""
    scene = _scene(_PROGRAMS["Fresnel"], floor(5.0))
    scene = dataclasses.replace(scene, object_to_world=np.eye(4)[None])
    cache = RenderCache()
    down = np.tile(np.float32([0.0, 0.0, -1.0]), (RAYS, 1))
    origins = np.concatenate([rng.uniform(-0.5, 0.5, (RAYS, 2)), np.full((RAYS, 1), 9.0)], 1)
    origins = origins.astype(np.float32)
    assert abs(1.0 - cache.rays(scene).occluded(origins, down).mean() - 0.04) < 0.004
    angle, turn = np.radians(75.0), np.eye(4)
    turn[1:3, 1:3] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    mesh, by = scene.mesh, turn[:3, :3].T.astype(np.float32)
    turned = dataclasses.replace(
        mesh, vertices=mesh.vertices @ by, corner_normals=mesh.corner_normals @ by
    )
    moved = dataclasses.replace(scene, mesh=turned, object_to_world=turn[None])
    for quick in (True, False):
        free = 1.0 - cache.rays(moved, quick=quick).occluded(origins, down).mean()
        assert abs(free - 0.2525) < 4.0 * (0.25 * 0.75 / RAYS) ** 0.5 + 0.5 / 255
