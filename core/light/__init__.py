"""The world's light: a map, its quadtree, and how a sample finds its texel."""
