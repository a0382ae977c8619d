"""Random scenes out of what is supported, rendered by IWIS and by Cycles: make random-scenes.

A seed is a scene. What differs by more than noise, crashes or warns unforeseen is told with it.
Scenes of --glow show values of nodes in the dark, without noise.
"""
