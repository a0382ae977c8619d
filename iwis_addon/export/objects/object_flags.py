"""Which rays see an object, and what it is to the picture: Scene.object_flags as Cycles has them.

Of an instance its instancer counts as well: rays see it if they see both; a shadow catcher is what
either of them is; a holdout, and what the camera does not see for its collection is Indirect Only,
is what the instancer is alone.
"""

from __future__ import annotations

from ....core.scene import CAMERA_RAYS, HOLDOUT, SHADOW_CATCHER, SHADOW_RAYS


def flags_of(obj, instancer, view_layer) -> int:
    """Of Scene.object_flags. All evaluated; instancer: the object itself where nothing made it;
    view_layer: says of which collections it makes holdouts, or Indirect Only."""
    holdout = instancer.holdout_get(view_layer=view_layer)
    hidden = not holdout and instancer.indirect_only_get(view_layer=view_layer)
    flags = (
        (obj.visible_camera and instancer.visible_camera and not hidden, CAMERA_RAYS),
        (obj.visible_shadow and instancer.visible_shadow, SHADOW_RAYS),
        (holdout, HOLDOUT),
        (obj.is_shadow_catcher or instancer.is_shadow_catcher, SHADOW_CATCHER),
    )
    return sum(bit for there, bit in flags if there)
