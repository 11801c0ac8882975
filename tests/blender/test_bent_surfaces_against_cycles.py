"""Surfaces that displacement bends: what nodes see of the bent normal, and what scatters about it.

Displacement that is only shaded replaces the surface's normal for all that comes after it, in every node
that looks at the normal unasked. A translucent sheet's bumps decide how much of an even sky it passes.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_nodes import with_nodes  # noqa: E402
from support.bpy_scenes import add, empty_scene, mesh  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402
from support.seen_nodes import build, case, check, set_up  # noqa: E402

from pt_engine.blender.export.scene import export_scene  # noqa: E402
from pt_engine.nodes.compile import compile_materials  # noqa: E402

BENT = {"Color": (0.6, 0.3, 0.9, 1), "Strength": 0.7}


@pytest.fixture(scope="module")
def stage():
    return build()


def raised(tree, end):
    """A displacement by noise, at the end of a tree."""
    noise, step = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeDisplacement")
    noise.inputs["Scale"].default_value, step.inputs["Scale"].default_value = 2.0, 0.3
    tree.links.new(noise.outputs[0], step.inputs["Height"])
    tree.links.new(step.outputs[0], end.inputs["Displacement"])


CASES = [
    *(case("TexCoord", output) for output in ("Normal", "Reflection", "Object")),
    *(case("NewGeometry", output) for output in ("Normal", "True Normal", "Tangent")),
    case("Tangent", "Tangent", direction_type="RADIAL", axis="X"),
    case("Tangent", "Tangent", direction_type="UV_MAP"),
    case("NormalMap", "Normal", links=BENT, space="WORLD"),
    case("NormalMap", "Normal", links=BENT, space="OBJECT"),
    case("Fresnel", "Fac", links={"IOR": 1.3}),
    case("LayerWeight", "Facing"),
    case("TexImage", "Color", image=True, projection="BOX"),
]


@pytest.mark.parametrize("c", CASES)
def test_node_sees_the_bent_normal(c, stage):
    """As far as a bump of this steepness can be compared: Cycles looks within 1/200 pixel of the centre."""
    scene, tree = stage
    set_up(tree, c)
    raised(tree, next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL"))
    check(scene, share=0.08, tolerance=0.02)


def followed_by_a_bump(tree, kind, output, of_object):
    """A black closure beside what shines, whose Bump's height comes from `output` of a node of its own."""
    texture, bump = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeBump")
    black, both = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeAddShader")
    black.inputs["Color"].default_value = (0, 0, 0, 1)
    if kind:
        where = tree.nodes.new("ShaderNode" + kind)
        if of_object:
            where.object = bpy.data.objects["Box"]
        tree.links.new(where.outputs[output], texture.inputs["Vector"])
    tree.links.new(texture.outputs[0], bump.inputs["Height"])
    tree.links.new(bump.outputs[0], black.inputs["Normal"])
    shine, end = (next(n for n in tree.nodes if n.type == t) for t in ("EMISSION", "OUTPUT_MATERIAL"))
    for k, closure in enumerate((shine, black)):
        tree.links.new(closure.outputs[0], both.inputs[k])
    tree.links.new(both.outputs[0], end.inputs["Surface"])


@pytest.mark.skipif(bpy.app.version < (5, 2, 0), reason="Cycles before 5.2 bends these too")
@pytest.mark.parametrize(
    ("kind", "output", "of_object"),
    [
        ("TexCoord", "Generated", False),
        ("", "", False),
        ("TexCoord", "Object", True),
        ("NewGeometry", "Position", False),
    ],
)
def test_coordinates_that_a_bump_follows_have_the_normal_of_the_surface_at_rest(
    kind, output, of_object, stage
):
    """On smooth faces, for all that read them: nodes of the same coordinates, but no others, are one."""
    scene, tree = stage
    set_up(tree, case("TexCoord", "Normal").values[0])
    raised(tree, next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL"))
    followed_by_a_bump(tree, kind, output, of_object)
    check(scene, share=0.08, tolerance=0.02)


@pytest.mark.skipif(bpy.app.version < (5, 2, 0), reason="Cycles before 5.2 bends these too")
def test_bump_of_the_normal_of_a_surface_that_displacement_bends(stage):
    scene, tree = stage
    set_up(tree, case("Bump", "Normal", links={"Height": ("TexCoord", "Normal"), "Distance": 3.0}).values[0])
    raised(tree, next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL"))
    check(scene, share=0.08, tolerance=0.02)


def test_bump_of_a_constant_height_hands_on_its_normal_as_it_is(stage):
    """Whatever its length: Cycles folds the node away."""
    scene, tree = stage
    set_up(tree, case("Bump", "Normal", links={"Normal": ("NewGeometry", "Position")}).values[0])
    bump, value = (
        next(n for n in tree.nodes if n.type == "BUMP"),
        tree.nodes.new("ShaderNodeValue"),
    )
    tree.links.new(value.outputs[0], bump.inputs["Height"])
    check(scene)


def sheet(kind, how, height):
    """A sheet under an even sky, seen from above, its waves bumps or displacement; the material."""
    scene = empty_scene()
    made = bpy.data.materials.new("Sheet")
    tree = with_nodes(made)
    closure, end = tree.nodes.new("ShaderNode" + kind), tree.nodes.new("ShaderNodeOutputMaterial")
    closure.inputs[0].default_value = (1, 1, 1, 1)
    tree.links.new(closure.outputs[0], end.inputs["Surface"])
    where, waves = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeTexWave")
    tree.links.new(where.outputs["Object"], waves.inputs["Vector"])
    if how == "bump":
        bump = tree.nodes.new("ShaderNodeBump")
        bump.inputs["Distance"].default_value = height
        tree.links.new(bump.outputs[0], closure.inputs["Normal"])
    else:
        bump = tree.nodes.new("ShaderNodeDisplacement")
        bump.inputs["Scale"].default_value = height
        tree.links.new(bump.outputs[0], end.inputs["Displacement"])
    tree.links.new(waves.outputs["Fac"], bump.inputs["Height"])
    data = mesh([(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)], [(0, 1, 2, 3)], "Sheet")
    data.materials.append(made)
    add(data, "Sheet")
    scene.world = bpy.data.worlds.new("Even")
    sky = with_nodes(scene.world)
    light, out = sky.nodes.new("ShaderNodeBackground"), sky.nodes.new("ShaderNodeOutputWorld")
    light.inputs["Color"].default_value = (1, 1, 1, 1)
    sky.links.new(light.outputs[0], out.inputs[0])
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 4.0
    scene.camera.location, scene.camera.rotation_euler = (0, 0, 5), (0, 0, 0)


@pytest.mark.parametrize("how", ["bump", "displacement"])
@pytest.mark.parametrize("kind", ["BsdfTranslucent", "BsdfDiffuse"])
def test_what_a_bent_sheet_passes_of_an_even_sky(kind, how, tmp_path):
    """Its mean: 16 · 24² samples of a standard deviation below ½ leave 0.005; five times that is allowed."""
    sheet(kind, how, 0.3)
    ours = np.mean([image[..., :3].mean() for image in by_engine(16, (24, 24))])
    theirs = np.mean([image[..., :3].mean() for image in by_cycles(64, (24, 24), tmp_path)])
    assert ours < 0.95  # the bumps do something
    assert abs(ours - theirs) < 0.025


def camera_aslant():
    """Looks at the sheet from 70° off its normal, so that bumps often mirror into it."""
    camera = bpy.context.scene.camera
    angle = np.radians(70)
    camera.location, camera.rotation_euler = (0, -5 * np.sin(angle), 5 * np.cos(angle)), (angle, 0, 0)


@pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="4.5's Cycles takes other normals for bumped")
@pytest.mark.parametrize(
    ("kind", "inputs"),
    [
        ("BsdfAnisotropic", {"Roughness": 0.8}),
        ("BsdfPrincipled", {"Coat Weight": 1.0, "Coat Tint": (0.3, 0.3, 0.3, 1), "Coat IOR": 1.1}),
    ],
)
def test_gloss_that_bumps_would_mirror_into_the_sheet(kind, inputs, tmp_path):
    """What is lost between facets and the coat's path follow the raised normal. Noise: below 0.005."""
    sheet(kind, "bump", 0.3)
    camera_aslant()
    node = next(n for n in bpy.data.materials["Sheet"].node_tree.nodes if n.bl_idname == "ShaderNode" + kind)
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    ours = np.mean([image[..., :3].mean() for image in by_engine(32, (24, 24))])
    theirs = np.mean([image[..., :3].mean() for image in by_cycles(128, (24, 24), tmp_path)])
    assert abs(ours - theirs) < 0.01 * theirs, (ours, theirs)


def smooth_ball(*kinds):
    """The sheet's bumps on a coarse smooth ball, of the closures of these kinds in equal parts."""
    sheet(kinds[0], "bump", 0.3)
    bpy.data.objects.remove(bpy.data.objects["Sheet"])
    bpy.ops.mesh.primitive_uv_sphere_add(radius=1.8, segments=16, ring_count=8)
    bpy.ops.object.shade_smooth()
    made = bpy.data.materials["Sheet"]
    bpy.context.object.data.materials.append(made)
    tree = made.node_tree
    first, end = (next(n for n in tree.nodes if n.type == t) for t in ("TEX_WAVE", "OUTPUT_MATERIAL"))
    first.inputs["Scale"].default_value = 10.0
    if len(kinds) == 1:
        return
    bump, mix = next(n for n in tree.nodes if n.type == "BUMP"), tree.nodes.new("ShaderNodeMixShader")
    for k, kind in enumerate(kinds):
        closure = tree.nodes.new("ShaderNode" + kind)
        closure.inputs[0].default_value = (1, 1, 1, 1)
        tree.links.new(bump.outputs[0], closure.inputs["Normal"])
        tree.links.new(closure.outputs[0], mix.inputs[1 + k])
    tree.links.new(mix.outputs[0], end.inputs["Surface"])


def test_a_mixture_scatters_what_its_parts_do_about_a_smooth_bent_normal(tmp_path):
    """Of light scattered once half of each part's, whichever closure draws the way; and as in Cycles."""
    parts = "BsdfAnisotropic", "BsdfTranslucent"
    means = []
    for kinds in (parts[:1], parts[1:], parts):
        smooth_ball(*kinds)
        means.append(np.mean([image[..., :3].mean() for image in by_engine(128, (24, 24), max_depth=2)]))
    only = {f"{kind}_bounces": 0 for kind in ("max", "diffuse", "glossy", "transmission")}
    theirs = np.mean([image[..., :3].mean() for image in by_cycles(128, (24, 24), tmp_path, **only)])
    one, other, both = means
    assert abs(both - (one + other) / 2) < 0.004  # noise: 0.001
    assert abs(both - theirs) < 0.006


@pytest.mark.parametrize("offset", [0.0, 0.1])
@pytest.mark.parametrize("angle", [60, 110])
def test_bumps_on_a_displaced_ball_have_the_horizon_and_shadows_of_the_bent_surface(angle, offset, tmp_path):
    """Gloss that a sun of one direction lights once, from the side. Noise: 0.002 of it."""
    smooth_ball("BsdfAnisotropic")
    tree = bpy.data.materials["Sheet"].node_tree
    raised(tree, next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL"))
    bpy.context.object.shadow_terminator_geometry_offset = offset
    bpy.context.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.data.angle = 3.0, 0.0
    sun.rotation_euler = (0, np.radians(angle), 0)
    bpy.context.scene.collection.objects.link(sun)
    only = {f"{kind}_bounces": 0 for kind in ("max", "diffuse", "glossy", "transmission")}
    ours = np.mean([image[..., :3].mean() for image in by_engine(64, (48, 48), max_depth=2)])
    theirs = np.mean([image[..., :3].mean() for image in by_cycles(128, (48, 48), tmp_path, **only)])
    assert abs(ours - theirs) < 0.006 * theirs, (ours, theirs)


def test_coverage_tells_that_lamps_shine_through_bumps_undimmed():
    sheet("BsdfTranslucent", "bump", 0.3)
    snapshot = export_scene(bpy.context.evaluated_depsgraph_get())
    graph = next(g for g in snapshot.materials if g.name == "Sheet")
    effects = [e.effect for e in compile_materials([graph]).coverage if e.state == "approximate"]
    assert effects == ["bumps do not dim what passes; in Cycles they dim that of sampled lights"]
