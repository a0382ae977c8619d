"""The light of lamps, and of faces that shine: their shapes, their samples."""
