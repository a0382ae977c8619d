"""Linked files that are not there: Blender puts empty data-blocks in place of what they hold."""

from __future__ import annotations

import bpy

_NAMED = 3  # data-blocks of a library; more are counted


def warn_of_missing_libraries(warnings: list[str]) -> None:
    """One line for each library whose file is not there, with what of it is missing."""
    for library in bpy.data.libraries:
        if library.is_missing:
            path = bpy.path.abspath(library.filepath)
            warnings.append(
                f'library "{library.name}": there is no file {path}; {_what(library)} missing: '
                "put it there, or relocate the library"
            )


def _what(library) -> str:
    names = [f'{block.id_type.capitalize()} "{block.name}"' for block in library.users_id]
    if not names:
        return "nothing that is used is"
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return f"{', '.join(names[:_NAMED])}{more} {'is' if len(names) == 1 else 'are'}"
