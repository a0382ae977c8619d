"""What is installed is all of IWIS and nothing else, under one version."""

import importlib.util
import tomllib
import zipfile
from pathlib import Path

import pytest

import iwis

ROOT = Path(iwis.__file__).resolve().parent
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
MANIFEST = tomllib.loads((ROOT / "blender_manifest.toml").read_text())


def _load_build_zip():
    spec = importlib.util.spec_from_file_location("build_zip", ROOT / "scripts" / "build_zip.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


build_zip = _load_build_zip()


def _shipped_files() -> set[str]:
    """Every file of the shipped folders, by its path in the zip."""
    return {
        path.relative_to(ROOT).as_posix()
        for folder in build_zip.SHIPPED_FOLDERS
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


def test_one_version():
    """pyproject, the manifest and the package say the same."""
    assert PYPROJECT["project"]["version"] == MANIFEST["version"] == iwis.__version__


def test_every_package_is_listed():
    """A folder of Python files that pyproject forgets would be missing from an installed IWIS."""
    # Presets are data: Blender runs them.
    names = (name for name in _shipped_files() if "/presets/" not in name)
    folders = {Path(name).parent.as_posix() for name in names if name.endswith(".py")}
    packages = {"iwis"} | {"iwis." + folder.replace("/", ".") for folder in folders}
    packages.add("iwis.paper")  # of a checkout, not of the extension
    assert packages == set(PYPROJECT["tool"]["setuptools"]["packages"])
    for folder in folders:
        assert (ROOT / folder / "__init__.py").exists(), folder


def test_only_python_files_ship():
    """Data files would need package-data in pyproject.toml: there are none."""
    assert {Path(name).suffix for name in _shipped_files()} == {".py"}


def test_manifest_keeps_blenders_rules():
    """extensions.blender.org refuses longer texts, and ones that end in a full stop."""
    for text in (MANIFEST["tagline"], *MANIFEST["permissions"].values()):
        assert 0 < len(text) <= 64, text
        assert text[-1].isalnum(), text
    assert MANIFEST["license"] == ["SPDX:GPL-3.0-or-later"]
    assert PYPROJECT["project"]["license"] == "GPL-3.0-or-later"
    assert (
        "GNU GENERAL PUBLIC LICENSE\n                       Version 3"
        in (ROOT / "LICENSE").read_text()
    )


def test_wheels_are_the_packages_that_iwis_imports():
    """All that pyproject asks for is bundled, but NumPy, which Blender has."""
    wanted = {text.partition(">")[0].lower() for text in PYPROJECT["project"]["dependencies"]}
    for target in build_zip.TARGETS:
        assert set(target.wheels) == wanted - {"numpy"} | {"llvmlite"}


@pytest.fixture(scope="module", params=build_zip.TARGETS, ids=lambda target: target.name)
def built(request, tmp_path_factory):
    """(target, zip, its manifest): built with empty files as wheels, so without a network."""
    target, folder = request.param, tmp_path_factory.mktemp("zip")
    store = folder / "wheels" / target.name
    store.mkdir(parents=True)
    tag = build_zip.PIP_PLATFORMS[target.platform][0]
    for name, version in target.wheels.items():
        (store / f"{name}-{version}-{target.python}-{target.python}-{tag}.whl").touch()
    path = build_zip.build(target, folder / "dist", folder / "wheels")
    with zipfile.ZipFile(path) as archive:
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    return target, path, manifest


def test_zip_holds_what_ships_and_nothing_else(built):
    """Every file of the shipped folders, the root's own, the wheels; no tests, no caches."""
    target, path, manifest = built
    with zipfile.ZipFile(path) as archive:
        names = {name for name in archive.namelist() if not name.endswith("/")}
    wheels = {name.removeprefix("./") for name in manifest["wheels"]}
    root = {"__init__.py", "__main__.py", "LICENSE", "blender_manifest.toml"}
    assert names == _shipped_files() | root | wheels
    assert path.name == f"iwis-{MANIFEST['version']}-{target.platform}-{target.python}.zip"


def test_zip_manifest_is_for_its_platform_and_python(built):
    """Platform, wheels and the Blender versions with that Python; the rest is the repository's."""
    target, _path, manifest = built
    assert manifest["platforms"] == [target.platform]
    packages = sorted(Path(name).name.partition("-")[0] for name in manifest["wheels"])
    assert packages == ["embreex", "llvmlite", "numba", "openexr"]
    assert all(f"-{target.python}-{target.python}-" in name for name in manifest["wheels"])
    own = {"platforms", "wheels", "blender_version_min", "blender_version_max", "build"}
    for key in set(MANIFEST) - own:
        assert manifest[key] == MANIFEST[key], key


def test_zips_share_blender_versions_without_overlap():
    """Of one platform, Blender 4.5 and 5.0 get cp311, 5.1 and later cp313."""
    low, high = build_zip.BLENDER_VERSIONS["cp311"], build_zip.BLENDER_VERSIONS["cp313"]
    assert low[0] == MANIFEST["blender_version_min"]
    assert low[1] == high[0]


def test_unknown_target_is_refused_with_the_list():
    """make zip PLATFORM=linux-arm64 says what there is."""
    with pytest.raises(SystemExit, match="there are linux-x64-cp311, linux-x64-cp313"):
        build_zip.chosen_targets("linux-arm64", None)


def test_repository_itself_is_a_valid_extension():
    """Blender's own tool accepts the manifest in the root."""
    build_zip.blender_ext("validate", ROOT)
