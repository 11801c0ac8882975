"""What places instances: geometry nodes on a grid."""

import bpy


def new_tree(name):
    """A geometry node tree that changes its input."""
    tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    return tree, tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")


def on_points(owner, what, as_instance):
    """`what` on each of the owner's vertices, each with a "tint" of its own, by geometry nodes."""
    tree, start, end = new_tree(f"On points {as_instance}")
    place, info = (
        tree.nodes.new(kind) for kind in ("GeometryNodeInstanceOnPoints", "GeometryNodeObjectInfo")
    )
    info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = what, as_instance
    store, position = (
        tree.nodes.new(kind) for kind in ("GeometryNodeStoreNamedAttribute", "GeometryNodeInputPosition")
    )
    store.domain, store.data_type, store.inputs["Name"].default_value = "INSTANCE", "FLOAT_VECTOR", "tint"
    for source, target in (
        (start.outputs[0], place.inputs["Points"]),
        (info.outputs["Geometry"], place.inputs["Instance"]),
        (place.outputs[0], store.inputs["Geometry"]),
        (position.outputs[0], store.inputs["Value"]),
        (store.outputs[0], end.inputs[0]),
    ):
        tree.links.new(source, target)
    owner.modifiers.new("On points", "NODES").node_group = tree


def grid(name, place, **settings):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=2, y_subdivisions=2, size=1.6, location=place)
    owner = bpy.context.object
    owner.name = name
    owner.rotation_euler = (1.2, 0.1, 0.3)
    for key, value in settings.items():
        setattr(owner, key, value)
    return owner
