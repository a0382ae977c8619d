"""Surfaces that let rays through, and who sees which triangles."""
