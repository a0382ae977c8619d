"""Data-blocks that are there for a moment, in the middle of a render too."""

from __future__ import annotations

from contextlib import contextmanager


@contextmanager
def scratch(collection, block):
    """A data-block that nobody uses, removed from its collection of bpy.data in the end.

    It is not unlinked first: that has the relations of all graphs built anew, and Blender 5.2 ends
    with a crash where it does so in the middle of an animation, at the next frame.
    """
    try:
        yield block
    finally:
        collection.remove(block, do_unlink=False)
