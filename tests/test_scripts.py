"""scripts/: what a machine lacks is said in one line, and what is there is not made again."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

import iwis

SCRIPTS = Path(iwis.__file__).resolve().parent / "scripts"


def _load_setup_venv():
    spec = importlib.util.spec_from_file_location("setup_venv", SCRIPTS / "setup_venv.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


setup_venv = _load_setup_venv()


def _venv_sh(**variables) -> subprocess.CompletedProcess:
    environment = {"PATH": "/usr/bin:/bin", "HOME": os.devnull, **variables}
    command = ["bash", SCRIPTS / "venv.sh"]
    return subprocess.run(
        command, env=environment, capture_output=True, text=True, timeout=60, check=False
    )


def test_python_that_does_not_run_is_one_line(tmp_path):
    """A pyenv shim of a version that is not active is on PATH, and only fails when it is run."""
    shim = tmp_path / "python3.13"
    shim.write_text("#!/bin/sh\nexit 127\n")
    shim.chmod(0o755)
    done = _venv_sh(PYTHON=str(shim))
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == f"iwis: PYTHON={shim} is no Python 3.11 or 3.13 that runs\n"


def test_environment_that_is_up_to_date_is_left_alone(tmp_path):
    """With the stamp of this checkout and this Python, its path is all that is printed."""
    (tmp_path / "iwis-stamp").write_text(setup_venv.stamp_text())
    command = [sys.executable, SCRIPTS / "setup_venv.py", tmp_path]
    environment = {name: value for name, value in os.environ.items() if name != "BPY"}
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == f"{tmp_path}/bin/python\n"
    assert os.listdir(tmp_path) == ["iwis-stamp"]


def test_missing_packages_are_one_line_for_a_user(monkeypatch):
    """Who is not root is told the command; nothing is tried."""
    monkeypatch.setattr(setup_venv.os, "geteuid", lambda: 1000)
    monkeypatch.setattr(setup_venv.shutil, "which", lambda name: f"/usr/bin/{name}")
    monkeypatch.setattr(setup_venv.Path, "exists", lambda path: True)
    with pytest.raises(SystemExit) as stopped:
        setup_venv.provide(["libxi6", "libsm6"])
    message = "please run: sudo apt-get install -y libxi6 libsm6"
    assert stopped.value.code == f"iwis: the system lacks packages; {message}"


def test_libraries_that_bpy_needs_have_a_package():
    """Each that is looked for ahead can be named, and none is missing where the tests run."""
    assert set(setup_venv.NEEDED_BY_BPY) <= set(setup_venv.DEBIAN_PACKAGES)
    if importlib.util.find_spec("bpy"):
        assert setup_venv.missing_of_bpy(Path(sys.executable)) == []
