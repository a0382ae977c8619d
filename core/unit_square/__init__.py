"""Points that fill the unit square evenly, and the sphere as such a square."""
