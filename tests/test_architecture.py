"""Who may import whom (docs/architecture.md), found by walking the source: nothing is executed."""

import ast
import graphlib
import re
import sys
from pathlib import Path

import pytest

import iwis

ROOT = Path(iwis.__file__).resolve().parent
CORE = sorted((ROOT / "core").rglob("*.py"))
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
# What the parts beside core may import of core, a folder or a module; what is not named, nothing.
MAY_IMPORT_OF_CORE = {
    "iwis_addon/export": {
        "scene",
        "settings",
        "film",
        "data",
        "nodes",
        "fine_meshes",
        "bsdf/measured",
        "bsdf/thin_film_tables",
        "geometry/islands",
        "lamplight/emitters",
        "walks/subsurface",
        "wavelets/table_cache",
    },
    "iwis_addon/settings.py": {"scene", "settings", "film"},
    "iwis_addon/passes.py": {"scene", "settings", "film", "data", "denoising/denoise"},
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


def documented_rows(docstring: str) -> dict[str, int]:
    """Folder or module of core -> its row in the table of core's docstring, counted from above.

    A row is '    name, name  words'.
    """
    rows = {}
    for number, line in enumerate(docstring.splitlines()):
        found = re.match(r"    (\w+(?:, \w+)*) {2,}\S", line)
        for name in found[1].split(", ") if found else ():
            assert name not in rows, f"{name} stands twice in core's docstring"
            rows[name] = number
    return rows


def place_of(name: str) -> str:
    """The folder of core that '/core/folder/module' is in, or the module's own name."""
    return name.removeprefix("/core/").partition("/")[0]


def upward_imports(rows: dict[str, int], place: str, imports: set[str]) -> list[str]:
    """Of imports of core, those whose row is not above the one of ``place``; its own folder's
    aside, and those of its own row that are no folders."""
    wanted = {name for name in imports if name.startswith("/core/") and place_of(name) != place}
    return sorted(name for name in wanted if rows[place_of(name)] > rows[place])


ROWS = documented_rows(
    ast.get_docstring(ast.parse((ROOT / "core/__init__.py").read_text()), clean=False)
)


def test_core_docstring_names_what_is_there():
    """The map of core is the truth about its folder."""
    there = {place_of("/" + name_of(path).removesuffix(".py")) for path in CORE}
    assert set(ROWS) == there - {"__init__"}


@pytest.mark.parametrize("path", CORE, ids=name_of)
def test_core_imports_go_up_the_map(path):
    """A core module imports what stands above it in the map, or beside it, and nothing else."""
    ours = {name for name in imports_of(path) if name.startswith("/")}
    assert all(name.startswith("/core/") for name in ours), ours
    if path != ROOT / "core" / "__init__.py":
        place = place_of("/" + name_of(path).removesuffix(".py"))
        assert upward_imports(ROWS, place, ours) == []


def test_core_imports_in_no_circle():
    """Nor within a folder: what a module needs can be read before it."""
    graph = {
        "/" + name_of(path).removesuffix(".py").removesuffix("/__init__"): imports_of(path)
        for path in CORE
    }
    graphlib.TopologicalSorter(graph).prepare()


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
        of_core = {name for name in imports_of(path) if name.startswith("/core/")}
        allowed = MAY_IMPORT_OF_CORE[part]
        found = {name.removeprefix("/core/") for name in of_core}
        assert {n for n in found if n not in allowed and place_of(n) not in allowed} == set()


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
    haar = ROOT / "core" / "wavelets" / "haar.py"
    assert imports_of(haar, "def f():\n    import bpy") == {"bpy"}
    assert imports_of(haar, "from ...operators import save_film") == {"/operators/save_film"}
    assert imports_of(haar, "from .. import render") == {"/core/render"}
    assert documented_rows("a\n    bsdf, scene  words\n    no name") == {"bsdf": 1, "scene": 1}
    rows = {"bsdf": 1, "render": 6}
    assert upward_imports(rows, "bsdf", {"/core/render", "/core/bsdf/lobes"}) == ["/core/render"]
    assert upward_imports(rows, "render", {"/core/bsdf/lobes"}) == []
    with pytest.raises(graphlib.CycleError):
        graphlib.TopologicalSorter({"a": {"b"}, "b": {"a"}}).prepare()
    assert ("parallel", True) in call_options("kernel(parallel=True)(f)")
