"""Attributes of instances that geometry nodes make: each has its own, however nested it is and numbered."""

import pytest

bpy = pytest.importorskip("bpy")
import numpy as np  # noqa: E402
from support.bpy_scenes import add, empty_scene, export  # noqa: E402
from support.instancers import grid, new_tree  # noqa: E402
from support.seen_room import material  # noqa: E402

FAR = 8.0  # between outer instances
EVEN, DOUBLE = "EVEN", "DOUBLE"  # ids 7, 9, 11 ...; ids that several instances share


def node(tree, kind, **inputs):
    """A geometry node; inputs are values, or the node whose first output they take."""
    made = tree.nodes.new(kind if kind.startswith("Shader") else f"GeometryNode{kind}")
    for key, value in inputs.items():
        if isinstance(value, bpy.types.Node):
            tree.links.new(value.outputs[0], made.inputs[key.replace("_", " ")])
        else:
            made.inputs[key.replace("_", " ")].default_value = value
    return made


def number(tree, operation, value):
    made = node(tree, "ShaderNodeMath")
    made.operation, made.inputs[1].default_value = operation, value
    tree.links.new(node(tree, "InputIndex").outputs[0], made.inputs[0])
    return made


def tinted():
    """A material that reads what the instance has as "tint"."""
    made = material("Tinted", "Emission")
    tree = made.node_tree
    read = tree.nodes.new("ShaderNodeAttribute")
    read.attribute_name, read.attribute_type = "tint", "INSTANCER"
    tree.links.new(read.outputs["Color"], tree.nodes["Emission"].inputs["Color"])
    return made


def scattered(ids="", nested=False, parts=False):
    """Balls on a grid whose tint is their place there; the whole perhaps on two points, FAR apart."""
    owner = grid("Grid", (0, 0, 0))
    owner.rotation_euler = (0, 0, 0)
    tree, start, end = new_tree("Scattered")
    ball = node(tree, "SetMaterial", Geometry=node(tree, "MeshIcoSphere", Radius=0.1), Material=tinted())
    placed = node(tree, "InstanceOnPoints", Points=start, Instance=ball)
    if ids:
        numbers = number(tree, *(("MULTIPLY_ADD", 2.0) if ids == EVEN else ("MODULO", 4.0)))
        numbers.inputs[2].default_value = 7.0
        placed = node(tree, "SetID", Geometry=placed, ID=numbers)
    stored = node(tree, "StoreNamedAttribute", Geometry=placed, Name="tint")
    stored.domain, stored.data_type = "INSTANCE", "FLOAT_VECTOR"
    tree.links.new(
        node(tree, "InputPosition").outputs[0],
        next(s for s in stored.inputs if s.name == "Value" and s.enabled),
    )
    if nested:
        line = node(tree, "MeshLine", Count=2, Offset=(0, 0, FAR))
        stored = node(tree, "InstanceOnPoints", Points=line, Instance=stored)
    if parts:
        join = node(tree, "JoinGeometry", Geometry=stored)
        curve = node(tree, "SetCurveRadius", Curve=node(tree, "CurvePrimitiveCircle"), Radius=0.01)
        tree.links.new(curve.outputs[0], join.inputs[0])
        stored = join
    tree.links.new(stored.outputs[0], end.inputs[0])
    owner.modifiers.new("Scattered", "NODES").node_group = tree
    return owner


def check(count):
    """Each ball's tint is where it is, FAR multiples aside."""
    snapshot = export()
    instances = snapshot.instances
    tint = instances.attributes["instancer:tint"][:, :3]
    balls = [len(data.triangles) == 20 for data in snapshot.meshes]
    rows = [row for row, data in enumerate(instances.mesh) if balls[data]]
    place = instances.matrix[rows, :3, 3]
    away = np.abs(place - tint[rows])
    assert len(rows) == count
    np.testing.assert_allclose(np.minimum(away, np.abs(away - FAR)), 0, atol=1e-5)


@pytest.mark.parametrize("ids", ["", EVEN, DOUBLE])
@pytest.mark.parametrize("nested", [False, True])
def test_instances_of_an_object(ids, nested):
    empty_scene()
    scattered(ids, nested)
    check(18 if nested else 9)


def test_instances_beside_other_parts():
    empty_scene()
    scattered(EVEN, True, parts=True)
    check(18)


@pytest.mark.parametrize("by", ["empty", "nodes"])
def test_instances_in_a_collection(by):
    """The collection placed by an empty or by geometry nodes, after an object that is not of them."""
    scene = empty_scene()
    owner = scattered(EVEN)
    made = bpy.data.collections.new("Collection")
    made.objects.link(add(None, "First"))
    made.objects.link(owner)
    scene.collection.objects.unlink(owner)
    if by == "empty":
        add(None, "Empty", location=(0, 0, FAR), instance_type="COLLECTION").instance_collection = made
    else:
        holder = grid("Holder", (0, 0, 0))
        holder.rotation_euler = (0, 0, 0)
        tree, _, end = new_tree("Held")
        line = node(tree, "MeshLine", Count=1, Offset=(0, 0, 0))
        held = node(tree, "CollectionInfo", Collection=made)
        tree.links.new(node(tree, "InstanceOnPoints", Points=line, Instance=held).outputs[0], end.inputs[0])
        holder.modifiers.new("Held", "NODES").node_group = tree
    check(9)
