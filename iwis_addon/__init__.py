"""Everything that Blender calls."""

# The name Blender gave the add-on: "iwis", or "bl_ext.user_default.iwis" as an extension.
ADDON_ID = __package__.rpartition(".")[0]
