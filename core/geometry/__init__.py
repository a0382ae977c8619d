"""Shading points on triangles: places, normals, shapes at one time."""
