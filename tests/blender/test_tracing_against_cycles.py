"""Ambient Occlusion and Bevel against Cycles: random on both sides, so cell by cell within their noise."""

from pathlib import Path

import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_scenes import add, cube, empty_scene, mesh  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402
from support.ztest import compare  # noqa: E402

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="the nodes follow Cycles 5")
SIZE = (48, 32)


def shining(kind, output, settings, inputs, link=None):
    """A material that shines with a node's output; a normal is shown as (n + 1)/2."""
    made = bpy.data.materials.new("Shining")
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNode" + kind)
    for key, value in settings.items():
        setattr(node, key, value)
    for key, value in inputs.items():
        node.inputs[key].default_value = value
    if link is not None:
        tree.links.new(tree.nodes.new("ShaderNode" + link[0]).outputs[link[1]], node.inputs["Normal"])
    half = tree.nodes.new("ShaderNodeVectorMath")
    half.operation = "MULTIPLY_ADD"
    half.inputs[1].default_value = half.inputs[2].default_value = (0.5, 0.5, 0.5)
    shine, end = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[output], half.inputs[0])
    tree.links.new(half.outputs[0], shine.inputs["Color"])
    tree.links.new(shine.outputs[0], end.inputs["Surface"])
    made.cycles.emission_sampling = "NONE"  # Cycles leaves these nodes out where it samples emitters
    return made


def build(*shown):
    """Two boxes, one of them turned, a smooth ball and a floor, all shining with what is shown."""
    scene = empty_scene()
    made = shining(*shown)
    scene.camera.location, scene.camera.rotation_euler = (0.4, -7.0, 3.2), (1.15, 0.0, 0.06)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12)
    owner = bpy.context.object
    ball = owner.data
    bpy.data.objects.remove(owner)
    ball.shade_smooth()
    floor = mesh([(-6, -6, 0), (6, -6, 0), (6, 6, 0), (-6, 6, 0)], [(0, 1, 2, 3)], "Floor")
    boxes = cube("Box"), cube("Turned")
    for data in (ball, floor, *boxes):
        data.materials.append(made)
    add(floor, "Floor")
    add(ball, "Ball", location=(-1.6, 0.6, 0.9), scale=(0.9, 1.1, 0.9))
    add(boxes[0], "Box", location=(0.3, -0.8, 0.6), scale=(0.6, 0.6, 0.6))
    add(boxes[1], "Turned", location=(1.7, 0.5, 0.7), scale=(0.7, -0.7, 0.9), rotation_euler=(0.2, 0.3, 0.5))
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1.0
    return scene


AO = {"Distance": 1.5}
CASES = {
    "open": ("AmbientOcclusion", "AO", {"samples": 3}, AO),
    "colour": ("AmbientOcclusion", "Color", {"samples": 2}, {**AO, "Color": (0.9, 0.4, 0.1, 1)}),
    "inside": ("AmbientOcclusion", "AO", {"samples": 3, "inside": True}, AO),
    "own object": ("AmbientOcclusion", "AO", {"samples": 3, "only_local": True}, AO),
    "inside own object": ("AmbientOcclusion", "AO", {"samples": 2, "inside": True, "only_local": True}, AO),
    "normal": ("AmbientOcclusion", "AO", {"samples": 2}, AO, ("TexCoord", "Object")),
    "bevel": ("Bevel", "Normal", {"samples": 4}, {"Radius": 0.2}),
    "wide bevel": ("Bevel", "Normal", {"samples": 8}, {"Radius": 0.5}),
    "bevel of a normal": ("Bevel", "Normal", {"samples": 4}, {"Radius": 0.2}, ("NewGeometry", "True Normal")),
}


@pytest.mark.parametrize("name", CASES)
def test_the_mean_is_cycles(name, tmp_path: Path):
    """Differences of 12 × 8 cells within the noise of both, corrected for their number."""
    build(*CASES[name])
    theirs, mine = by_cycles(128, SIZE, tmp_path), by_engine(128, SIZE)
    found = compare(mine, theirs)
    assert found.error < 2e-3, found


def lit(made, node, settings, output):
    """The boxes and the ball white and matt under a lamp, bent by a node's normal."""
    tree = made.node_tree
    tree.nodes.clear()
    surface, end = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    bent = tree.nodes.new("ShaderNode" + node)
    for key, value in settings.items():
        bent.inputs[key].default_value = value
    if node == "Bump":
        waves = tree.nodes.new("ShaderNodeTexWave")
        waves.inputs["Scale"].default_value = 2.0
        tree.links.new(waves.outputs["Fac"], bent.inputs["Height"])
    tree.links.new(bent.outputs[output], surface.inputs["Normal"])
    tree.links.new(surface.outputs[0], end.inputs["Surface"])
    lamp = bpy.data.lights.new("Lamp", "AREA")
    lamp.energy, lamp.size = 300, 0.5
    add(lamp, "Lamp", location=(5, -3, 1.5), rotation_euler=(1.3, 0.0, 1.0))


@pytest.mark.parametrize(
    ("node", "settings"), [("Bevel", {"Radius": 0.15}), ("Bump", {"Distance": 1.0, "Filter Width": 1.0})]
)
def test_bumped_diffuse_is_shadowed_as_in_cycles(node, settings, tmp_path: Path):
    """Grazing light on bent normals, cell by cell within noise; without it Bump is 30 % off."""
    build("AmbientOcclusion", "AO", {"samples": 1}, AO)
    lit(bpy.data.materials["Shining"], node, settings, "Normal")
    found = compare(by_engine(40, SIZE), by_cycles(40, SIZE, tmp_path))
    assert found.p > 1e-5, found
    assert found.error < 0.03, found
