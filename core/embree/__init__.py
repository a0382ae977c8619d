"""Rays against triangles by Embree; accel.py is the door to it."""
