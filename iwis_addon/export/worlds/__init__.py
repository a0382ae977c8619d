"""A world's tree to a map, or to a program over directions."""
