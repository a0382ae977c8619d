"""Worlds with light below 0, which takes away: filters leave it round the sun of many an HDRI."""

import bpy
import numpy as np

from .cases import world


def _ringing(tree, **settings):
    """A sun of one texel, and round it what a sharp filter leaves: a tenth of its light, below 0.

    Its channels differ in where they are below 0.
    """
    pixels = np.full((64, 128, 4), 0.1, np.float32)
    pixels[47:50, 50:53, :3] = (-4.0, 0.5, -3.0)
    pixels[48, 51, :3], pixels[..., 3] = (300.0, 280.0, 250.0), 1.0
    pixels[20:24, 90:96, :3] = (0.3, -1.0, 0.6)
    image = bpy.data.images.new("Ringing", 128, 64, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return tree.made("ShaderNodeTexEnvironment", 0, image=image, **settings)


def _background(tree, color, strength=1.0):
    return tree.made("ShaderNodeBackground", 0, {"Color": color, "Strength": strength})


def _less(tree, color, by):
    values = {0: color, 1: (by, by, by)}
    return tree.made("ShaderNodeVectorMath", 0, values, operation="SUBTRACT")


def _noise(tree):
    inputs = {"Vector": tree.coordinates("Generated"), "Scale": 2.0}
    return tree.made("ShaderNodeTexNoise", "Color", inputs)


world("World, picture with light below 0", lambda t: _background(t, _ringing(t)))
world(
    "World, picture with light below 0, cubic",
    lambda t: _background(t, _ringing(t, interpolation="Cubic")),
)
world("World, picture less a grey", lambda t: _background(t, _less(t, _ringing(t), 0.04), 2.0))
world("World, noise less a grey", lambda t: _background(t, _less(t, _noise(t), 0.35), 3.0))
world("World, negative strength", lambda t: _background(t, _ringing(t), -1.0))
world("World, colour below 0", lambda t: _background(t, _less(t, (0.2, 0.5, 0.9), 0.4), 2.0))
