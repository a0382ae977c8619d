"""Files that hold the paper's data: Wavefront meshes, Radiance and OpenEXR probes."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ..core.exr import read_exr_layers
from ..core.scene import EnvironmentMap, TriangleMesh


def read_probe(path: Path) -> EnvironmentMap:
    """A lat-long panorama, .hdr or .exr.

    Raises OSError or ValueError with the path and what is wrong.
    """
    if path.suffix.lower() == ".hdr":
        radiance = read_hdr(path)
    else:
        layers = read_exr_layers(path)
        rgb = next((a[..., :3] for a in layers.values() if a.shape[2] >= 3), None)
        if rgb is None:
            raise ValueError(f"{path}: has no layer with red, green and blue")
        radiance = np.ascontiguousarray(rgb, np.float32)
    return EnvironmentMap(radiance=np.maximum(radiance, 0.0), name=path.name)


def read_hdr(path: Path) -> np.ndarray:
    """The radiance of a Radiance RGBE picture, float32 (h, w, 3), row 0 at the bottom.

    Runs as new pictures have them (each scanline, a channel after the other), or none.
    """
    data = path.read_bytes()
    header = re.match(rb"#\?.*?\n\n-Y (\d+) \+X (\d+)\n", data, re.DOTALL)
    if header is None:
        raise ValueError(f"{path}: is no Radiance picture whose rows go down (-Y +X)")
    height, width = int(header[1]), int(header[2])
    body = np.frombuffer(data, np.uint8, offset=header.end())
    if body[:2].tolist() == [2, 2] and 8 <= width < 32768:
        rgbe = _unpack_runs(path, body, height, width)
    elif len(body) == 4 * height * width:
        rgbe = body.reshape(height, width, 4)
    else:
        raise ValueError(f"{path}: is cut off, or packed as only old pictures are")
    scale = np.ldexp(np.float32(1.0), rgbe[..., 3].astype(np.int32) - (128 + 8))
    scale = np.where(rgbe[..., 3] > 0, scale, 0.0)
    return np.ascontiguousarray((rgbe[..., :3] * scale[..., None])[::-1], np.float32)


def _unpack_runs(path, body, height, width) -> np.ndarray:
    rgbe = np.empty((height, width, 4), np.uint8)
    at = 0
    try:
        for row in range(height):
            if body[at : at + 4].tolist() != [2, 2, width >> 8, width & 255]:
                raise ValueError(f"{path}: row {row} does not begin as a packed row")
            at += 4
            for channel in range(4):
                x = 0
                while x < width:
                    count = int(body[at])
                    run = count > 128
                    count -= 128 * run
                    rgbe[row, x : x + count, channel] = body[
                        at + 1 : at + 2 + (count - 1) * (not run)
                    ]
                    at, x = at + 1 + (1 if run else count), x + count
    except (IndexError, ValueError) as error:
        if str(path) in str(error):
            raise
        raise ValueError(f"{path}: is cut off in row {row} of {height}") from None
    return rgbe


def read_obj(path: Path) -> TriangleMesh:
    """The faces of a Wavefront file with y up, as one smooth object with z up.

    Polygons are cut into fans. Raises OSError or ValueError with the path and what is wrong.
    """
    vertices, faces = [], []
    with path.open() as file:
        for line in file:
            words = line.split()
            if not words:
                continue
            if words[0] == "v":
                vertices.append([float(word) for word in words[1:4]])
            elif words[0] == "f":
                corners = [int(word.partition("/")[0]) for word in words[1:]]
                corners = [k - 1 if k > 0 else len(vertices) + k for k in corners]
                faces += [[corners[0], *corners[k : k + 2]] for k in range(1, len(corners) - 1)]
    if not faces:
        raise ValueError(f"{path}: has no faces")
    triangles = np.array(faces, np.int32)
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise ValueError(f"{path}: a face names a vertex that is not there")
    x, y, z = np.array(vertices, np.float64).T
    return smooth_mesh(np.stack([x, -z, y], -1), triangles)


def smooth_mesh(vertices: np.ndarray, triangles: np.ndarray) -> TriangleMesh:
    """One object of one material; normals at vertices: those of the faces there, by area."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    keep = np.einsum("ij,ij->i", face, face) > 0.0
    triangles, face = triangles[keep], face[keep]
    normals = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(normals, triangles[:, k], face)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0.0)
    zeros = np.zeros(len(triangles), np.int32)
    return TriangleMesh(
        vertices=vertices.astype(np.float32),
        triangles=triangles.astype(np.int32),
        corner_normals=np.ascontiguousarray(normals[triangles], np.float32),
        material_index=zeros,
        object_index=zeros,
    )
