"""Broken node trees render finite, and what is wrong with them is listed."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_nodes import BLENDER_5, Tree  # noqa: E402
from support.bpy_scenes import add, cube, empty_scene, export  # noqa: E402

from pt_engine.nodes.coverage import EXACT  # noqa: E402
from pt_engine.render import integrators  # noqa: E402, F401  (fills the registry)
from pt_engine.render.progressive import render  # noqa: E402
from pt_engine.render.settings import RenderSettings  # noqa: E402
from pt_engine.scene.prepare import prepare  # noqa: E402

SIZE = 8
BAD = (float("nan"), float("inf"), float("-inf"), 3e38)


@pytest.fixture(autouse=True)
def scene():
    return empty_scene()


def check(material, *said):
    """A cube of the material renders finite; the coverage says `said`, and nothing if not asked to."""
    effects = rendered(material)
    for words in said:
        assert any(words in effect for effect in effects), effects
    assert bool(effects) == bool(said)


def rendered(material):
    """A cube of the material renders finite; what is not exact in it."""
    world = bpy.data.worlds.new("Grey")
    if world.node_tree is None:
        world.use_nodes = True
    bpy.context.scene.world = world
    data = cube()
    data.materials.append(material)
    add(data)
    bpy.context.scene.camera.location = (0, 0, 6)
    bpy.context.view_layer.update()
    made = prepare(export())
    picture = render(made, RenderSettings(SIZE, SIZE, samples=2, max_depth=4)).image()
    assert np.isfinite(picture).all()
    return [f"{e.node}: {e.effect}" for e in made.coverage if e.state != EXACT]


def test_links_in_a_circle():
    tree = Tree()
    first, second = tree.node("Math"), tree.node("Math")
    tree.link(first, 0, second, 0)
    tree.link(second, 0, first, 0)
    tree.link(second, 0, tree.bsdf, "Roughness")
    check(tree.material)


def test_a_group_inside_itself():
    tree = Tree()
    inner, node = tree.group(("Value", "OUTPUT", "Float"))
    inner.node("Group").node_tree = inner.tree
    tree.link(node, 0, tree.bsdf, "Roughness")
    check(tree.material)


def test_an_empty_group():
    tree = Tree()
    inner, node = tree.group(("Value", "OUTPUT", "Float"), ("Shader", "OUTPUT", "Shader"))
    inner.tree.nodes.clear()
    tree.link(node, 0, tree.bsdf, "Roughness")
    tree.link(node, 1, tree.output, 0)
    check(tree.material)


def test_a_group_whose_tree_is_gone():
    tree = Tree()
    inner, node = tree.group(("Shader", "OUTPUT", "Shader"))
    tree.link(node, 0, tree.output, 0)
    bpy.data.node_groups.remove(inner.tree)
    check(tree.material)


def test_a_group_in_which_nothing_reaches_the_output():
    tree = Tree()
    _, node = tree.group(("Value", "OUTPUT", "Float"))
    tree.link(node, 0, tree.bsdf, "Roughness")
    check(tree.material)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # 3e38 · 3e38 overflows; the sample counts as lost
@pytest.mark.parametrize("bad", BAD)
def test_values_that_are_no_numbers(bad):
    tree = Tree()
    noise, curve = tree.node("TexNoise"), tree.node("Mapping")
    for socket in (*noise.inputs, *curve.inputs, *tree.bsdf.inputs):
        if socket.type == "VALUE" and socket.name != "Weight":
            socket.default_value = bad
        elif socket.type in ("VECTOR", "RGBA"):
            socket.default_value = (bad,) * len(socket.default_value)
    tree.link(curve, 0, noise, "Vector")
    tree.link(noise, "Color", tree.bsdf, "Base Color")
    rendered(tree.material)


def test_numbers_made_on_the_way_that_are_none():
    """Powers of powers overflow; infinity minus infinity is none."""
    tree = Tree()
    big, less = tree.node("Math", operation="MULTIPLY"), tree.node("Math", operation="SUBTRACT")
    coordinates = tree.node("NewGeometry")
    tree.link(coordinates, "Position", big, 0)
    big.inputs[1].default_value = 3e38
    power = tree.node("Math", operation="POWER")
    tree.link(big, 0, power, 0)
    power.inputs[1].default_value = 3.0
    tree.link(power, 0, less, 0)
    tree.link(power, 0, less, 1)
    for socket in ("Roughness", "Metallic", "IOR", "Base Color", "Emission Strength", "Alpha"):
        tree.link(less, 0, tree.bsdf, socket)
    check(tree.material)


def test_an_output_that_nothing_reaches():
    tree = Tree()
    tree.tree.links.clear()
    check(tree.material)


def test_no_output_at_all():
    tree = Tree()
    tree.tree.nodes.remove(tree.output)
    check(tree.material)


def test_a_node_whose_type_is_gone():
    class Lost(bpy.types.Node):
        bl_idname, bl_label = "NodeLost", "Lost"

        def init(self, context):
            self.outputs.new("NodeSocketFloat", "Value")

    bpy.utils.register_class(Lost)
    tree = Tree()
    tree.link(tree.node("NodeLost"), 0, tree.bsdf, "Roughness")
    bpy.utils.unregister_class(Lost)
    check(tree.material, "Lost")


@pytest.mark.parametrize("kind", ["TexImage", "TexEnvironment"])
def test_an_image_node_without_an_image(kind):
    """Magenta, which is what it says: see test_sockets_against_cycles."""
    tree = Tree()
    tree.link(tree.node(kind), "Color", tree.bsdf, "Base Color")
    check(tree.material)


def test_an_image_whose_file_is_gone():
    tree = Tree()
    image = bpy.data.images.new("Gone", 4, 4)
    image.source, image.filepath = "FILE", "//nowhere/gone.png"
    tree.link(tree.node("TexImage", image=image), "Color", tree.bsdf, "Base Color")
    check(tree.material, "magenta")


@pytest.mark.skipif(not BLENDER_5, reason="4.5 ends the process when a library is gone while it is open")
def test_a_library_that_is_gone(tmp_path):
    tree = Tree()
    tree.material.name = "Far"
    library, here = tmp_path / "library.blend", tmp_path / "here.blend"
    bpy.data.libraries.write(str(library), {tree.material})
    empty_scene()
    with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
        wanted.materials = ["Far"]
    data = cube("Keeper")
    data.materials.append(wanted.materials[0])
    add(data)
    bpy.ops.wm.save_as_mainfile(filepath=str(here))
    library.unlink()
    bpy.ops.wm.open_mainfile(filepath=str(here))
    check(bpy.data.materials["Far"], "in place of what //library.blend had")
