"""Materials at shading points: programs evaluated, closures mixed."""
