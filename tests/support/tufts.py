"""Hair, hair particles and a point cloud under a sun and a bluish sky."""

import bpy
import numpy as np
from support.bpy_nodes import with_nodes


def sunny():
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


def coil(scene, material, shape):
    """One thick curve, three times around."""
    turn = np.linspace(0, 6 * np.pi, 41)
    one_curve(scene, material, shape, 0.15, [0.6 * np.cos(turn), 0.6 * np.sin(turn), turn / (5 * np.pi)])


def tube(scene, material, shape):
    """One straight, wide curve, seen from near its end."""
    way, zero = np.linspace(-1, 1, 5), np.zeros(5)
    one_curve(scene, material, shape, 0.5, [way * np.sin(-0.4), way * np.cos(-0.4), zero + 0.6])


def one_curve(scene, material, shape, radius, points):
    """A curve of one radius through points (3, P)."""
    scene.cycles_curves.shape = shape
    curves, points = bpy.data.hair_curves.new("Curve"), np.array(points, np.float32)
    curves.add_curves([points.shape[1]])
    curves.attributes["position"].data.foreach_set("vector", points.T.ravel())
    layer = curves.attributes.get("radius") or curves.attributes.new("radius", "FLOAT", "POINT")
    layer.data.foreach_set("value", np.full(points.shape[1], radius, np.float32))
    curves.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("Curve", curves))


def globe(segments, rings, radius):
    """Vertices, no edges and faces of a sphere: quads, and triangles at the poles."""
    theta = np.pi * np.arange(1, rings) / rings
    phi = 2 * np.pi * np.arange(segments) / segments
    around = np.stack(
        [
            np.outer(np.sin(theta), np.cos(phi)),
            np.outer(np.sin(theta), np.sin(phi)),
            np.repeat(np.cos(theta)[:, None], segments, axis=1),
        ],
        axis=-1,
    )
    vertices = radius * np.concatenate([around.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    here, there = np.arange(segments), np.roll(np.arange(segments), -1)
    last, top = (rings - 2) * segments, (rings - 1) * segments
    faces = [
        (k + a, k + segments + a, k + segments + b, k + b)
        for k in range(0, last, segments)
        for a, b in zip(here, there, strict=True)
    ]
    faces += [(top, a, b) for a, b in zip(here, there, strict=True)]
    faces += [(top + 1, last + b, last + a) for a, b in zip(here, there, strict=True)]
    return vertices.tolist(), [], [tuple(map(int, face)) for face in faces]


def emitter(scene, material, child_type="NONE"):
    """A blue ball with 60 strands.

    Blender's own sphere starts its faces at other corners in each process, which moves the strands.
    """
    data = bpy.data.meshes.new("Ball")
    data.from_pydata(*globe(32, 16, 0.5))
    ball = bpy.data.objects.new("Ball", data)
    ball.location, ball.scale = (0, 0, 0.6), (1.1, 1.1, 1.1)
    scene.collection.objects.link(ball)
    bpy.context.view_layer.objects.active = ball
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


def cloud(scene, material):
    """60 balls of a point cloud, with an attribute."""
    rng, count = np.random.default_rng(3), 60
    mesh = bpy.data.meshes.new("Cloud")
    mesh.from_pydata(rng.uniform(-0.8, 0.8, (count, 3)) + [0, 0, 0.6], [], [])
    for name, kind, field, values in (
        ("radius", "FLOAT", "value", rng.uniform(0.05, 0.2, count)),
        ("paint", "FLOAT_COLOR", "color", rng.random((count, 4))),
    ):
        mesh.attributes.new(name, kind, "POINT").data.foreach_set(field, values.astype(np.float32).ravel())
    placed = bpy.data.objects.new("Cloud", mesh)
    scene.collection.objects.link(placed)
    with bpy.context.temp_override(object=placed, active_object=placed, selected_editable_objects=[placed]):
        bpy.ops.object.convert(target="POINTCLOUD")  # 4.5 has no PointCloud.resize
    assert len(placed.data.points) == count
    assert {"radius", "paint"} <= set(placed.data.attributes.keys())
    placed.data.materials.append(material)
