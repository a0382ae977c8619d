"""The luminance of light, and what of its color that leaves out."""

import numpy as np

from ._jit import kernel

LUMINANCE_R, LUMINANCE_G, LUMINANCE_B = 0.2126, 0.7152, 0.0722  # Rec.709
LUMINANCE = np.array([LUMINANCE_R, LUMINANCE_G, LUMINANCE_B])  # float64: light @ LUMINANCE


@kernel(forceinline=True)
def luminance(r, g, b):
    """Rec.709 luminance, float32."""
    return np.float32(LUMINANCE_R) * r + np.float32(LUMINANCE_G) * g + np.float32(LUMINANCE_B) * b


@kernel(forceinline=True)
def chroma(r, g, b):
    """How far the channels are from grey: the mean square of their differences from luminance,
    each weighed as luminance weighs it. 0 for grey; of light L and color apart, L^2 + chroma is the
    mean square of the channels."""
    y = luminance(r, g, b)
    red, green, blue = r - y, g - y, b - y
    return luminance(red * red, green * green, blue * blue)
