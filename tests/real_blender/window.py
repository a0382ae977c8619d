"""A Blender window on a screen that nobody sees: Xvfb, OpenGL in software, screenshots."""

import os
import shutil
import subprocess
import time
from pathlib import Path


class Window:
    """A Blender program with its window, run by a script; to be used in a with statement.

    program: Blender; where FOLDER/enter lies beside it (get_blender.sh), Xvfb and scrot are run
    through that, else they are the machine's own
    """

    def __init__(self, program: str, environment: dict, log: Path, size="1280x800"):
        enter = Path(program).parent / "enter"
        self._through = [str(enter)] if enter.exists() else []
        if not self._through and shutil.which("Xvfb") is None:
            raise SystemExit("Xvfb is missing: install the Debian packages xvfb and scrot")
        self._program, self._size, self.log = program, size, log
        # Its own: another program that writes the shared cache at the same time may end this one.
        shaders = {"MESA_SHADER_CACHE_DIR": str(log.parent / "shaders")}
        self._environment = dict(environment, LIBGL_ALWAYS_SOFTWARE="1", **shaders)
        self.process = self._screen = None

    def __enter__(self):
        read_end, write_end = os.pipe()
        options = ["-displayfd", str(write_end), "-nolisten", "tcp"]
        options += ["-screen", "0", f"{self._size}x24"]
        self._screen = subprocess.Popen(
            [*self._through, "Xvfb", *options],
            pass_fds=(write_end,),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(write_end)
        with os.fdopen(read_end) as stream:
            self._environment["DISPLAY"] = ":" + stream.readline().strip()
        return self

    def __exit__(self, *_):
        for process in (self.process, self._screen):
            if process is not None and process.poll() is None:
                process.terminate()
                try:
                    process.wait(10)
                except subprocess.TimeoutExpired:
                    process.kill()

    def start(self, *arguments: str, script: Path, words: list[str]) -> None:
        """Open the window; ``script`` runs in it with ``words`` after ``--``."""
        command = [self._program, "--gpu-backend", "opengl", "--offline-mode", *arguments]
        command += ["--python", str(script), "--", *words]
        width, height = self._size.split("x")
        command[1:1] = ["--window-geometry", "0", "0", width, height]
        with self.log.open("w") as out:
            self.process = subprocess.Popen(
                command,
                env=self._environment,
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=subprocess.STDOUT,
            )

    def wait(self, seconds: float, on_line=lambda line: None) -> int:
        """The program's exit code, when it ends by itself; every line of its log is passed on."""
        deadline = time.monotonic() + seconds
        with self.log.open() as lines:
            while True:
                ended = self.process.poll()
                for line in lines:
                    on_line(line.rstrip("\n"))
                if ended is not None:
                    return ended
                if time.monotonic() > deadline:
                    end = self.log.read_text()[-3000:]
                    raise SystemExit(f"{end}\nstill runs after {seconds} s")
                time.sleep(0.05)

    def run(self, *command: str) -> str:
        """Another program on the same screen, such as scrot or xdotool."""
        return subprocess.run(
            [*self._through, *command],
            env=self._environment,
            check=True,
            capture_output=True,
            text=True,
        ).stdout

    def screenshot(self, path: Path) -> None:
        """What the screen shows now; a file of that name is whole."""
        part = path.with_name(f"part-{path.name}")
        self.run("scrot", "-o", "-q", "90", str(part))
        part.replace(path)
