"""Motion blur as Cycles has it: what moves, turns, grows and changes shape, the camera, instances, particles.

All pixels of one of our pictures see the same times, so their errors are not independent, as the test takes
them to be: a cell that differs by less than 1 % of the picture's mean is no matter.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from mathutils import Euler  # noqa: E402
from support.bpy_motion import animate  # noqa: E402
from support.bpy_nodes import with_nodes  # noqa: E402
from support.bpy_scenes import add, cube, empty_scene, mesh  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402
from support.ztest import compare  # noqa: E402

SIZE, THEIRS, OURS = (36, 24), 128, 32
TOLERANCE = 0.01
pytestmark = pytest.mark.slow


def material(name, color):
    """Diffuse."""
    made = bpy.data.materials.new(name)
    tree = with_nodes(made)
    bsdf, out = (tree.nodes.new("ShaderNode" + kind) for kind in ("BsdfDiffuse", "OutputMaterial"))
    bsdf.inputs["Color"].default_value = (*color, 1)
    tree.links.new(bsdf.outputs[0], out.inputs["Surface"])
    return made


@pytest.fixture
def scene():
    """A floor under a grey sky and a sun, seen at an angle; the shutter is open for a frame about frame 2."""
    made = empty_scene()
    world = made.world = bpy.data.worlds.new("sky")
    tree = with_nodes(world)
    background, out = (tree.nodes.new("ShaderNode" + kind) for kind in ("Background", "OutputWorld"))
    background.inputs["Color"].default_value = (0.3, 0.35, 0.4, 1)
    tree.links.new(background.outputs[0], out.inputs["Surface"])
    floor = mesh([(-9, -9, -1), (9, -9, -1), (9, 9, -1), (-9, 9, -1)], [(0, 1, 2, 3)], "Floor")
    floor.materials.append(material("Floor", (0.6, 0.6, 0.6)))
    add(floor)
    sun = add(bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 2.0, (0.7, 0.3, 0)
    made.camera.location, made.camera.rotation_euler = (0, -8, 3), (1.25, 0, 0)
    made.render.use_motion_blur, made.render.motion_blur_shutter = True, 1.0
    made.frame_start, made.frame_end = 1, 3
    return made


def box(name="Box", size=2.0):
    data = cube(name, size)
    data.materials.append(material(name, (0.8, 0.3, 0.1)))
    return add(data, name)


def agree(scene, folder, theirs=THEIRS, ours=OURS):
    scene.frame_set(2)
    a = by_engine(ours, SIZE, max_depth=3)
    assert (scene.frame_current, scene.frame_subframe) == (2, 0)
    b = by_cycles(theirs, SIZE, folder, max_bounces=1, diffuse_bounces=1)
    found = compare(a, b)
    assert found.agrees(TOLERANCE), str(found)
    return a, b


@pytest.mark.parametrize("position", ["START", "CENTER", "END"])
def test_objects_that_move_turn_and_grow(scene, tmp_path, position):
    scene.render.motion_blur_position = position
    owner = box()
    owner.cycles.motion_steps = 3
    animate(owner, "location", [(-2, 0, 0), (0, 0, 0.5), (2, 1, 1)])
    animate(owner, "rotation_euler", [(0, 0, 0), (0, 0, 1), (0.5, 0, 2)])
    animate(owner, "scale", [(1, 1, 1), (1, 1, 0.5), (0.5, 1, 1)])
    agree(scene, tmp_path)


def test_the_camera(scene, tmp_path):
    """It goes along, turns and zooms."""
    box()
    camera = scene.camera
    animate(camera, "location", [(-0.5, -8, 3), (0, -8, 3), (0.5, -7, 3)])
    animate(camera, "rotation_euler", [Euler((1.25, 0, -0.05)), Euler((1.25, 0, 0)), Euler((1.2, 0.1, 0))])
    animate(camera.data, "lens", [40, 50, 60])
    agree(scene, tmp_path)


def test_shapes(scene, tmp_path):
    """A shape key, on a smooth mesh under a shutter that opens slowly."""
    owner = box()
    owner.data.shade_smooth()
    owner.shape_key_add(name="Basis")
    other = owner.shape_key_add(name="other")
    for point in other.data:
        point.co.x += 4 * (point.co.x > 0)
        point.co.z += 3 * (point.co.y > 0)
    animate(other, "value", [-0.4, 0.4, 1])
    points = scene.render.motion_blur_shutter_curve.curves[0].points
    points[0].location, points[2].location = (0, 0.1), (1, 0.6)
    scene.render.motion_blur_shutter_curve.update()
    agree(scene, tmp_path)


def test_lamps_stay_in_the_middle(scene, tmp_path):
    """Cycles does not blur them, nor do we; a mesh that shines moves."""
    lamp = add(bpy.data.lights.new("Lamp", "POINT"))
    lamp.data.energy, lamp.data.shadow_soft_size = 300, 0.2
    animate(lamp, "location", [(-3, -2, 1), (0, -2, 2), (3, -2, 1)])
    glow = add(cube("Glow", 0.4), "Glow")
    made = bpy.data.materials.new("Glow")
    tree = with_nodes(made)
    emission, out = (tree.nodes.new("ShaderNode" + kind) for kind in ("Emission", "OutputMaterial"))
    emission.inputs["Strength"].default_value = 15
    tree.links.new(emission.outputs[0], out.inputs["Surface"])
    glow.data.materials.append(made)
    animate(glow, "location", [(-3, 1, 1), (0, 0, 0.5), (2, -1, 0)])
    box("Box", 0.8)
    agree(scene, tmp_path)


def test_instances(scene, tmp_path):
    """Of a collection by an empty that turns."""
    collection = bpy.data.collections.new("Boxes")
    for k in range(3):
        owner = box(f"Box {k}", 1.0)
        owner.location = (1.5 * k - 1.5, 0, 0.3 * k)
        scene.collection.objects.unlink(owner)
        collection.objects.link(owner)
    empty = add(None, "Empty", instance_type="COLLECTION")
    empty.instance_collection = collection
    animate(empty, "rotation_euler", [(0, 0, -0.4), (0, 0, 0), (0, 0, 0.6)])
    agree(scene, tmp_path)


def test_instances_of_geometry_nodes(scene, tmp_path):
    """On the points of a plane that turns, and moved by the nodes themselves."""
    grain = box("Grain", 0.5)
    grain.location = (0, 50, 0)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=3, y_subdivisions=2, size=4)
    owner = bpy.context.object
    tree = bpy.data.node_groups.new("On points", "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    start, end, place, info, along = (
        tree.nodes.new(kind)
        for kind in ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeInstanceOnPoints",
                     "GeometryNodeObjectInfo", "GeometryNodeTransform")
    )  # fmt: skip
    info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = grain, True
    for source, target in (
        (start.outputs[0], place.inputs["Points"]),
        (info.outputs["Geometry"], place.inputs["Instance"]),
        (place.outputs[0], along.inputs[0]),
        (along.outputs[0], end.inputs[0]),
    ):
        tree.links.new(source, target)
    owner.modifiers.new("On points", "NODES").node_group = tree
    animate(owner, "rotation_euler", [(0, 0, -0.3), (0, 0, 0), (0, 0, 0.3)])
    animate(along.inputs["Translation"], "default_value", [(0, 0, 0), (0, 0, 0.7), (0, 0, 1.4)])
    agree(scene, tmp_path)


@pytest.mark.parametrize("when", ["comes", "goes"])
def test_what_comes_or_goes(scene, tmp_path, when):
    """It is there in the middle of the shutter's time, but not at its beginning or at its end."""
    owner = box()
    animate(owner, "location", [(-2, 0, 0), (0, 0, 0.5), (2, 1, 1)])
    hidden = (True, False, False) if when == "comes" else (False, False, True)
    for frame, state in zip((1, 2, 2.4), hidden, strict=True):
        owner.hide_render = owner.hide_viewport = state
        owner.keyframe_insert("hide_render", frame=frame)
        owner.keyframe_insert("hide_viewport", frame=frame)
    agree(scene, tmp_path)


def test_particles(scene, tmp_path):
    """Boxes thrown up from a plane; one that is born while the shutter is open is not there, as in Cycles."""
    grain = box("Grain", 0.5)
    grain.location = (0, 50, 0)
    bpy.ops.mesh.primitive_plane_add(size=4, location=(0, 0, -0.9))
    emitter = bpy.context.object
    emitter.modifiers.new("Particles", "PARTICLE_SYSTEM")
    system = emitter.particle_systems[0].settings
    system.count, system.frame_start, system.frame_end, system.lifetime = 30, -8, 4, 50
    system.normal_factor, system.factor_random = 6.0, 1.0
    system.render_type, system.instance_object = "OBJECT", grain
    system.particle_size, system.effector_weights.gravity = 1.0, 0.0
    for frame in range(-8, 3):
        scene.frame_set(frame)
    agree(scene, tmp_path)


@pytest.mark.parametrize("duration", [0.0, 0.4])
def test_a_rolling_shutter(scene, tmp_path, duration):
    """An object and the camera move; a shorter row of the shutter's time than the whole moves each less."""
    scene.cycles.rolling_shutter_type, scene.cycles.rolling_shutter_duration = "TOP", duration
    animate(box(), "location", [(-3, 0, 0), (0, 0, 0.5), (3, 1, 1)])
    animate(scene.camera, "rotation_euler", [(1.2, 0, -0.1), (1.25, 0, 0), (1.3, 0, 0.1)])
    agree(scene, tmp_path)


def test_a_shadow_catcher(scene, tmp_path):
    """It goes down as a box goes over it, and turns."""
    floor = bpy.data.objects["Floor"]
    floor.is_shadow_catcher = True
    animate(floor, "location", [(0, 0, 0.6), (0, 0, 0), (0, 0, -0.6)])
    animate(floor, "rotation_euler", [(0, 0.1, 0), (0, 0, 0), (0.1, 0, 0)])
    animate(box(), "location", [(-2, 0, 0), (0, 0, 0.5), (2, 1, 1)])
    agree(scene, tmp_path)


def tuft(count=60):
    curves = bpy.data.hair_curves.new("Tuft")
    curves.add_curves([4] * count)
    rng = np.random.default_rng(2)
    roots = rng.uniform((-0.8, -0.8, -1), (0.8, 0.8, -1), (count, 3))
    lean = rng.uniform(-0.5, 0.5, (count, 3)) * (1, 1, 0)
    points = [roots + k * np.array([0, 0, 0.6]) + k * k / 9 * lean for k in range(4)]
    curves.attributes["position"].data.foreach_set("vector", np.stack(points, 1).astype(np.float32).ravel())
    curves.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", [0.05] * 4 * count)
    curves.materials.append(material("Tuft", (0.8, 0.3, 0.1)))
    return add(curves, "Tuft")


@pytest.mark.parametrize("shape", ["THICK", "RIBBONS"])
def test_curves_that_move_and_grow(scene, tmp_path, shape):
    scene.cycles_curves.shape = shape
    owner = tuft()
    animate(owner, "location", [(-1.5, 0, 0), (0, 0, 0), (1.5, 0.5, 0.3)])
    animate(owner, "rotation_euler", [(0, 0, 0), (0.3, 0, 0.5), (0.6, 0, 1)])
    animate(owner, "scale", [(1, 1, 1), (1, 1, 1), (1.2, 1, 0.7)])
    agree(scene, tmp_path)


def test_strands_on_a_mesh_that_bends(scene, tmp_path):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=6)
    ball = bpy.context.object
    ball.modifiers.new("Hair", "PARTICLE_SYSTEM")
    settings = ball.particle_systems[0].settings
    settings.type, settings.count, settings.hair_length = "HAIR", 200, 1.0
    settings.root_radius = settings.tip_radius = 4.0
    ball.shape_key_add(name="Basis")
    key = ball.shape_key_add(name="Long")
    for point in key.data:
        point.co.x += 1.5 * point.co.z
    animate(key, "value", (0.0, 0.5, 1.0))
    ball.data.materials.append(material("Ball", (0.8, 0.3, 0.1)))
    agree(scene, tmp_path)


def test_velocities(scene, tmp_path):
    """Of a mesh, which are all there is, and of strands; 24 frames are a second."""
    owners = box("Box", 1.0), tuft()
    for owner, speed in zip(owners, ((36, 0, 0), (-24, 0, 12)), strict=True):
        made = owner.data.attributes.new("velocity", "FLOAT_VECTOR", "POINT")
        made.data.foreach_set("vector", np.tile(np.float32(speed), len(made.data)))
    agree(scene, tmp_path)
