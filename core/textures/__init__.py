"""Noise, cells and images at many places: kernels of core/nodes."""
