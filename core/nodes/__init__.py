"""Shader nodes over the points of a tile, in NumPy: core.program's operations become values.

values       arithmetic of numbers (n,) and vectors (n, 3)
context      what a node may ask of the points
places       where these lie on triangles
coordinates, images, arithmetic, color, normals, noise, gabor, voronoi, patterns,
element_info, hair_info, metals, ies, falloff, near, wireframe, wavelength
             the nodes, one file a family
evaluate     a program's operations in their order
world        what a node may ask of a direction that meets nothing
world_map    a world's program over all directions
lamp_map     a lamp's program over the lamp
"""

from .context import ShadeContext
from .evaluate import FUNCTIONS, Evaluation, surface_evaluation

__all__ = ["FUNCTIONS", "Evaluation", "ShadeContext", "surface_evaluation"]
