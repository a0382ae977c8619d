"""The packages that rendering needs beside Blender's own, and what to say when one is missing."""

from __future__ import annotations

import importlib.util
import logging
import os
import platform
import sys

log = logging.getLogger(__name__)

NEEDED = ("numba", "embreex")


class MissingPackage(Exception):
    """A package is not there, or does not load; the text says what to do."""


def missing() -> list[str]:
    """Names of NEEDED that this Python does not find. Looks, but imports nothing."""
    return [name for name in NEEDED if importlib.util.find_spec(name) is None]


def advice() -> list[str]:
    """Lines that tell a user what is missing and what to do; none when all is there."""
    names = missing()
    if not names:
        return []
    python = f"{sys.version_info.major}{sys.version_info.minor}"
    build = f"{platform.system()} {platform.machine()}, Python cp{python}"
    many = len(names) > 1
    return [
        f"IWIS cannot render: the Python {'packages' if many else 'package'} "
        f"{' and '.join(names)} {'are' if many else 'is'} missing.",
        f"Install the IWIS extension zip built for {build}; it brings what is needed.",
    ]


def require() -> None:
    """Import what rendering needs. Raises MissingPackage with what to do."""
    lines = advice()
    if lines:
        raise MissingPackage(" ".join(lines))
    for name in NEEDED:
        try:
            importlib.import_module(name)
        except ImportError as error:
            raise MissingPackage(
                f"IWIS cannot render: the Python package {name} does not load ({error}). "
                "Install the IWIS extension zip built for this Blender and this system."
            ) from error
        except Exception as error:  # numba reads the environment, and refuses some of it
            told = [f"{key}={value}" for key, value in os.environ.items() if key[:6] == "NUMBA_"]
            raise MissingPackage(
                f"IWIS cannot render: the Python package {name} does not load "
                f"({type(error).__name__}: {str(error).strip()}). Unset what is wrong of the "
                f"environment: {', '.join(told) or 'no variable NUMBA_... is set'}."
            ) from error


def warn() -> None:
    """Say on stderr what is missing, where a farm that unpacks the add-on by hand sees it."""
    lines = advice()
    if lines:
        log.warning(" ".join(lines))
