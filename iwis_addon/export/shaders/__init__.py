"""Trees of nodes to closures and programs."""
