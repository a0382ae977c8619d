"""What one object shows, in its own space: meshes, diced ones, points and strands."""
