"""The work at a tile, from rays to layers, and its budget."""
