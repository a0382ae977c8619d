"""python -m iwis render FILE.blend -o OUT.exr: the real engine in the bpy module, no window.

Exit codes: 0 rendered; 1 it could not be done, with one line on stderr; 2 wrong usage. Ctrl-C or a
SIGTERM ends the render: the picture holds what was done by then (that of an animation's frame has
another name, so that nobody takes it for done), the exit code is 1.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from pathlib import Path

from ..core.settings import DenoiseSettings, RenderSettings, settings_from_strings
from .interrupts import interrupts

_FORMATS = {".exr": "OPEN_EXR_MULTILAYER", ".png": "PNG"}

_EPILOG = """\
OUT ends in .exr (all layers and passes in one OpenEXR file) or in .png (the picture). A # in its
name is a digit of the frame's number: out_####.exr. Without one, several frames get four digits.

STATS.json holds, for one frame: width, height, shaded_pixels, triangles, samples (total, mean over
shaded pixels, max), shadow_rays, primary_rays, seconds and cpu_seconds (export, tables, bvh,
sampling, denoising, output), peak_memory_bytes, cancelled, warnings. With -s and -e it holds a
list of these, each with its frame, under "frames".

settings: """


class CommandError(Exception):
    """What cannot be done, in one line."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    options = _parser().parse_args(arguments)
    try:
        options.run(options)
    except CommandError as error:
        print(f"iwis: error: {error}", file=sys.stderr)
        return 1
    return 0


def _parser() -> argparse.ArgumentParser:
    from .. import __version__

    parser = argparse.ArgumentParser(prog="iwis", description="Render HDRI-lit scenes with IWIS.")
    parser.add_argument("--version", action="version", version=f"iwis {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    render = commands.add_parser(
        "render",
        help="render a .blend file",
        description="Render a .blend file with the IWIS engine.",
        epilog=_EPILOG + ", ".join([*RenderSettings.__slots__, *DenoiseSettings.__slots__]),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    render.add_argument("file", metavar="FILE.blend", type=Path)
    render.add_argument("-o", "--output", metavar="OUT", type=_output, required=True)
    render.add_argument("-f", "--frame", metavar="FRAME", type=int, help="default: the file's own")
    render.add_argument("-s", "--start", metavar="A", type=int, help="first frame of an animation")
    render.add_argument("-e", "--end", metavar="B", type=int, help="last frame of an animation")
    render.add_argument("--resolution", metavar="WxH", type=_resolution, help="in pixels")
    render.add_argument(
        "--set",
        metavar="NAME=VALUE",
        type=_pair,
        action="append",
        default=[],
        dest="pairs",
        help="change a setting, may be given several times",
    )
    render.add_argument("--stats", metavar="STATS.json", type=Path, help="write what it cost")
    render.set_defaults(run=lambda options: _render(render, options))
    _add_paper(commands)
    return parser


def _add_paper(commands) -> None:
    """The command that needs a checkout: the extension comes without paper/."""
    try:
        from ..paper import command
    except ImportError:
        return
    paper = commands.add_parser(
        "paper",
        help="figures of the paper",
        description="Write paper.html: the figures and claims of Huang et al. 2007, by IWIS.",
    )
    command.add_arguments(paper)
    paper.set_defaults(run=lambda options: _paper(command, options))


def _paper(command, options) -> None:
    try:
        print(command.run(options))
    except KeyboardInterrupt:
        raise CommandError("interrupted; the page was not written") from None
    except command.InputError as error:
        raise CommandError(str(error)) from None


def _output(text):
    if Path(text).suffix.lower() not in _FORMATS:
        raise argparse.ArgumentTypeError(f"{text!r} ends in neither {' nor '.join(_FORMATS)}")
    return Path(text)


def _resolution(text):
    match = re.fullmatch(r"(\d+)x(\d+)", text)
    size = tuple(int(number) for number in match.groups()) if match else (0, 0)
    if not all(4 <= number <= 65536 for number in size):  # Blender's own limits
        raise argparse.ArgumentTypeError(f"{text!r} is not WxH with 4 to 65536 pixels a side")
    return size


def _pair(text):
    name, equals, value = text.partition("=")
    if not (name and equals):
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE")
    return name, value


def _render(parser, options) -> None:
    if (options.start is None) != (options.end is None):
        parser.error("-s and -e go together")
    if options.start is not None and options.frame is not None:
        parser.error("-f does not go with -s and -e")
    if options.start is not None and options.start > options.end:
        parser.error(f"there is no frame from {options.start} to {options.end}")
    try:
        settings = settings_from_strings(dict(options.pairs))
    except ValueError as error:
        parser.error(str(error))
    _check_files(options)
    with interrupts() as interrupted:
        try:
            from . import cli_render
        except ImportError as error:
            raise CommandError(f"{error}; install it with: pip install bpy") from None
        file_format = _FORMATS[options.output.suffix.lower()]
        frames = cli_render.render_file(options, settings, file_format, interrupted)
    for frame in frames:
        print(cli_render.describe(frame, options))
    if options.stats is not None:
        _write_stats(options, frames)
    if any(frame.stats.cancelled for frame in frames):
        raise CommandError("cancelled; the picture holds what was done by then")


def _check_files(options) -> None:
    """Find out before the render what would only fail after it."""
    if not options.file.is_file():
        raise CommandError(f"{options.file}: there is no such file")
    for path in filter(None, (options.output, options.stats)):
        if path.is_dir():
            raise CommandError(f"{path}: is a folder: name a file in it")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            probe = path.with_name(f".{path.name}.iwis-probe")
            probe.touch()
            probe.unlink()
        except FileExistsError:
            why = f"{path.parent} is a file, not a folder"
            raise CommandError(f"{path}: cannot be written: {why}") from None
        except OSError as error:
            raise CommandError(f"{path}: cannot be written: {error.strerror}") from None


def _write_stats(options, frames) -> None:
    if options.start is None:
        document = frames[0].stats.to_dict()
    else:
        document = {"frames": [{"frame": f.frame, **f.stats.to_dict()} for f in frames]}
    try:
        options.stats.write_text(json.dumps(document, indent=2) + "\n")
    except OSError as error:
        raise CommandError(f"{options.stats}: cannot be written: {error.strerror}") from None
