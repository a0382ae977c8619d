"""What IWIS' panels share."""

from __future__ import annotations

import textwrap
from typing import ClassVar

from .job import ENGINE


class IWISPanel:
    """A panel of the render tab, for this engine only."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES: ClassVar[set[str]] = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES

    def split_layout(self):
        """The panel's layout with labels on the left."""
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        return self.layout


def draw_light_group(layout, owner, view_layer) -> None:
    """The name of the light group that an object or a world is in, and a button that makes it."""
    names = {group.name for group in view_layer.lightgroups}
    row = layout.row(align=True)
    found = view_layer, "lightgroups"
    row.prop_search(owner, "lightgroup", *found, text="Light Group", results_are_suggestions=True)
    sub = row.column(align=True)
    sub.enabled = bool(owner.lightgroup) and owner.lightgroup not in names
    sub.operator("scene.view_layer_add_lightgroup", icon="ADD", text="").name = owner.lightgroup


def wrapped(layout, context, text: str, icon: str) -> None:
    """A text in as many labels as the panel's width asks for: Blender would cut it off."""
    region = context.region
    scale = context.preferences.system.ui_scale or 1.0  # 0 in background mode
    width = region.width if region is not None else 300
    # Beside a text are its icon, a button and the panel's edges.
    letters = max(int((width / scale - 120) / 6.2), 12)
    column = layout.column(align=True)
    column.scale_y = 0.8
    for number, line in enumerate(textwrap.wrap(text, letters)):
        column.label(text=line, icon=icon if number == 0 else "BLANK1")
