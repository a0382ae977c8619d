"""Copies an HDRI without the negative radiance that lossy compression left in it.

    python sample_blends/repair_hdri.py SOURCE.exr sample_blends/hdri/NAME.exr

The HDRIs of @pmndrs/assets are DWAB compressed: round a lamp or the sun the codec overshoots, down
to -3900 in one channel, which no light has and which no importance sampling can follow. A pixel
with a negative channel becomes the grey of the same mean, or black; the rest stays, bit for bit.
"""

import sys

import numpy as np
import OpenEXR


def repair(radiance):
    """Radiance (h, w, 3) without negative values, as float16."""
    broken = (radiance < 0.0).any(axis=2)
    grey = np.maximum(radiance[broken].astype(np.float64).mean(axis=1), 0.0)
    repaired = radiance.copy()
    repaired[broken] = grey[:, None]
    return repaired.astype(np.float16)


def main(source, destination):
    """Write the repaired copy of the file `source`, half float, ZIP compressed."""
    with OpenEXR.File(source) as file:
        radiance = repair(file.channels()["RGB"].pixels)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": radiance}).write(destination)


if __name__ == "__main__":
    main(*sys.argv[1:])
