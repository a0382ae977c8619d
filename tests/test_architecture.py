"""Who may import whom (docs/architecture.md), found by walking the source: nothing is executed."""

import ast
import re
import sys
from pathlib import Path

import pytest

import iwis

ROOT = Path(iwis.__file__).resolve().parent
CORE = sorted((ROOT / "core").glob("*.py"))
SHIPPED = sorted(
    [ROOT / "__init__.py", ROOT / "__main__.py"]
    + [
        path
        for folder in ("core", "iwis_addon", "operators")
        for path in (ROOT / folder).rglob("*.py")
    ]
)
# Packages from outside that a core module may import, besides the standard library.
CORE_MAY_IMPORT = {"numpy", "numba"}
CORE_MAY_ALSO_IMPORT = {
    "_parts": {"llvmlite"},
    "accel": {"embreex"},
    "addresses": {"llvmlite"},
    "exr": {"OpenEXR"},
    "prefetch": {"llvmlite"},
}
# What the parts beside core may import of core; None = all of it. What is not named here, nothing.
MAY_IMPORT_OF_CORE = {
    "iwis_addon/export": {"scene", "settings", "film", "measured", "table_cache", "program"}
    | {
        "asked_passes",
        "bake_points",
        "bezier_patches",
        "copies",
        "dicing",
        "dicing_view",
        "displacement",
        "lamps",
        "emitters",
        "islands",
        "channels",
        "micropolygons",
        "object_motion",
        "patch_values",
        "program_ops",
        "subdivision",
        "subsurface",
        "thin_film_tables",
        "nodes",
        "nodes/color",
        "nodes/falloff",
        "nodes/hashing",
        "nodes/ies",
        "nodes/images",
        "nodes/lamp_map",
        "nodes/typical",
        "nodes/wireframe",
        "nodes/world",
        "nodes/world_map",
    },
    "iwis_addon/settings.py": {"scene", "settings", "film"},
    "iwis_addon/passes.py": {"scene", "settings", "film", "asked_passes", "denoise"},
}


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def imports_of(path: Path, source: str | None = None) -> set[str]:
    """Dotted names that a file imports anywhere: 'numpy.linalg', or '/core/haar' for our own.

    ``from . import a`` counts as '/…/a'; a relative import is resolved against the file's folder.
    """
    found = set()
    for node in ast.walk(ast.parse(source or path.read_text(), str(path))):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found.add(node.module)
        elif isinstance(node, ast.ImportFrom):
            folder = path.parents[node.level - 1]
            base = folder.joinpath(*(node.module or "").split("."))
            for alias in node.names:
                deeper = base / alias.name
                is_file = deeper.with_suffix(".py").exists() or deeper.is_dir()
                found.add("/" + (deeper if is_file else base).relative_to(ROOT).as_posix())
    return found


def documented_groups(docstring: str) -> dict[str, int]:
    """Module -> number of its group, from the table in core's docstring.

    A row is '    names, of, modules   NUMBER  words'; names that go on in the next line end in a
    comma.
    """
    groups, waiting, number = {}, [], None
    for line in docstring.splitlines():
        row = re.match(r"    (\w+(?:, \w+)*,?)(?: {2,}(-?\d+) {2,}\S.*)?$", line)
        if not row:
            continue
        number = int(row[2]) if row[2] else number
        waiting = [name for name in re.split(r",\s*", row[1]) if name]
        for name in waiting:
            assert name not in groups, f"{name} stands twice in core's docstring"
            groups[name] = number
    return groups


def upward_imports(groups: dict[str, int], module: str, imports: set[str]) -> list[str]:
    """Core modules that ``module`` imports although their group is not a lower one."""
    wanted = {name.removeprefix("/core/") for name in imports if name.startswith("/core/")}
    wanted = {name.partition("/")[0] for name in wanted}  # a package counts as one module
    return sorted(name for name in wanted if groups[name] >= groups[module])


GROUPS = documented_groups(
    ast.get_docstring(ast.parse((ROOT / "core/__init__.py").read_text()), clean=False)
)


def test_core_docstring_names_every_module():
    """The map of core is the truth about the folder."""
    assert set(GROUPS) == {path.stem for path in CORE} - {"__init__"} | {"nodes"}


@pytest.mark.parametrize("path", CORE, ids=name_of)
def test_core_imports_go_down(path):
    """A core module imports only core modules of lower groups, and only core modules."""
    ours = {name for name in imports_of(path) if name.startswith("/")}
    assert all(name.startswith("/core/") for name in ours), ours
    if path.stem != "__init__":
        assert upward_imports(GROUPS, path.stem, ours) == []


@pytest.mark.parametrize("path", CORE, ids=name_of)
def test_core_imports_few_packages(path):
    """Core never imports bpy; embreex is accel.py's, and so on."""
    outside = {name.partition(".")[0] for name in imports_of(path) if not name.startswith("/")}
    allowed = CORE_MAY_IMPORT | CORE_MAY_ALSO_IMPORT.get(path.stem, set())
    assert outside - set(sys.stdlib_module_names) <= allowed


@pytest.mark.parametrize("path", SHIPPED, ids=name_of)
def test_shipped_code_imports_itself_relatively(path):
    """Blender calls the package bl_ext.REPOSITORY.iwis: 'import iwis' would not find it."""
    assert not {name for name in imports_of(path) if name.partition(".")[0] == "iwis"}


@pytest.mark.parametrize("part", sorted(MAY_IMPORT_OF_CORE))
def test_translators_know_only_cores_data(part):
    """Export, settings and passes know the data contract, not the renderer."""
    files = [path for path in SHIPPED if name_of(path).startswith(part)]
    assert files, f"{part} is gone: change this test"
    for path in files:
        of_core = {name for name in imports_of(path) if name.startswith("/core")}
        assert of_core <= {f"/core/{name}" for name in MAY_IMPORT_OF_CORE[part]}, name_of(path)


def test_addon_never_imports_operators():
    """Panels name an operator by its bl_idname; only registration.py sees the classes."""
    for path in SHIPPED:
        if name_of(path).startswith("iwis_addon") and path.name != "registration.py":
            imports = imports_of(path)
            assert not {name for name in imports if name.startswith("/operators")}, name_of(path)
            assert "/iwis_addon/registration" not in imports, name_of(path)


def test_operators_use_the_translators_only():
    """Operators stand beside the engine: of the add-on they import what is not registered."""
    registered = {"engine", "panels", "properties", "registration", "viewport"}
    for path in (ROOT / "operators").glob("*.py"):
        forbidden = {f"/iwis_addon/{name}" for name in registered}
        assert not imports_of(path) & forbidden, name_of(path)


def test_root_imports_nothing_at_top_level():
    """pytest and Blender import the root for its name alone."""
    tree = ast.parse((ROOT / "__init__.py").read_text())
    assert not [node for node in tree.body if isinstance(node, (ast.Import, ast.ImportFrom))]
    functions = [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
    assert functions == ["register", "unregister", "settings", "render"]


def call_options(source: str) -> set[tuple[str, object]]:
    """(name, constant) of every keyword argument in a source text."""
    return {
        (keyword.arg, keyword.value.value)
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Call)
        for keyword in node.keywords
        if isinstance(keyword.value, ast.Constant)
    }


@pytest.mark.parametrize("path", CORE, ids=name_of)
def test_kernels_are_neither_parallel_nor_fastmath(path):
    """parallel=True aborts when two renders run at once; fastmath=True makes isfinite() lie."""
    options = call_options(path.read_text())
    assert not options & {("parallel", True), ("fastmath", True)}
    if path.stem != "_jit":
        assert "numba.njit" not in path.read_text(), "use @kernel of _jit.py"


def test_the_checks_above_can_fail():
    """Each finder finds what it is there for."""
    haar = ROOT / "core" / "haar.py"
    assert imports_of(haar, "def f():\n    import bpy") == {"bpy"}
    assert imports_of(haar, "from ..operators import save_film") == {"/operators/save_film"}
    assert imports_of(haar, "from . import render") == {"/core/render"}
    assert upward_imports({"haar": 1, "render": 6}, "haar", {"/core/render"}) == ["render"]
    assert upward_imports({"haar": 1, "film": 1}, "haar", {"/core/film"}) == ["film"]
    assert ("parallel", True) in call_options("kernel(parallel=True)(f)")
