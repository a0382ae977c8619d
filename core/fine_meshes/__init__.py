"""Meshes made finer, and moved: subdivision, dicing, displacement."""
