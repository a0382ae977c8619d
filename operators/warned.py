"""What the warnings panel offers: to select what a warning names, to copy all of them."""

import bpy
from bpy.props import IntProperty

from ..iwis_addon.notices import last_lines, last_notices, objects_named_in


def _has_warnings(operator) -> bool:
    if last_lines():
        return True
    operator.poll_message_set("Nothing to warn of in the last render and in the rendered views")
    return False


class IWIS_OT_select_warned(bpy.types.Operator):
    """Select the objects that a warning names"""

    bl_idname = "iwis.select_warned"
    bl_label = "Select Warned Objects"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    number: IntProperty(name="Number", description="Which of the warnings, from 0", min=0)

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT":
            cls.poll_message_set("Objects can be selected in Object Mode only")
            return False
        return _has_warnings(cls)

    def execute(self, context):
        notices = last_notices()
        if self.number >= len(notices):
            self.report({"ERROR"}, "There is no such warning any more")
            return {"CANCELLED"}
        found = select_named(context.view_layer, notices[self.number].lines)
        if not found:
            self.report({"INFO"}, "The warning names no object of this view layer")
            return {"CANCELLED"}
        self.report({"INFO"}, f"Selected {', '.join(thing.name for thing in found[:5])}")
        return {"FINISHED"}


def select_named(view_layer, lines: list[str]) -> list:
    """Select the objects of a view layer that the lines name, and nothing else; return them."""
    found = [thing for thing in objects_named_in(lines, view_layer.objects)]
    found = [thing for thing in found if thing.visible_get(view_layer=view_layer)]
    if found:
        for thing in view_layer.objects:
            thing.select_set(False, view_layer=view_layer)
        for thing in found:
            thing.select_set(True, view_layer=view_layer)
        view_layer.objects.active = found[0]
    return found


class IWIS_OT_copy_warnings(bpy.types.Operator):
    """Copy all warnings, each line with how often it came, to the clipboard"""

    bl_idname = "iwis.copy_warnings"
    bl_label = "Copy Warnings"

    @classmethod
    def poll(cls, _context):
        if bpy.app.background:
            cls.poll_message_set("There is no clipboard in background mode; see the log")
            return False
        return _has_warnings(cls)

    def execute(self, context):
        context.window_manager.clipboard = warnings_text()
        self.report({"INFO"}, "The warnings are in the clipboard")
        return {"FINISHED"}


def warnings_text() -> str:
    """All warnings, one a line, in their order."""
    lines = last_lines()
    return "\n".join(
        f"{line} (x {lines.count(line)})" if lines.count(line) > 1 else line
        for line in dict.fromkeys(lines)
    )


CLASSES = (IWIS_OT_select_warned, IWIS_OT_copy_warnings)
