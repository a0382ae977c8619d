"""Make the virtual environment that IWIS is run and tested in, and print its Python's path.

    python3.13 scripts/setup_venv.py [FOLDER]

Does nothing when the environment is up to date. The first time it downloads about 500 MB from PyPI.
What the system lacks is installed by apt-get when root on Debian, else named in one line.
Run by any Python 3.11 or 3.13; uses the standard library only. Messages go to standard error.
"""

import ctypes
import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PYTHON = sys.version_info[:2]
BPY = {(3, 11): "bpy==4.5.*", (3, 13): "bpy==5.2.*"}
# What bpy links to beyond its own libraries (ldd of bpy 4.5 and 5.2) -> Debian package.
DEBIAN_PACKAGES = {
    "libX11.so.6": "libx11-6",
    "libXrender.so.1": "libxrender1",
    "libXfixes.so.3": "libxfixes3",
    "libXi.so.6": "libxi6",
    "libXext.so.6": "libxext6",
    "libXxf86vm.so.1": "libxxf86vm1",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libSM.so.6": "libsm6",
    "libICE.so.6": "libice6",
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libgomp.so.1": "libgomp1",
    "libstdc++.so.6": "libstdc++6",
}
# Those of them that every bpy so far needs: looked for before anything is downloaded.
NEEDED_BY_BPY = (
    "libX11.so.6",
    "libXrender.so.1",
    "libXfixes.so.3",
    "libXi.so.6",
    "libxkbcommon.so.0",
    "libSM.so.6",
    "libICE.so.6",
    "libGL.so.1",
)


def say(text: str) -> None:
    print(f"iwis: {text}", file=sys.stderr, flush=True)


def stamp_text() -> str:
    """Changes when the environment has to be brought up to date."""
    digest = hashlib.sha256()
    for path in (ROOT / "pyproject.toml", Path(__file__)):
        digest.update(path.read_bytes())
    return f"{sys.version}\n{sys.executable}\n{ROOT}\n{digest.hexdigest()}\n"


def missing_before_install() -> list[str]:
    """Debian packages that are missing for sure, found without bpy."""
    packages = []
    if importlib.util.find_spec("venv") is None or importlib.util.find_spec("ensurepip") is None:
        packages.append(f"python{PYTHON[0]}.{PYTHON[1]}-venv")
    if sys.platform == "linux":
        packages += [DEBIAN_PACKAGES[name] for name in NEEDED_BY_BPY if not _loads(name)]
    return packages


def _loads(soname) -> bool:
    try:
        ctypes.CDLL(soname)
    except OSError:
        return False
    return True


def missing_of_bpy(python: Path) -> list[str]:
    """Debian packages (or names of libraries, where unknown) that ldd finds bpy to lack."""
    if sys.platform != "linux" or not shutil.which("ldd"):
        return []
    # find_spec does not import: bpy cannot be imported yet if a library is missing.
    code = "import importlib.util as u; print(u.find_spec('bpy').origin)"
    library = subprocess.check_output([python, "-c", code], text=True).strip()
    lines = subprocess.run(["ldd", library], capture_output=True, text=True, check=False).stdout
    names = [line.split()[0] for line in lines.splitlines() if line.endswith("not found")]
    return sorted({DEBIAN_PACKAGES.get(name, name) for name in names})


def provide(packages: list[str]) -> None:
    """Have apt-get install what is missing, or leave with one line that says what to install."""
    if not packages:
        return
    command = f"apt-get install -y {' '.join(packages)}"
    debian = Path("/etc/debian_version").exists() and shutil.which("apt-get")
    if not debian:
        sys.exit(f"iwis: the system lacks (names of Debian's packages): {' '.join(packages)}")
    if os.geteuid() != 0:
        sys.exit(f"iwis: the system lacks packages; please run: sudo {command}")
    say(command)
    environment = dict(os.environ, DEBIAN_FRONTEND="noninteractive")
    for arguments in (["update", "-qq"], ["install", "-y", "-qq", "--no-install-recommends"]):
        names = packages if arguments[0] == "install" else []
        done = subprocess.run(
            ["apt-get", *arguments, *names],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            check=False,
        )
        if done.returncode and names:
            sys.exit(f"iwis: apt-get failed; the system lacks: {' '.join(packages)}")


def run(*command) -> None:
    """Run a step with its output on standard error; leave with its exit code if it fails."""
    done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=sys.stderr, check=False)
    if done.returncode:
        sys.exit(
            f"iwis: this step failed (exit code {done.returncode}): {' '.join(map(str, command))}"
        )


def is_sound(python: Path) -> bool:
    """Whether an environment of this very Python is there, with pip."""
    code = "import pip, sys; print(sys.version, sys.base_prefix)"
    try:
        done = subprocess.run([python, "-c", code], capture_output=True, text=True, check=False)
    except OSError:
        return False
    return done.stdout.strip() == f"{sys.version} {sys.base_prefix}"


def install(folder: Path, python: Path) -> None:
    """Bring the environment up to date: this checkout (editable), its tests' needs, and bpy."""
    provide(missing_before_install())
    if not is_sound(python):
        say(f"making {folder} with Python {PYTHON[0]}.{PYTHON[1]}")
        run(sys.executable, "-m", "venv", "--clear", folder)
    bpy = os.environ.get("BPY") or BPY[PYTHON]
    say(f"installing {bpy} and what IWIS needs into {folder} (about 500 MB the first time)")
    run(python, "-m", "pip", "install", "-qq", "--editable", f"{ROOT}[test]", bpy)
    provide(missing_of_bpy(python))
    run(python, "-c", "import bpy, embreex, numba, OpenEXR, iwis")


def main() -> None:
    if PYTHON not in BPY:
        sys.exit(f"iwis: Python {PYTHON[0]}.{PYTHON[1]} has no bpy; 3.11 and 3.13 have")
    tag = f"py{PYTHON[0]}{PYTHON[1]}"
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / f".venv-{tag}").absolute()
    python = folder / "bin" / "python"
    stamp = folder / "iwis-stamp"
    wanted = stamp_text() + os.environ.get("BPY", "")
    if not stamp.exists() or stamp.read_text() != wanted:
        stamp.unlink(missing_ok=True)
        install(folder, python)
        stamp.write_text(wanted)
    print(python)


if __name__ == "__main__":
    main()
