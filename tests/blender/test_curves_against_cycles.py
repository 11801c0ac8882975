"""Hair and point clouds against Cycles: small files made here, each image z-tested.

1 % of the image's mean is allowed beyond the noise: ribbons' pieces are not cut at the same places, and tubes
let 0.2 % more light through than Cycles', whose ends are closed: seen into their ends ours are hollow.
Hair BSDF only toward a sun without bounces: under a sky Cycles' sampler adds light (see
`nodes.hair`).
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_nodes import with_nodes  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402
from support.ztest import compare  # noqa: E402

SIZE = (40, 40)


def slow(*values, **more):
    """A case left out where CI repeats the suite."""
    return pytest.param(*values, marks=pytest.mark.slow, **more)


@pytest.fixture
def scene():
    """A camera, a bluish sky and a sun with a size."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0, -3.2, 0.6), (np.pi / 2, 0, 0)
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.data.angle, sun.rotation_euler = 3, 0.2, (0.6, 0.5, 0)
    for item in (camera, sun):
        scene.collection.objects.link(item)
    scene.camera, scene.world = camera, bpy.data.worlds.new("World")
    sky = background(scene)
    sky.inputs["Color"].default_value = (0.5, 0.6, 0.7, 1)
    return scene


def background(scene):
    """The world's node, made where there is none."""
    tree = with_nodes(scene.world)
    found = [node for node in tree.nodes if node.bl_idname == "ShaderNodeBackground"]
    if found:
        return found[0]
    node, end = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(node.outputs[0], end.inputs["Surface"])
    return node


def shaded(kind, settings=None, **inputs):
    """A material of one shader."""
    made = bpy.data.materials.new(kind)
    tree = with_nodes(made)
    tree.nodes.clear()
    node, end = tree.nodes.new("ShaderNode" + kind), tree.nodes.new("ShaderNodeOutputMaterial")
    for name, value in (settings or {}).items():
        setattr(node, name, value)
    for name, value in inputs.items():
        node.inputs[name.replace("_", " ")].default_value = value
    tree.links.new(node.outputs[0], end.inputs["Surface"])
    return made


def shining(kind, *outputs, scale=(1.0, 1.0, 1.0), settings=None):
    """A material that shines with up to three outputs of a node (the colour's channels), or with a vector."""
    made = bpy.data.materials.new(kind)
    tree = with_nodes(made)
    tree.nodes.clear()
    node, times = tree.nodes.new("ShaderNode" + kind), tree.nodes.new("ShaderNodeVectorMath")
    shine, end = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    for name, value in (settings or {}).items():
        setattr(node, name, value)
    times.operation, times.inputs[1].default_value = "MULTIPLY", scale
    source = node.outputs[outputs[0]]
    if len(outputs) > 1:
        joined = tree.nodes.new("ShaderNodeCombineXYZ")
        for socket, name in zip(joined.inputs, outputs, strict=False):
            tree.links.new(node.outputs[name], socket)
        source = joined.outputs[0]
    tree.links.new(source, times.inputs[0])
    tree.links.new(times.outputs[0], shine.inputs["Color"])
    tree.links.new(shine.outputs[0], end.inputs["Surface"])
    return made


def hair(scene, material, shape, radius=0.03):
    """A tuft of 40 bent curves, scaled by 1.2, with attributes and a map."""
    scene.cycles_curves.shape = shape
    rng, count, each = np.random.default_rng(0), 40, 6
    curves = bpy.data.hair_curves.new("Tuft")
    curves.add_curves([each] * count)
    root = rng.uniform(-0.8, 0.8, (count, 1, 3)) * [1, 0.5, 0]
    step = rng.normal(0, 0.05, (count, each - 1, 3)) + [0, 0, 0.2]
    points = root + np.concatenate([np.zeros((count, 1, 3)), np.cumsum(step, axis=1)], axis=1)
    curves.attributes["position"].data.foreach_set("vector", points.astype(np.float32).ravel())
    layers = {
        ("radius", "FLOAT", "POINT", "value"): np.tile(np.linspace(radius, radius / 3, each), count),
        ("by point", "FLOAT_COLOR", "POINT", "color"): rng.random((count * each, 4)),
        ("by curve", "FLOAT_VECTOR", "CURVE", "vector"): rng.random((count, 3)),
        ("surface_uv_coordinate", "FLOAT2", "CURVE", "vector"): rng.random((count, 2)),
    }
    for (name, kind, domain, field), values in layers.items():
        layer = curves.attributes.get(name) or curves.attributes.new(name, kind, domain)
        layer.data.foreach_set(field, values.astype(np.float32).ravel())
    curves.materials.append(material)
    placed = bpy.data.objects.new("Tuft", curves)
    placed.scale = (1.2, 1.2, 1.2)
    scene.collection.objects.link(placed)
    return placed


def agree(tmp_path, samples, tolerance=0.01, cycles=None, **ours):
    """Both renderers on the current file."""
    theirs = by_cycles(samples, SIZE, tmp_path, **(cycles or {}))
    found = compare(by_engine(samples, SIZE, **ours), theirs)
    assert found.agrees(tolerance), str(found)


@pytest.mark.parametrize("shape", ["RIBBONS", "THICK", slow("THICK_LINEAR")])
def test_curves(shape, scene, tmp_path):
    hair(scene, shaded("BsdfDiffuse", Color=(0.8, 0.5, 0.3, 1)), shape)
    agree(tmp_path, 12)


@pytest.mark.parametrize("shape", ["RIBBONS", slow("THICK")])
def test_principled_hair(shape, scene, tmp_path):
    """Tubes to 3 %: light that passes through them is a little less in Cycles, in cells with many."""
    hair(scene, shaded("BsdfHairPrincipled", {"model": "CHIANG"}, Color=(0.5, 0.3, 0.1, 1)), shape)
    agree(tmp_path, 12, 0.03 if shape == "THICK" else 0.01)


@pytest.mark.parametrize(
    ("aspect", "light", "color"),
    [
        (1.0, "sky", (0.5, 0.3, 0.1, 1)),
        slow(0.5, "sky", (0.5, 0.3, 0.1, 1)),
        slow(1.0, "sun", (0.001, 0.001, 0.001, 1)),
    ],
)
def test_principled_hair_of_facets(aspect, light, color, scene, tmp_path):
    """Toward a sun only black hair: what is reflected inside more than twice Cycles' evaluation lacks."""
    made = shaded("BsdfHairPrincipled", {"model": "HUANG"}, Color=color, Aspect_Ratio=aspect, Offset=0.0)
    hair(scene, made, "RIBBONS")
    if light == "sky":
        bpy.data.lights["Sun"].energy = 0
    else:
        background(scene).inputs["Strength"].default_value = 0
    agree(tmp_path, 24, 0.01)


@pytest.mark.parametrize("component", ["Reflection", slow("Transmission")])
@pytest.mark.parametrize("shape", ["RIBBONS", slow("THICK")])
def test_hair_lobes_toward_a_sun(shape, component, scene, tmp_path):
    """To 6 %: few pixels of a narrow lobe about a tangent are lit at all."""
    hair(scene, shaded("BsdfHair", {"component": component}, Offset=0.1), shape)
    background(scene).inputs["Strength"].default_value = 0
    bpy.data.lights["Sun"].angle = 0
    agree(tmp_path, 16, 0.06, {"max_bounces": 0}, max_depth=2)


@pytest.mark.parametrize(
    ("shape", "kind", "outputs", "more"),
    [
        ("RIBBONS", "HairInfo", ("Is Strand", "Intercept", "Length"), {}),
        slow("RIBBONS", "HairInfo", ("Random", "Thickness", "Length"), {"scale": (1, 10, 1)}),
        slow("RIBBONS", "HairInfo", ("Tangent Normal",), {}),
        slow("RIBBONS", "NewGeometry", ("Normal",), {}),
        ("THICK", "NewGeometry", ("Normal",), {}),
        slow("RIBBONS", "NewGeometry", ("True Normal",), {}),
        slow("THICK", "NewGeometry", ("True Normal",), {}),
        slow("RIBBONS", "NewGeometry", ("Tangent",), {}),
        slow("THICK", "NewGeometry", ("Tangent",), {}),
        slow("RIBBONS", "TexCoord", ("Generated",), {}),
        slow("RIBBONS", "TexCoord", ("UV",), {}),
        slow("RIBBONS", "Attribute", ("Color",), {"settings": {"attribute_name": "by point"}}),
        slow("RIBBONS", "Attribute", ("Color",), {"settings": {"attribute_name": "by curve"}}),
    ],
)
def test_what_strands_know(shape, kind, outputs, more, scene, tmp_path):
    hair(scene, shining(kind, *outputs, **more), shape)
    agree(tmp_path, 8)


@pytest.mark.parametrize("child_type", [slow("NONE"), "INTERPOLATED"])
def test_particle_strands(child_type, scene, tmp_path):
    """Children and parents, tapering, the second material slot, on a scaled emitter."""
    emitter(scene, shaded("BsdfDiffuse", Color=(0.8, 0.5, 0.3, 1)), child_type)
    agree(tmp_path, 12)


@pytest.mark.slow
def test_what_particle_strands_know(scene, tmp_path):
    emitter(scene, shining("HairInfo", "Intercept", "Random", "Thickness", scale=(1, 1, 5)))
    agree(tmp_path, 8)


@pytest.mark.slow
@pytest.mark.parametrize("output", ["UV", "Generated"])
def test_where_particle_strands_stand(output, scene, tmp_path):
    emitter(scene, shining("TexCoord", output))
    agree(tmp_path, 8)


def emitter(scene, material, child_type="NONE"):
    """A blue ball with 60 strands."""
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, location=(0, 0, 0.6))
    ball = bpy.context.object
    ball.scale = (1.1, 1.1, 1.1)
    for each in (shaded("BsdfDiffuse", Color=(0.2, 0.3, 0.8, 1)), material):
        ball.data.materials.append(each)
    ball.modifiers.new("Hair", "PARTICLE_SYSTEM")
    settings = ball.particle_systems[0].settings
    settings.type, settings.count, settings.hair_length, settings.brownian_factor = "HAIR", 60, 0.4, 0.05
    settings.render_step = settings.display_step = 3
    settings.root_radius, settings.tip_radius, settings.radius_scale, settings.shape = 1.2, 0.2, 0.05, 0.3
    settings.material, settings.use_close_tip = 2, True
    settings.child_type, settings.child_percent, settings.rendered_child_count = child_type, 4, 4
    settings.display_percentage = 100


@pytest.mark.parametrize(
    "material",
    [
        lambda: shaded("BsdfDiffuse", Color=(0.8, 0.5, 0.3, 1)),
        slow(lambda: shining("PointInfo", "Position")),
        slow(lambda: shining("PointInfo", "Radius", "Random", "Radius", scale=(5, 1, 5))),
        slow(lambda: shining("Attribute", "Color", settings={"attribute_name": "paint"})),
    ],
    ids=["diffuse", "position", "numbers", "attribute"],
)
def test_point_clouds(material, scene, tmp_path):
    rng, count = np.random.default_rng(3), 60
    mesh = bpy.data.meshes.new("Cloud")
    mesh.from_pydata(rng.uniform(-0.8, 0.8, (count, 3)) + [0, 0, 0.6], [], [])
    for name, kind, field, values in (
        ("radius", "FLOAT", "value", rng.uniform(0.05, 0.2, count)),
        ("paint", "FLOAT_COLOR", "color", rng.random((count, 4))),
    ):
        mesh.attributes.new(name, kind, "POINT").data.foreach_set(field, values.astype(np.float32).ravel())
    cloud = bpy.data.objects.new("Cloud", mesh)
    scene.collection.objects.link(cloud)
    with bpy.context.temp_override(object=cloud, active_object=cloud, selected_editable_objects=[cloud]):
        bpy.ops.object.convert(target="POINTCLOUD")  # 4.5 has no PointCloud.resize
    assert len(cloud.data.points) == count
    assert {"radius", "paint"} <= set(cloud.data.attributes.keys())
    cloud.data.materials.append(material())
    agree(tmp_path, 8)


def test_instances_of_curves(scene, tmp_path):
    """A collection of a tuft placed twice, turned, scaled evenly and mirrored."""
    tuft = hair(scene, shaded("BsdfDiffuse", Color=(0.8, 0.5, 0.3, 1)), "RIBBONS")
    collection = bpy.data.collections.new("Tufts")
    scene.collection.objects.unlink(tuft)
    collection.objects.link(tuft)
    for place, turn, size in (
        ((-0.5, 0, 0), 0.5, (0.5, 0.5, 0.5)),
        ((0.5, 0.3, 0.2), -0.5, (-0.7, 0.7, 0.7)),
    ):
        empty = bpy.data.objects.new("Place", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        empty.location, empty.rotation_euler, empty.scale = place, (0, turn, 0), size
        scene.collection.objects.link(empty)
    agree(tmp_path, 8)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["catcher", "holdout", "no camera", "no shadow"])
def test_curves_seen_otherwise(name, scene, tmp_path):
    """A tuft above a floor that catches its shadow, one that cuts a hole, or that some rays don't see.

    To 2 %: what blocks no shadow rays still blocks scattered ones, so the sky counts by the weights of both,
    which are not Cycles'.
    """
    tuft = hair(scene, shaded("BsdfDiffuse", Color=(0.8, 0.5, 0.3, 1)), "THICK_LINEAR", 0.06)
    bpy.ops.mesh.primitive_plane_add(size=4)
    floor = bpy.context.object
    floor.data.materials.append(shaded("BsdfDiffuse", Color=(0.6, 0.6, 0.6, 1)))
    floor.is_shadow_catcher, tuft.is_holdout = name == "catcher", name == "holdout"
    tuft.visible_camera, tuft.visible_shadow = name != "no camera", name != "no shadow"
    scene.render.film_transparent = name in ("catcher", "holdout")
    agree(tmp_path, 12, 0.02)
