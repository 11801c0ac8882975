"""Light Path behind every kind of bounce: the mean of our picture is Cycles', within its noise.

A floor that scatters in one way only is seen under a sky, or between two shining sheets that only rays find
(emission sampling off), whose colour is one output; transparent sheets dim a lamp by what shadow rays know.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support import camera_view  # noqa: E402
from support.bpy_nodes import BLENDER_5, with_nodes  # noqa: E402
from support.bpy_scenes import add, empty_scene, export, mesh  # noqa: E402

from pt_engine.render import integrators  # noqa: E402, F401  (fills the registry)
from pt_engine.render.progressive import render  # noqa: E402
from pt_engine.render.settings import RenderSettings  # noqa: E402
from pt_engine.scene.prepare import prepare  # noqa: E402

KINDS = ("Camera", "Shadow", "Diffuse", "Glossy", "Singular", "Reflection", "Transmission", "Volume Scatter")
PORTAL = ["Portal"] if BLENDER_5 else []  # 4.5 has no such output
DEPTHS = ("Ray", "Diffuse", "Glossy", "Transmission", "Transparent", *PORTAL)
OUTPUTS = [*(f"Is {kind} Ray" for kind in KINDS), *(f"{kind} Depth" for kind in DEPTHS)]
FLOORS = {
    "diffuse": ("BsdfDiffuse", {}),
    "mirror": ("BsdfGlossy", {"Roughness": 0.0}),
    "glossy": ("BsdfGlossy", {"Roughness": 0.4}),
    "translucent": ("BsdfTranslucent", {}),
    "refraction": ("BsdfRefraction", {"Roughness": 0.0, "IOR": 1.2}),
    "transparent": ("BsdfTransparent", {}),
}
WHITE = (1, 1, 1, 1)
SIDE, SAMPLES = 8, 64


def shader(tree, kind, end, **inputs):
    node, output = tree.nodes.new("ShaderNode" + kind), tree.nodes.new("ShaderNodeOutput" + end)
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    return node


def shining(owner, kind, end, outputs):
    """The owner's tree gives up to three outputs of Light Path as a colour."""
    tree = with_nodes(owner)
    path, color = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeCombineXYZ")
    for channel, output in enumerate(outputs):
        tree.links.new(path.outputs[output], color.inputs[channel])
    tree.links.new(color.outputs[0], shader(tree, kind, end).inputs["Color"])


def sheet(name, z, size, material):
    data = mesh(
        [(-size, -size, 0), (size, -size, 0), (size, size, 0), (-size, size, 0)], [(0, 1, 2, 3)], name
    )
    data.materials.append(material)
    return add(data, name, location=(0, 0, z))


@pytest.fixture(name="scene")
def _scene(monkeypatch):
    scene = empty_scene()
    monkeypatch.setattr(camera_view, "SIZE", SIDE)
    scene.camera.location = (0, 0, 5)
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    settings = scene.cycles
    settings.samples, settings.use_adaptive_sampling, settings.use_denoising = SAMPLES, False, False
    settings.sample_clamp_direct = settings.sample_clamp_indirect = settings.blur_glossy = 0
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth, scene.render.image_settings.exr_codec = "32", "NONE"
    scene.world = bpy.data.worlds.new("World")
    scene.world.cycles.sampling_method = "NONE"
    with_nodes(scene.world)
    return scene


def agree(scene, tolerance):
    """Our mean of each channel against Cycles'."""
    theirs = camera_view.cycles(scene).mean(axis=1)
    settings = RenderSettings(SIDE, SIDE, samples=SAMPLES, max_depth=8, transparent_depth=8)
    image = render(prepare(export()), settings).image()
    ours = image[..., :3].mean(axis=(0, 1))
    assert (np.abs(ours - theirs) <= tolerance * (np.abs(theirs) + 0.01)).all(), (ours, theirs)


@pytest.mark.parametrize("outputs", [OUTPUTS[k : k + 3] for k in range(0, len(OUTPUTS), 3)], ids=" ".join)
@pytest.mark.parametrize("floor", [None, *FLOORS])
def test_the_sky_knows_how_rays_came(floor, outputs, scene):
    if floor is not None:
        kind, inputs = FLOORS[floor]
        material = bpy.data.materials.new("Floor")
        shader(with_nodes(material), kind, "Material", Color=WHITE, **inputs)
        sheet("Floor", 0, 50, material)
    shining(scene.world, "Background", "World", outputs)
    agree(scene, 0.01)  # a share of 1 %: what misses the sheet's rim, Fresnel's noise


@pytest.mark.parametrize("outputs", [("Is Diffuse Ray", "Diffuse Depth"), ("Ray Depth", "Ray Length")])
@pytest.mark.parametrize("floor", ["diffuse", "mirror", "translucent", "transparent"])
def test_surfaces_know_how_rays_came(floor, outputs, scene):
    kind, inputs = FLOORS[floor]
    material, light = (bpy.data.materials.new(name) for name in ("Floor", "Light"))
    shader(with_nodes(material), kind, "Material", Color=WHITE, **inputs)
    shining(light, "Emission", "Material", outputs)
    light.cycles.emission_sampling = "NONE"
    sheet("Floor", 0, 50, material)
    sheet("Above", 6, 60, light)
    sheet("Below", -3, 60, light)
    agree(scene, 0.05)  # sheets of finite size: a few long rays carry the mean length


@pytest.mark.parametrize("output", ["Is Shadow Ray", "Ray Length", "Ray Depth", "Transparent Depth"])
def test_shadow_rays_tell_the_sheets_they_pass(output, scene):
    """A sun through a sheet above the camera and one below, each as clear as the output says."""
    lamp = bpy.data.lights.new("Sun", "SUN")
    lamp.energy, lamp.angle = np.pi, 0.0
    add(lamp, "Sun", location=(0, 0, 9))
    floor, clear = (bpy.data.materials.new(name) for name in ("Floor", "Clear"))
    shader(with_nodes(floor), "BsdfDiffuse", "Material", Color=WHITE)
    tree = with_nodes(clear)
    path, mix = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMix")
    mix.data_type, mix.clamp_factor = "RGBA", False
    tree.links.new(path.outputs["Is Shadow Ray"], mix.inputs["Factor"])
    mix.inputs[6].default_value = WHITE
    tree.links.new(path.outputs[output], mix.inputs[7])
    tree.links.new(mix.outputs[2], shader(tree, "BsdfTransparent", "Material").inputs["Color"])
    sheet("Floor", 0, 50, floor)
    sheet("Low", 3, 60, clear)
    sheet("High", 7, 60, clear)
    agree(scene, 0.05)  # Cycles' noise; measured from sheet to sheet the lengths would give 12, not 21


def test_coverage_tells_of_emitters_that_only_shadow_rays_pass(scene):
    """Cycles' own picture then depends on whether it samples the emitter, its far side above all.

    A shining ball that only shadow rays pass: sampled, the floor gets its far side's light as well.
    """
    ball = bpy.data.materials.new("Ball")
    tree = with_nodes(ball)
    path, mix = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMixShader")
    end = tree.nodes.new("ShaderNodeOutputMaterial")
    for k, kind in enumerate(("Emission", "BsdfTransparent")):
        tree.links.new(tree.nodes.new("ShaderNode" + kind).outputs[0], mix.inputs[1 + k])
    tree.links.new(path.outputs["Is Shadow Ray"], mix.inputs["Fac"])
    tree.links.new(mix.outputs[0], end.inputs["Surface"])
    floor = bpy.data.materials.new("Floor")
    shader(with_nodes(floor), "BsdfDiffuse", "Material", Color=WHITE)
    sheet("Floor", 0, 50, floor)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.5, location=(3, 0, 1))
    bpy.context.object.data.materials.append(ball)
    means = {}
    for sampling in ("NONE", "AUTO"):
        ball.cycles.emission_sampling = sampling
        means[sampling] = camera_view.cycles(scene).mean()
    assert means["AUTO"] > 1.05 * means["NONE"], means
    coverage = prepare(export()).materials.coverage
    assert [e.state for e in coverage if "only shadow rays pass" in e.effect] == ["approximate"]
