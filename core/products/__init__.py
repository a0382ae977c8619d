"""Light x BSDF at a shading point, and points that are warped by it."""
