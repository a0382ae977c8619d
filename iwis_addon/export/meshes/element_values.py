"""What materials ask of points and strands: attributes, UV maps and what shader nodes tell of them.

A source has rows (one a point, or one a ring of a tube); a corner of a triangle names its row
(LocalMesh.corners). Names are those of surface_data.py, and

    element:NAME   the output of that name of the nodes Curves Info and Point Info
                   (element_info.py), and of a mesh of the Geometry node (mesh_shape.py)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....core.nodes.hashing import hash_words
from .local_mesh import LocalMesh

# Types of attributes: name of the value, its width, dtype.
READ = {
    "FLOAT": ("value", 1, np.float32),
    "INT": ("value", 1, np.int32),
    "INT8": ("value", 1, np.int32),
    "BOOLEAN": ("value", 1, bool),
    "FLOAT2": ("vector", 2, np.float32),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color", 4, np.float32),
}


def read_values(collection, name, width, dtype) -> np.ndarray:
    """(n, width): a property of all elements of a bpy collection."""
    values = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, values)
    return values.reshape(-1, width)


def attribute_of(data, name, kind=None, domain=None):
    """A bpy attribute that can be read and has the kind and domain, or None."""
    attribute = data.attributes.get(name)
    if attribute is None or attribute.data_type not in READ:
        return None
    if kind not in (None, attribute.data_type) or domain not in (None, attribute.domain):
        return None
    return attribute


def attribute_values(attribute) -> np.ndarray:
    """float32 (n, width)"""
    return read_values(attribute.data, *READ[attribute.data_type]).astype(np.float32)


def random_of_words(words: np.ndarray) -> np.ndarray:
    """float32 (n, 1) in [0, 1] of hashes, uint32 (n,)."""
    return (words / np.float64(0xFFFFFFFF)).astype(np.float32)[:, None]


def random_of_rows(n: int) -> np.ndarray:
    """float32 (n, 1): what Cycles gives points and strands by their number."""
    return random_of_words(hash_words(np.arange(n, dtype=np.uint32), np.zeros(n, np.uint32)))


class ElementReader(NamedTuple):
    """Values at the corners of a part's triangles. source: with ``rows(name)``"""

    source: object
    local: LocalMesh

    def read(self, name: str) -> np.ndarray | None:
        """float32 (m, 3, width), or None where there is nothing of this name."""
        values = self.source.rows(name)
        if values is not None:
            return np.take(values, self.local.corners, axis=0, mode="clip")
        # As in Cycles, what has no generated coordinates has those of its object.
        return self.local.positions[self.local.triangles] if name == "generated" else None
