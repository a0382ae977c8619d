"""What stands where: instances, and the scene's one table of triangles."""
