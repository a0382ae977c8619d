"""Lobes.rough[3] below 0: what stands in the place of a Lambert lobe; above it is a roughness.

sheen.py has MICROFIBER and VELVET, toon.py what is toon, hair.py the others. What is at most VELVET
is glossy, as in Cycles, but for TRANSLUCENT_ROUND. PHONG stands in the place of the glossy lobe
(ashikhmin_shirley.py).
"""

from __future__ import annotations

import numpy as np

MICROFIBER, DIFFUSE_TOON = np.float32(-1.0), np.float32(-2.0)
VELVET, GLOSSY_TOON = np.float32(-3.0), np.float32(-4.0)
PHONG = np.float32(-5.0)
# What is at most HAIR has rays that start elsewhere.
CHIANG, HAIR_REFLECTION, HAIR_TRANSMISSION = np.float32(-8.0), np.float32(-9.0), np.float32(-10.0)
TRANSLUCENT_ROUND = np.float32(-11.0)
HAIR = CHIANG
