"""The coverage panel: filled by Inspect and before a render, and its way from a finding to the node."""

from types import SimpleNamespace

import bpy
import pytest
from support.engine_scene import engine_scene, observed

from pt_engine.blender import coverage_panel, node_places
from pt_engine.blender.record import Observer, Session
from pt_engine.blender.words import inexact
from pt_engine.blender.wrapping import wrapped
from pt_engine.nodes.registry import NODES


def ignored(n):
    """A node that is sure to be ignored."""
    n.ignored("edges stay sharp")
    return {"Normal": None}


@pytest.fixture
def scene(monkeypatch):
    """A cube whose material has a Bevel node (edges stay sharp), once plain and once in a group."""
    monkeypatch.setattr(Session, "checked", None)
    monkeypatch.setattr(Session, "last", None)
    monkeypatch.setitem(NODES, "Bevel", ignored)
    scene = engine_scene(samples=1)
    material = bpy.data.materials.new("Worn")
    if not material.node_tree:
        material.use_nodes = True
    tree = material.node_tree
    principled = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfPrincipled")
    group = bpy.data.node_groups.new("Edge", "ShaderNodeTree")
    group.interface.new_socket("Normal", in_out="OUTPUT", socket_type="NodeSocketVector")
    inner = group.nodes.new("ShaderNodeBevel")
    inner.name = "a/b"  # names may have slashes
    group.links.new(inner.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    user = tree.nodes.new("ShaderNodeGroup")
    user.node_tree, user.name = group, "Group"
    tree.links.new(user.outputs[0], principled.inputs["Normal"])
    tree.links.new(tree.nodes.new("ShaderNodeBevel").outputs[0], principled.inputs["Coat Normal"])
    principled.inputs["Coat Weight"].default_value = 1
    bpy.data.objects["Cube"].data.materials.append(material)
    return scene


class Layout:
    """Stands in for Blender's: keeps the labels and the operators that a draw asks for."""

    def __init__(self):
        self.labels, self.jumps = [], []
        self.use_property_split = False

    def box(self):
        return self

    def column(self, align=False):
        return self

    row = box

    def label(self, text="", icon="NONE"):
        self.labels.append(text)

    def operator(self, name, text="", icon="NONE"):
        jump = type("Jump", (), {"name": name})()
        self.jumps.append(jump)
        return jump

    def prop(self, data, name):
        assert hasattr(data, name)


def a_panel(width):
    """A context that draws into a region of this width in pixels."""
    return SimpleNamespace(
        region=SimpleNamespace(width=width),
        preferences=SimpleNamespace(system=SimpleNamespace(ui_scale=1.0)),
    )


def nodes_listed():
    return sorted(entry.node for entry in coverage_panel.findings().get("Worn", []))


def test_inspect_fills_the_panel_without_a_render(scene):
    assert coverage_panel.findings() == {}
    assert bpy.ops.pt_engine.check_scene() == {"FINISHED"}
    assert nodes_listed() == ["Bevel", "Group/a/b"]
    layout = Layout()
    coverage_panel.draw_findings(layout, a_panel(300), coverage_panel.findings())
    assert layout.labels[0] == "Worn"
    assert set(zip(layout.labels[1::2], layout.labels[2::2], strict=True)) == {
        (f"{node}: ignored", "edges stay sharp") for node in nodes_listed()
    }
    assert sorted((jump.owner, jump.node) for jump in layout.jumps) == [("Worn", n) for n in nodes_listed()]


def test_a_render_fills_the_panel_before_its_first_pass(scene):
    seen = []

    class Watching(Observer):
        def on_progress(self, progress):
            seen.append(nodes_listed())

    with observed(Watching()):
        bpy.ops.render.render()
    assert seen[0] == ["Bevel", "Group/a/b"]


def test_strict_refuses_with_the_list(scene):
    scene.pt_engine.strict = True
    with pytest.raises(RuntimeError, match="Bevel ignored: edges stay sharp"):
        bpy.ops.render.render()
    assert nodes_listed() == ["Bevel", "Group/a/b"]


def test_the_button_goes_to_the_node(scene):
    """The object becomes active with its material's slot, the node the only selected one of its tree."""
    cube = bpy.data.objects["Cube"]
    cube.data.materials.append(None)
    cube.active_material_index = 1
    bpy.context.view_layer.objects.active = None
    inner = bpy.data.node_groups["Edge"].nodes["a/b"]
    for path, node in (("Bevel", bpy.data.materials["Worn"].node_tree.nodes["Bevel"]), ("Group/a/b", inner)):
        assert bpy.ops.pt_engine.show_node(owner="Worn", node=path) == {"FINISHED"}
        tree = node.id_data
        assert tree.nodes.active == node
        assert [other for other in tree.nodes if other.select] == [node]
    assert bpy.context.view_layer.objects.active == cube
    assert cube.active_material.name == "Worn"
    assert node_places.place_of("Worn", "Group/a/b").groups[0].name == "Group"


def test_an_open_shader_editor_shows_the_tree_with_the_node(scene):
    """Down into the group, and up again for a node outside of it."""
    windows = bpy.context.window_manager.windows
    area = max(windows[0].screen.areas, key=lambda area: area.width * area.height)
    area.type = "NODE_EDITOR"
    space = area.spaces.active
    space.tree_type = "ShaderNodeTree"
    bpy.ops.pt_engine.show_node(owner="Worn", node="Group/a/b")
    assert space.edit_tree == bpy.data.node_groups["Edge"]
    assert next(step.node_tree for step in space.path) == bpy.data.materials["Worn"].node_tree
    bpy.ops.pt_engine.show_node(owner="Worn", node="Bevel")
    assert space.edit_tree == bpy.data.materials["Worn"].node_tree
    assert not space.pin
    bpy.ops.pt_engine.show_node(owner="World", node="Background")
    assert (space.edit_tree, space.shader_type) == (scene.world.node_tree, "WORLD")


@pytest.mark.parametrize(("owner", "node"), [("Worn", "no such node"), ("no such material", "Bevel")])
def test_a_node_that_is_gone_is_said_to_be(scene, owner, node):
    assert node_places.place_of(owner, node) is None
    assert bpy.ops.pt_engine.show_node(owner=owner, node=node) == {"CANCELLED"}


def test_long_lists_end_with_how_many_there_are_more(scene):
    bpy.ops.pt_engine.check_scene()
    entry = inexact(Session.checked.coverage)[0]
    layout = Layout()
    coverage_panel.draw_findings(layout, a_panel(300), {"Worn": [entry] * 30})
    assert layout.labels[-1] == "and 6 more"


def test_a_material_that_was_not_rendered_is_not_called_exact(scene):
    bpy.ops.pt_engine.check_scene()
    for name, told in (("Worn", "Worn"), ("Shelved", "Not rendered, or nothing at its output")):
        panel, context = SimpleNamespace(layout=Layout()), a_panel(300)
        context.material = bpy.data.materials.get(name) or bpy.data.materials.new(name)
        coverage_panel.PTENGINE_MATERIAL_PT_coverage.draw(panel, context)
        assert panel.layout.labels[0] == told


def test_lines_are_as_wide_as_the_panel():
    """About six pixels a character, never less than a word's width; nothing is lost."""
    text = "the shader as lit by even white light, without shadows or lamps"
    for width in (120, 225, 400, 1000):
        lines = wrapped(text, a_panel(width))
        assert " ".join(lines) == text
        assert max(map(len, lines)) <= max(width / 6, 16)
    assert len(wrapped(text, a_panel(1000))) == 1
