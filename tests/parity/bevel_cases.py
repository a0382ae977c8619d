"""The Bevel node: rounded edges, of which each sample has noise of its own in both engines."""

from .cases import CASES, Case
from .movers import by_keys, move_and_turn


def _case(name, build, **options):
    CASES.append(Case(f"Bevel{name}", build, blurred=True, filter_width=1.5, **options))


def _bevel(tree, inputs=None, **options):
    return tree.made("ShaderNodeBevel", 0, inputs, **options)


def _as_color(tree, normal):
    """0 to 1 for -1 to 1."""
    half = (0.5, 0.5, 0.5)
    tree.glow(
        tree.made(
            "ShaderNodeVectorMath", 0, {0: normal, 1: half, 2: half}, operation="MULTIPLY_ADD"
        )
    )


def _shown(name, inputs=None, **options):
    _case(name, lambda scene, tree: _as_color(tree, _bevel(tree, inputs, **options)))


_shown(", 0.05 m")
_shown(", 0.3 m", {"Radius": 0.3})
_shown(", 0.3 m, 16 samples", {"Radius": 0.3}, samples=16)
_shown(", 0.3 m, one sample", {"Radius": 0.3}, samples=1)
_shown(", wider than the cube", {"Radius": 2.0}, samples=32)


def _plastic(scene, tree):
    inputs = {"Normal": _bevel(tree, {"Radius": 0.25}), "Roughness": 0.3}
    tree.surface(tree.made("ShaderNodeBsdfPrincipled", 0, inputs))


_case(" of plastic", _plastic, lit=True)


def _with_input(scene, tree):
    """What a bump turns, rounded besides."""
    waves = {"Vector": tree.coordinates(), "Scale": 1.5}
    height = tree.made("ShaderNodeTexWave", "Fac", waves)
    bump = tree.made("ShaderNodeBump", 0, {"Height": height, "Distance": 0.2})
    _as_color(tree, _bevel(tree, {"Radius": 0.3, "Normal": bump}, samples=16))


def _under_bump(scene, tree):
    """What is rounded, turned by a bump besides."""
    waves = {"Vector": tree.coordinates(), "Scale": 1.5}
    inputs = {
        "Height": tree.made("ShaderNodeTexWave", "Fac", waves),
        "Distance": 0.2,
        "Normal": _bevel(tree, {"Radius": 0.3}, samples=16),
    }
    _as_color(tree, tree.made("ShaderNodeBump", 0, inputs))


def _displaced(scene, tree):
    """What counts as the surface's own normal is that of its displacement."""
    checks = {"Vector": tree.coordinates(), "Scale": 1.0}
    height = tree.made("ShaderNodeTexWave", "Fac", checks)
    inputs = {"Height": height, "Scale": 0.2}
    tree.link(tree.made("ShaderNodeDisplacement", 0, inputs), tree.output.inputs["Displacement"])
    _with_input(scene, tree)


_case(", with a bumpy normal", _with_input)
_case(", with a bumpy normal, displaced", _displaced)
_case(" under a bump", _under_bump)


def _matte(tree, normal):
    tree.surface(tree.made("ShaderNodeBsdfDiffuse", 0, {"Normal": normal}))


def _changed(name, change, show=_as_color, **options):
    """change(scene, sphere, cube, floor) before it is shown."""

    def build(scene, tree):
        show(tree, _bevel(tree, {"Radius": 0.3}, samples=16))
        change(scene, *(scene.objects[name] for name in ("Sphere", "Cube", "Plane")))

    _case(name, build, **options)


def _cross(scene, sphere, cube, floor):
    """Edges between objects stay as they are."""
    sphere.location.x += 1.2
    cube.location.z -= 0.5


def _mirror(scene, sphere, cube, floor):
    cube.scale.x *= -1.0


def _turn_inside_out(scene, sphere, cube, floor):
    """All is seen from behind."""
    for obj in (sphere, cube, floor):
        obj.data.flip_normals()


def _smooth(scene, sphere, cube, floor):
    cube.data.shade_smooth()


def _moves(scene):
    for obj in scene.objects:
        obj.cycles.motion_steps = 3
    scene.frame_set(1)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0


def _move(scene, sphere, cube, floor):
    move_and_turn(cube)
    _moves(scene)


def _bend(scene, sphere, cube, floor):
    by_keys(cube)
    _moves(scene)


_changed(" of a matte surface", lambda *_: None, _matte, lit=True)
_changed(" of objects that cross", _cross)
_changed(" of a mirrored cube", _mirror)
_changed(", inside out", _turn_inside_out)
_changed(" of a smooth cube", _smooth)
_changed(" of what moves", _move, _matte, lit=True)
_changed(" of what changes its shape", _bend, _matte, lit=True)
