"""The luminance of light, and what of its color that leaves out."""

import numpy as np

from .._jit import kernel
from ..data.channels import LUMINANCE_B, LUMINANCE_G, LUMINANCE_R


@kernel(forceinline=True)
def luminance(r, g, b):
    """Rec.709 luminance, float32."""
    return np.float32(LUMINANCE_R) * r + np.float32(LUMINANCE_G) * g + np.float32(LUMINANCE_B) * b


@kernel(forceinline=True)
def magnitude(r, g, b):
    """Luminance of light whose channels may be negative, as if none were: 0 of black alone."""
    return luminance(abs(r), abs(g), abs(b))


@kernel(forceinline=True)
def chroma(r, g, b):
    """How far the channels are from grey: the mean square of their differences from luminance,
    each weighed as luminance weighs it. 0 for grey; of light L and color apart, L^2 + chroma is the
    mean square of the channels."""
    y = luminance(r, g, b)
    red, green, blue = r - y, g - y, b - y
    return luminance(red * red, green * green, blue * blue)
