"""What the checks in a real Blender program share: the program, the extension's zip, a check.

The bpy module that the other tests use is not what users have. Runs in an environment with bpy and
OpenEXR, which build the zip and read the layers (make test-blender). The program is Debian's
Blender, unpacked by get_blender.sh, when none is given; the zip is the one for its Python.
"""

import argparse
import contextlib
import fcntl
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent


class Blender:
    """A Blender program with a folder of its own for settings and extensions."""

    def __init__(self, program: str, resources: Path):
        self.program = program
        # Without this folder install-file complains that the repository is not loaded.
        (resources / "extensions" / "user_default").mkdir(parents=True)
        self.environment = dict(os.environ, BLENDER_USER_RESOURCES=str(resources))

    def run(self, *arguments, expected_code: int = 0) -> str:
        """What the program printed. Leaves when its exit code is another."""
        print("+ blender", *arguments, flush=True)
        done = subprocess.run(
            [self.program, *arguments],
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=900,
            check=False,
        )
        if done.returncode != expected_code:
            sys.exit(f"{done.stdout}\nexit code {done.returncode}, expected {expected_code}")
        return done.stdout

    def engines(self) -> list[str]:
        """Names of all render engines."""
        return self.run("-b", "-E", "help").split()

    def python_tag(self) -> str:
        code = "import sys; print('TAG', 'cp%d%d' % sys.version_info[:2])"
        words = self.run("-b", "--factory-startup", "--python-expr", code).split()
        return words[words.index("TAG") + 1]


def build_zip(python_tag: str, folder: Path) -> Path:
    """The zip for Linux and this Python, built by the project's own builder; a copy of it.

    One check after another builds where two run side by side.
    """
    command = [sys.executable, ROOT / "scripts" / "build_zip.py"]
    (ROOT / "dist").mkdir(exist_ok=True)
    with open(ROOT / "dist" / "turn", "w") as turn:
        fcntl.flock(turn, fcntl.LOCK_EX)
        subprocess.run([*command, "--platform", "linux-x64", "--python", python_tag], check=True)
        found = sorted((ROOT / "dist").glob(f"iwis-*-linux-x64-{python_tag}.zip"))
        return Path(shutil.copy2(found[-1], folder))


def install(blender: Blender, package: Path) -> None:
    """Install the extension from its zip, enabled."""
    blender.run("--command", "extension", "install-file", "-r", "user_default", "-e", package)


def check(condition, what: str) -> None:
    if not condition:
        sys.exit(f"wrong: {what}")
    print(f"  ok: {what}", flush=True)


def parse(description: str, *more) -> argparse.Namespace:
    """Options that every check has: --blender, --zip, and what a check has beside."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--blender", help="a Blender program; else Debian's is unpacked")
    parser.add_argument("--zip", type=Path, help="the extension; else it is built")
    for names, options in more:
        parser.add_argument(*names, **options)
    return parser.parse_args()


@contextlib.contextmanager
def installed(options):
    """A Blender with the extension, a folder that is gone afterwards, and the zip."""
    program = options.blender or subprocess.check_output(
        [HERE / "get_blender.sh"], text=True, stdin=subprocess.DEVNULL
    )
    with tempfile.TemporaryDirectory(prefix="iwis-blender-") as name:
        folder = Path(name)
        blender = Blender(program.strip(), folder / "resources")
        print(blender.run("-b", "--version").splitlines()[0])
        package = options.zip or build_zip(blender.python_tag(), folder)
        install(blender, package)
        # install-file answers 0 even when it fails
        check("IWIS" in blender.engines(), "Blender lists the engine IWIS")
        yield blender, folder, package
