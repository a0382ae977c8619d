"""What red, green and blue bring of luminance, for those who must do without numba."""

import numpy as np

LUMINANCE_R, LUMINANCE_G, LUMINANCE_B = 0.2126, 0.7152, 0.0722  # Rec.709
LUMINANCE = np.array([LUMINANCE_R, LUMINANCE_G, LUMINANCE_B])  # float64: light @ LUMINANCE
