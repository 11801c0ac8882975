"""What sockets make of what reaches them: conversions on the way, hidden and own values, texture mappings."""

import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_nodes import BLENDER_5  # noqa: E402
from support.seen_nodes import build, check, picture  # noqa: E402

TYPES = ("Float", "Int", "Bool", "Vector", "Color", "Shader")
FOLDED = ("folded vector", "folded below", "folded number")


@pytest.fixture(scope="module")
def stage():
    return build()


@pytest.fixture(name="tree")
def _tree(stage):
    _, tree = stage
    tree.nodes.clear()
    return tree


def new(tree, kind, links=(), **settings):
    """A node whose inputs, by number or name, are linked to an output or set to a value."""
    node = tree.nodes.new(f"ShaderNode{kind}")
    for key, value in settings.items():
        setattr(node, key, value)
    for name, source in dict(links).items():
        if isinstance(source, bpy.types.NodeSocket):
            tree.links.new(source, node.inputs[name])
        else:
            node.inputs[name].default_value = source
    return node


def shown(stage, tree, output, socket="Color"):
    """The output is the material's light."""
    shine = new(tree, "Emission", {socket: output})
    new(tree, "OutputMaterial", {"Surface": shine.outputs[0]})
    check(stage[0])


def sources(tree):
    """By name: colours, vectors and numbers that vary, and three that Blender folds."""
    generated = new(tree, "TexCoord").outputs["Generated"]
    parts = {0: 0.3, 1: 1.6, 2: 2.9}
    return {
        "colour": lambda: new(tree, "TexNoise", {"Scale": 3.0}).outputs["Color"],
        "vector": lambda: new(tree, "VectorMath", {0: generated, 1: (2, 3, -1.5)}).outputs[0],
        "number": lambda: new(tree, "Math", {0: generated, 1: 2.7}, operation="MULTIPLY").outputs[0],
        "folded vector": lambda: new(tree, "CombineXYZ", parts).outputs[0],
        "folded below": lambda: new(tree, "CombineXYZ", {0: 0.3, 1: -1.6, 2: 0.2}).outputs[0],
        "folded number": lambda: new(tree, "Math", {0: 1.7, 1: 0.6}, operation="ADD").outputs[0],
    }


def through(tree, output, way):
    """The output behind a group whose sockets have these types."""
    group = bpy.data.node_groups.new("Way", "ShaderNodeTree")
    for name, direction, kind in zip("io", ("INPUT", "OUTPUT"), way, strict=True):
        group.interface.new_socket(name, in_out=direction, socket_type=f"NodeSocket{kind}")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    group.links.new(start.outputs[0], end.inputs[0])
    return new(tree, "Group", {0: output}, node_tree=group).outputs[0]


@pytest.mark.skipif(not BLENDER_5, reason="before Blender 5 every group's socket converts")
@pytest.mark.parametrize("kind", TYPES)
@pytest.mark.parametrize("source", ["colour", "vector", "number", *FOLDED])
def test_groups_convert_what_blender_folds_and_hand_on_links_as_they_are(source, kind, stage, tree):
    """Behind each second socket: once as a colour, once as a number."""
    output = sources(tree)[source]()
    numbers = [through(tree, output, (kind, second)) for second in ("Int", "Color", "Float")]
    mean = new(tree, "CombineXYZ", dict(enumerate(numbers))).outputs[0]
    both = new(tree, "VectorMath", {0: through(tree, output, (kind, "Vector")), 1: mean}).outputs[0]
    shown(stage, tree, both)


@pytest.mark.parametrize("kind", ["Float", "Color", "Vector"])
@pytest.mark.parametrize("source", ["colour", "vector", "number", "folded vector"])
def test_sockets_in_groups_of_any_blender(source, kind, stage, tree):
    shown(stage, tree, through(tree, sources(tree)[source](), (kind, kind)))


HIDING = [
    ("Gamma", "Color", "Gamma", {}),
    ("MapRange", "Vector", 9, {"data_type": "FLOAT_VECTOR"}),
    ("TexWhiteNoise", "Vector", "W", {"noise_dimensions": "4D"}),
    ("VectorRotate", "Vector", "Angle", {"rotation_type": "Y_AXIS"}),
    ("VectorDisplacement", "Vector", "Scale", {"space": "OBJECT"}),
]


@pytest.mark.parametrize(("kind", "socket", "other", "settings"), HIDING, ids=[h[0] for h in HIDING])
def test_values_count_though_they_are_hidden(kind, socket, other, settings, stage, tree):
    """Where no normal and no coordinate stands in for them; the other input is not folded."""
    node = new(tree, kind, {other: new(tree, "ObjectInfo").outputs["Object Index"]}, **settings)
    hidden = node.inputs[socket]
    assert hidden.hide_value or not BLENDER_5
    hidden.default_value = (0.3, 0.6, 0.9, 1.0)[: len(hidden.default_value)]
    shown(stage, tree, node.outputs[0])


@pytest.mark.parametrize("kind", ["Squeeze", "UVAlongStroke"])
def test_behind_a_node_that_cycles_does_not_know_sockets_keep_their_values(kind, stage, tree):
    generated = new(tree, "TexCoord").outputs["Generated"]
    add = new(tree, "VectorMath", {0: generated, 1: (0.1, 0.7, 0.4)})
    tree.links.new(new(tree, kind).outputs[0], add.inputs[1])
    shown(stage, tree, add.outputs[0])


MOVED = {"translation": (0.3, -0.4, 0.5), "rotation": (0.2, 0.5, -0.7), "scale": (1.2, 0.7, 1.9)}
LIMITS = {"use_min": True, "min": (0.2, 0.2, 0.2), "use_max": True, "max": (0.6, 0.6, 0.6)}


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE", "VECTOR", "NORMAL"])
@pytest.mark.parametrize("fields", [{}, LIMITS, MOVED, MOVED | LIMITS, MOVED | {"mapping_x": "NONE"}])
def test_the_mapping_inside_a_texture(fields, kind, stage, tree):
    """Its limits are none for Cycles, and its type alone is nothing."""
    node = new(tree, "TexNoise", {"Scale": 1.0})
    for name, value in (fields | {"vector_type": kind}).items():
        setattr(node.texture_mapping, name, value)
    shown(stage, tree, node.outputs["Color"])


@pytest.mark.parametrize("kind", ["TexNoise", "TexGradient", "TexWave", "TexImage"])
def test_the_mapping_inside_a_texture_that_blender_folds(kind, stage, tree):
    """It is Cycles', so a folded texture has none; images are not folded."""
    node = new(tree, kind, {"Vector": new(tree, "CombineXYZ", {0: 0.3, 1: 0.6, 2: 0.2}).outputs[0]})
    for name, value in MOVED.items():
        setattr(node.texture_mapping, name, value)
    if kind == "TexImage":
        node.image = picture()
    shown(stage, tree, node.outputs["Color"])


@pytest.mark.parametrize("output", ["Color", "Alpha"])
def test_an_image_node_without_an_image(output, stage, tree):
    shown(stage, tree, new(tree, "TexImage").outputs[output])


@pytest.mark.parametrize("smooth", [0.0, 0.5])
def test_bricks_without_height(smooth, stage, tree):
    """Rows of nothing are no number, unless no mortar asks how far it is."""
    where = new(tree, "VectorMath", {0: new(tree, "TexCoord").outputs["Generated"], 1: (3, 3, 3)})
    sizes = {"Vector": where.outputs[0], "Row Height": 0.0, "Mortar Smooth": smooth}
    shown(stage, tree, new(tree, "TexBrick", sizes | {"Mortar": (0.9, 0.5, 0.2, 1.0)}).outputs["Color"])


def reroute(tree):
    return tree.nodes.new("NodeReroute").outputs[0]


def muted(kind, output=0):
    def make(tree):
        node = new(tree, kind)
        node.mute = True
        return node.outputs[output]

    return make


SILENT = {
    "reroute": reroute,
    "muted without inputs": muted("NewGeometry"),
    "muted with unlinked inputs": muted("Math"),
    "muted, output without an input": muted("TexGabor", "Intensity"),
    "muted shader": muted("BsdfDiffuse"),
    "unknown to Cycles": lambda tree: new(tree, "Squeeze").outputs[0],
}


@pytest.mark.parametrize("kind", ["Float", "Color"])
@pytest.mark.parametrize("silent", SILENT)
def test_which_socket_has_its_say_where_nothing_is_handed_on(silent, kind, stage, tree):
    """The one in the group that something is linked to, or the last."""
    group = bpy.data.node_groups.new("Silent", "ShaderNodeTree")
    group.interface.new_socket("o", in_out="OUTPUT", socket_type=f"NodeSocket{kind}")
    end = group.nodes.new("NodeGroupOutput")
    end.inputs[0].default_value = 0.7 if kind == "Float" else (0.2, 0.5, 0.9, 1)
    group.links.new(SILENT[silent](group), end.inputs[0])
    node = new(tree, "Group", node_tree=group)
    add = new(tree, "VectorMath", {0: new(tree, "TexCoord").outputs["Generated"], 1: (0.1, 0.3, 0.4)})
    tree.links.new(node.outputs[0], add.inputs[1])
    shown(stage, tree, add.outputs[0])
