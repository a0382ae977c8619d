"""Build the Blender extension: dist/iwis-VERSION-PLATFORM-cpXY.zip, with its own wheels inside.

    python scripts/build_zip.py [--platform linux-x64] [--python cp314]

Runs in an environment with bpy and pip, such as make zip makes.
One zip is for one platform and one Python, as wheels are, 80 MB each. The wheels come from PyPI
and stay in wheels/PLATFORM-cpXY/; when all are there, no network is asked. NumPy is never among
them: Blender has its own. The zip is built and validated by Blender's own tool, out of
the bpy package.
"""

import argparse
import importlib.util
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SHIPPED_FILES = ("__init__.py", "__main__.py", "LICENSE")
SHIPPED_FOLDERS = ("core", "iwis_addon", "operators")

WHEELS = {"embreex": "4.4.0.post1", "openexr": "3.5.3", "numba": "0.68.1", "llvmlite": "0.50.0"}
# The last releases with wheels for Intel Macs; Blender left those after 4.5.
WHEELS_INTEL_MAC = WHEELS | {"numba": "0.62.1", "llvmlite": "0.45.1"}

PIP_PLATFORMS = {
    "linux-x64": ("manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux2014_x86_64"),
    "windows-x64": ("win_amd64",),
    "macos-arm64": ("macosx_13_0_arm64",),
    "macos-x64": ("macosx_13_0_x86_64",),
}
# Python -> Blender versions that have it, the last one not included; None = no end in sight.
BLENDER_VERSIONS = {
    "cp311": ("4.5.0", "5.1.0"),
    "cp313": ("5.1.0", None),
    "cp314": ("5.2.0", None),  # builds of Linux distributions, Debian's for one
}


class NoWheel(Exception):
    """PyPI has no wheel of a package for this platform and Python."""


@dataclass(frozen=True)
class Target:
    """What one zip is for."""

    platform: str
    python: str

    @property
    def name(self) -> str:
        return f"{self.platform}-{self.python}"

    @property
    def wheels(self) -> dict[str, str]:
        return WHEELS_INTEL_MAC if self.platform == "macos-x64" else WHEELS

    @property
    def may_be_missing(self) -> bool:
        """Projects give up Intel Macs one by one; elsewhere a missing wheel is an error."""
        return self.platform == "macos-x64"


TARGETS = [Target(platform, python) for platform in PIP_PLATFORMS for python in ("cp311", "cp313")]
TARGETS.remove(Target("macos-x64", "cp313"))  # there is no such Blender
TARGETS.append(Target("linux-x64", "cp314"))


def wheels_of(target: Target, folder: Path) -> list[Path]:
    """The wheels of ``target`` that lie in ``folder``, at most one a package."""
    found = []
    for package, version in target.wheels.items():
        found += sorted(folder.glob(f"{package}-{version}-{target.python}-{target.python}-*.whl"))[
            :1
        ]
    return found


def fetch_wheels(target: Target, folder: Path) -> list[Path]:
    """Have every wheel of ``target`` in ``folder``; ask PyPI only for those that are missing."""
    folder.mkdir(parents=True, exist_ok=True)
    have = {path.name.partition("-")[0] for path in wheels_of(target, folder)}
    wanted = [f"{name}=={version}" for name, version in target.wheels.items() if name not in have]
    if wanted:
        print(f"{target.name}: downloading {', '.join(wanted)}", flush=True)
        _pip_download(target, wanted, folder)
    wheels = wheels_of(target, folder)
    if len(wheels) != len(target.wheels):
        raise NoWheel(f"{target.name}: only {[path.name for path in wheels]} for {target.wheels}")
    return wheels


def _pip_download(target, requirements, folder):
    version = f"{target.python[2]}.{target.python[3:]}"
    command = [sys.executable, "-m", "pip", "download", "-qq", "--no-deps", "--only-binary=:all:"]
    command += ["--implementation", "cp", "--python-version", version, "--abi", target.python]
    for platform in PIP_PLATFORMS[target.platform]:
        command += ["--platform", platform]
    done = subprocess.run(
        [*command, "--dest", folder, *requirements], capture_output=True, text=True, check=False
    )
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if line.startswith("ERROR")]
        reason = lines[-1] if lines else done.stderr.strip()
        kind = NoWheel if "No matching distribution" in done.stderr else SystemExit
        raise kind(f"{target.name}: pip download failed: {reason}")


def manifest_of(target: Target, wheels: list[Path], text: str) -> str:
    """The repository's manifest ``text``, with what only this zip has."""
    first, end = BLENDER_VERSIONS[target.python]
    own = [f'blender_version_min = "{first}"']
    if end:
        own.append(f'blender_version_max = "{end}"')
    own.append(f'platforms = ["{target.platform}"]')
    own.append("wheels = [")
    own += [f'  "./wheels/{path.name}",' for path in wheels]
    own.append("]")
    text, count = re.subn(r"(?m)^blender_version_min = .*$", "\n".join(own), text)
    if count != 1:
        raise SystemExit("blender_manifest.toml: expected one line blender_version_min = ...")
    # [build] keeps things out of a zip made in the checkout; staged is only what ships.
    return text.partition("\n[build]\n")[0] + "\n"


def stage(target: Target, wheels: list[Path], folder: Path) -> None:
    """Copy what ships into ``folder``, and nothing else."""
    for name in SHIPPED_FILES:
        shutil.copy2(ROOT / name, folder)
    for name in SHIPPED_FOLDERS:
        hidden = shutil.ignore_patterns("__pycache__", ".*", "*.blend[1-9]", "*.nbi", "*.nbc")
        shutil.copytree(ROOT / name, folder / name, ignore=hidden)
    (folder / "wheels").mkdir()
    for path in wheels:
        shutil.copy2(path, folder / "wheels")
    manifest = (ROOT / "blender_manifest.toml").read_text()
    (folder / "blender_manifest.toml").write_text(manifest_of(target, wheels, manifest))


def blender_ext(*arguments) -> None:
    """Run Blender's own tool for extensions, as ``blender --command extension`` does."""
    spec = importlib.util.find_spec("bpy")
    if spec is None:
        raise SystemExit("the package bpy, which brings the tool, is missing: run make zip")
    tools = sorted(Path(spec.origin).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"))
    command = [sys.executable, tools[-1], *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"Blender's extension tool: {done.stdout}{done.stderr}")


def build(target: Target, output: Path, wheel_store: Path) -> Path:
    """Build and validate one zip; the path of it."""
    wheels = fetch_wheels(target, wheel_store / target.name)
    version = tomllib.loads((ROOT / "blender_manifest.toml").read_text())["version"]
    path = output / f"iwis-{version}-{target.name}.zip"
    output.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    with tempfile.TemporaryDirectory(prefix="iwis-zip-") as folder:
        stage(target, wheels, Path(folder))
        blender_ext("build", "--source-dir", folder, "--output-filepath", path)
    blender_ext("validate", path)
    with zipfile.ZipFile(path) as archive:
        files = len(archive.namelist())
    print(f"{path}: {path.stat().st_size / 1e6:.1f} MB, {files} files, valid", flush=True)
    return path


def chosen_targets(platform: str | None, python: str | None) -> list[Target]:
    chosen = [t for t in TARGETS if platform in (None, t.platform) and python in (None, t.python)]
    if not chosen:
        names = ", ".join(target.name for target in TARGETS)
        raise SystemExit(f"no zip for PLATFORM={platform} PY={python}; there are {names}")
    return chosen


def main() -> None:
    parser = argparse.ArgumentParser(description="Build the Blender extension of IWIS.")
    parser.add_argument("--platform", metavar="PLATFORM", help="/".join(PIP_PLATFORMS))
    parser.add_argument("--python", metavar="cpXY", help="/".join(BLENDER_VERSIONS))
    parser.add_argument("--output", type=Path, default=ROOT / "dist")
    parser.add_argument(
        "--wheels", type=Path, default=ROOT / "wheels", help="where wheels are kept"
    )
    options = parser.parse_args()
    for target in chosen_targets(options.platform, options.python):
        try:
            build(target, options.output, options.wheels)
        except NoWheel as error:
            if not target.may_be_missing:
                raise SystemExit(str(error)) from error
            print(f"{error}\n{target.name}: left out", flush=True)


if __name__ == "__main__":
    main()
