"""From a place in the picture to a ray, and back."""
