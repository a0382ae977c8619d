"""Texels of images, skies, black bodies and luminaires' files."""
