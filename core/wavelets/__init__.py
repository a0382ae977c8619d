"""Sparse Haar series: transform, product, and tables of them on disk."""
