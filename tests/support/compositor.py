"""The compositor of the open scene, which Blender 5 keeps elsewhere than 4."""

import bpy

IS_5 = bpy.app.version >= (5, 0, 0)


def empty_tree(scene):
    """A tree without nodes, which the scene has from now on."""
    if IS_5:
        tree = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
        scene.compositing_node_group = tree
        return tree
    scene.use_nodes = True
    scene.node_tree.nodes.clear()
    return scene.node_tree


def sockets_by_engine(scene, engines=("CYCLES", "IWIS")) -> dict:
    """Engine -> {name: type} of the sockets that a Render Layers node has with it."""
    node, found = empty_tree(scene).nodes.new("CompositorNodeRLayers"), {}
    for engine in engines:
        scene.render.engine = engine
        scene.view_layers[0].update_render_passes()
        found[engine] = {out.name: out.type for out in node.outputs if out.enabled}
    return found
