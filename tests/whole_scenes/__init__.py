"""Blender's own templates, assets and add operators as scenes, beside Cycles: make whole-scenes."""
