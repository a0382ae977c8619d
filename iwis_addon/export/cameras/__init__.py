"""Cameras, and what they see of a picture."""
