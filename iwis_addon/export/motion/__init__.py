"""The scene at other times: camera, objects and shapes while the shutter is open."""
