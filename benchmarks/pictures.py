"""Arrays to PNG and JPEG, for the eye."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np


def difference_picture(difference, gain: float) -> np.ndarray:
    """float64 (h, w, 3): white where equal, red where brighter than the other, blue where darker.

    difference: relative, (h, w); gain: 1 / the difference that is shown in full colour
    """
    amount = np.clip(difference * gain, -1.0, 1.0)
    red, green, blue = (
        1.0 + np.minimum(amount, 0.0),
        1.0 - abs(amount),
        1.0 - np.maximum(amount, 0.0),
    )
    return np.stack([red, green, blue], -1)


def developed(rgb, white: float) -> np.ndarray:
    """float64 (h, w, 3), encoded for a screen, of radiance; white: the radiance shown as white."""
    return np.clip(np.asarray(rgb, np.float64) / white, 0.0, 1.0) ** (1.0 / 2.2)


def heat_picture(values, low: float, high: float) -> np.ndarray:
    """float64 (h, w, 3): black, red, yellow, white as values (h, w) go from low to high."""
    amount = 3.0 * np.clip((values - low) / (high - low), 0.0, 1.0)
    return np.clip(np.stack([amount, amount - 1.0, amount - 2.0], -1), 0.0, 1.0)


def save_png(path: Path, *panels, zoom: int = 1) -> None:
    """Write pictures (h, w, 3) of encoded colour, row 0 at the bottom, side by side."""
    rgb = np.concatenate(panels, axis=1).repeat(zoom, axis=0).repeat(zoom, axis=1)
    height, width = rgb.shape[:2]
    image = bpy.data.images.new(path.stem, width, height)
    try:
        pixels = np.ones((height, width, 4), np.float32)
        pixels[..., :3] = rgb
        image.pixels.foreach_set(pixels.ravel())
        image.file_format, image.filepath_raw = "PNG", str(path)
        image.save()
    finally:
        bpy.data.images.remove(image)


def save_jpeg(path: Path, *panels, names, height: int = 360, most_bytes: int = 110_000) -> None:
    """Write pictures as save_png(), each with its name above, no larger than most_bytes.

    height: of a picture in pixels, about: pixels are shown as squares of a whole side
    """
    from PIL import Image, ImageDraw  # comes with matplotlib, the extra "bench"

    zoom = max(1, height // panels[0].shape[0])
    rgb = np.concatenate(panels, axis=1)[::-1].repeat(zoom, axis=0).repeat(zoom, axis=1)
    picture = Image.fromarray((rgb * 255.0 + 0.5).astype(np.uint8))
    sheet = Image.new("RGB", (picture.width, picture.height + 16), "white")
    sheet.paste(picture, (0, 16))
    draw, x = ImageDraw.Draw(sheet), 0
    for panel, name in zip(panels, names, strict=True):
        draw.text((x + 4, 2), name, fill="black")
        x += panel.shape[1] * zoom
    for quality in range(92, 20, -6):
        sheet.save(path, quality=quality, subsampling=0)
        if path.stat().st_size <= most_bytes:
            return
