"""A movie as a file: AVI without compression, which any FFmpeg reads."""

import struct

import numpy as np


def _chunk(name: bytes, data: bytes) -> bytes:
    return name + struct.pack("<I", len(data)) + data + b"\0" * (len(data) % 2)


def _list(name: bytes, *chunks: bytes) -> bytes:
    return _chunk(b"LIST", name + b"".join(chunks))


def write_movie(path, frames) -> None:
    """frames: uint8 (n, h, w, 3), row 0 at the bottom, w a multiple of 4; at 24 a second"""
    n, height, width, _ = frames.shape
    size = width * height * 3
    header = struct.pack("<10I16x", 41667, size * 24, 0, 16, n, 0, 1, size, width, height)
    stream = struct.pack(
        "<4s4sI2H8I4H", b"vids", b"DIB ", 0, 0, 0, 0, 1, 24, 0, n, size, 0, 0, 0, 0, width, height
    )
    bitmap = struct.pack("<I2i2H6I", 40, width, height, 1, 24, 0, size, 0, 0, 0, 0)
    pictures = [np.ascontiguousarray(frame[..., ::-1]).tobytes() for frame in frames]
    entries = (struct.pack("<4s3I", b"00db", 16, 4 + k * (size + 8), size) for k in range(n))
    streams = _list(b"strl", _chunk(b"strh", stream), _chunk(b"strf", bitmap))
    movie = _list(b"movi", *(_chunk(b"00db", picture) for picture in pictures))
    whole = _list(b"hdrl", _chunk(b"avih", header), streams) + movie
    whole += _chunk(b"idx1", b"".join(entries))
    path.write_bytes(_chunk(b"RIFF", b"AVI " + whole))
