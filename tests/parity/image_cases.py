"""Image Texture: projections, interpolation, extension, alpha, colour spaces."""

from .cases import shown
from .scene import picture


def _image(
    interpolation="Linear",
    extension="REPEAT",
    projection="FLAT",
    alpha=False,
    output=0,
    space="sRGB",
    scale=2.3,
    float_buffer=False,
    **properties,
):
    def make(tree):
        image = picture(alpha=alpha, float_buffer=float_buffer)
        image.colorspace_settings.name = space
        for name in [n for n in properties if n == "alpha_mode"]:
            image.alpha_mode = properties[name]
        node = tree.node(
            "ShaderNodeTexImage",
            image=image,
            interpolation=interpolation,
            extension=extension,
            projection=projection,
        )
        node.projection_blend = properties.get("blend", 0.0)
        place = tree.coordinates("UV" if projection == "FLAT" else "Generated")
        scaled = tree.made("ShaderNodeVectorMath", 0, {0: place, "Scale": scale}, operation="SCALE")
        moved = tree.made("ShaderNodeVectorMath", 0, {0: scaled, 1: (-0.4, -0.3, -0.2)})
        tree.link(moved, node.inputs[0])
        return node.outputs[output]

    return make


for _kind in ("Linear", "Closest", "Cubic"):
    for _outside in ("REPEAT", "EXTEND", "CLIP", "MIRROR"):
        shown(f"Image Texture {_kind} {_outside}", _image(_kind, _outside))
for _projection in ("BOX", "SPHERE", "TUBE"):
    shown(f"Image Texture {_projection}", _image(projection=_projection))
shown("Image Texture BOX blended", _image(projection="BOX", blend=0.4))
for _space in ("Non-Color", "Linear Rec.709"):
    shown(f"Image Texture {_space}", _image(space=_space))
for _mode in ("STRAIGHT", "CHANNEL_PACKED", "NONE", "PREMUL"):
    shown(f"Image Texture colour, alpha {_mode}", _image(alpha=True, alpha_mode=_mode))
    shown(f"Image Texture alpha {_mode}", _image(alpha=True, alpha_mode=_mode, output=1))
shown("Image Texture float", _image(float_buffer=True, space="Linear Rec.709"))
shown("Image Texture, no coordinates", lambda t: t.made("ShaderNodeTexImage", 0, image=picture()))
shown("Image Texture, no image", lambda t: t.made("ShaderNodeTexImage", 0), warns="no image")
