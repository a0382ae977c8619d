"""A stand-in for Blender's layouts, which background mode has none of."""

import types

import bpy


class Layout:
    """A UILayout that checks what it is given: properties and operators that exist."""

    def __init__(self):
        self.drawn = []

    def prop(self, owner, name, **_options):
        assert name in owner.bl_rna.properties, (owner, name)
        self.drawn.append(name)

    def operator(self, name, **_options):
        module, _, own = name.partition(".")
        assert own in dir(getattr(bpy.ops, module)), name
        self.drawn.append(name)
        return types.SimpleNamespace()

    def prop_search(self, owner, name, search_owner, search_name, **_options):
        assert search_name in search_owner.bl_rna.properties, (search_owner, search_name)
        self.prop(owner, name)

    def template_list(self, _kind, _id, owner, name, active_owner, active, **_options):
        assert active in active_owner.bl_rna.properties, (active_owner, active)
        self.prop(owner, name)

    def menu(self, name, **_options):
        assert hasattr(bpy.types, name), name

    def separator(self):
        pass

    template_curve_mapping = prop

    def template_node_view(self, tree, node, socket):
        assert node.name in tree.nodes and socket.node == node
        self.drawn.append("nodes")

    def template_icon_view(self, owner, name, **_options):
        self.prop(owner, name)

    def template_preview(self, data):
        assert data is None or isinstance(data, bpy.types.ID)
        self.drawn.append("preview")

    def label(self, text="", icon="NONE"):
        self.drawn.append(text)

    def row(self, **_options):
        return self

    column = split = row
