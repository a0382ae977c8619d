"""OpenEXR files with layers and parts: each channel is random numbers of its own."""

import numpy as np
import OpenEXR


def _planes(names, dtype, seed, width, height):
    """{name: (h, w), row 0 at the top}; alpha is the largest of a pixel."""
    rng = np.random.default_rng(seed)
    return {
        name: (rng.uniform(0.6, 1.0, (height, width)) if name.endswith("A") else drawn).astype(
            dtype
        )
        for name in names
        for drawn in [rng.uniform(0.1, 0.6, (height, width))]
    }


def _header(tiled=False, window=None, width=0, height=0):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    if tiled:
        header["type"], header["tiles"] = OpenEXR.tiledimage, OpenEXR.TileDescription()
    if window is not None:  # the data begins here, and something is round it
        x, y = window
        last = x + width - 1, y + height - 1
        around = last[0] + 5, last[1] + 4
        header["dataWindow"] = np.array([x, y], np.int32), np.array(last, np.int32)
        header["displayWindow"] = np.zeros(2, np.int32), np.array(around, np.int32)
    return header


def write_layers(
    path,
    layers,
    seed=0,
    dtype=np.float32,
    views=False,
    tiled=False,
    window=None,
    width=16,
    height=12,
):
    """One part. layers: name -> a letter a channel; returns the channels written, by name."""
    names = [".".join(filter(None, (name, c))) for name in layers for c in layers[name]]
    planes = _planes(names, dtype, seed, width, height)
    header = _header(tiled, window, width, height)
    if views:
        header["multiView"] = ["left", "right"]
    OpenEXR.File(header, dict(planes)).write(str(path))
    return planes


def write_parts(path, parts, seed=0, dtype=np.float32, views=(), width=16, height=12):
    """A part for each: name -> a letter a channel. views: of the parts; returns [its channels]"""
    planes = [
        _planes(letters, dtype, seed + 100 * n, width, height)
        for n, letters in enumerate(parts.values())
    ]
    made = []
    for n, name in enumerate(parts):
        header = {**_header(), "name": name, **({"view": views[n]} if views else {})}
        made.append(OpenEXR.Part(header, dict(planes[n])))
    OpenEXR.File(made).write(str(path))
    return planes
