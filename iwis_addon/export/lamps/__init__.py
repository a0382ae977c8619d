"""Blender's lights to rows of lamps, with their pictures."""
