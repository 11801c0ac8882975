"""Light groups as passes of a multi-layer EXR, by Blender through both engines: every pass is Cycles'."""

import bpy
import pytest
from support import ztest
from support.bpy_nodes import with_nodes
from support.bpy_scenes import add, cube, empty_scene, export, mesh
from support.cycles import BOUNCES, choose_cycles
from support.engine_scene import exr
from support.exr import passes
from support.seen_room import material, put

from pt_engine.blender import registration

SIZE, CELLS, SAMPLES = (24, 16), (4, 4), 64
GROUPS = ("lamp", "sun", "shapes", "sky", "empty")


@pytest.fixture
def scene():
    """A floor, a glossy wall and a box; a lamp, a sun, a sky, a shining cube and an instance of one."""
    made = empty_scene()
    registration.register()
    made.camera.location, made.camera.rotation_euler = (0, -7, 2.6), (1.25, 0, 0)
    floor = mesh([(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)], [(0, 1, 2, 3)], "Floor")
    put(floor, "Floor", material("Grey", "BsdfDiffuse"))
    wall = mesh([(-3, 3, 0), (3, 3, 0), (3, 3, 3), (-3, 3, 3)], [(0, 1, 2, 3)], "Wall")
    put(wall, "Wall", material("Rough", "BsdfGlossy", Roughness=0.4))
    red = material("Red", "BsdfDiffuse", Color=(0.8, 0.2, 0.1, 1))
    put(cube("Box", 1.0), "Box", red, location=(0, 0.5, 0.5))
    lamp = bpy.data.lights.new("Lamp", "AREA")
    lamp.energy, lamp.size = 200.0, 2.0
    add(lamp, "Lamp", location=(-1.5, -0.5, 4.0)).lightgroup = "lamp"
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 1.0, 0.6
    add(sun, "Sun", rotation_euler=(0.1, 0.8, 0)).lightgroup = "sun"
    rest = bpy.data.lights.new("Rest", "POINT")
    rest.energy = 40.0
    add(rest, "Rest", location=(2, -2, 2))
    shines = material("Shines", "Emission", Color=(1, 0.7, 0.4, 1), Strength=6.0)
    put(cube("Glow", 0.4), "Glow", shines, location=(1.6, 0, 0.6)).lightgroup = "shapes"
    instanced()
    sky = made.world = bpy.data.worlds.new("Sky")
    tree = with_nodes(sky)
    background, end = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    background.inputs["Color"].default_value = (0.3, 0.4, 0.6, 1)
    tree.links.new(background.outputs[0], end.inputs["Surface"])
    sky.lightgroup = "sky"
    for name in GROUPS:
        bpy.context.view_layer.lightgroups.add(name=name)
    return made


def instanced():
    """A shining cube in a group, placed by an empty that is in another: the cube's counts."""
    collection = bpy.data.collections.new("Source")
    owner = bpy.data.objects.new("Spark", cube("Spark", 0.3))
    owner.data.materials.append(material("Sparks", "Emission", Color=(0.3, 0.6, 1, 1), Strength=20.0))
    collection.objects.link(owner)
    empty = add(None, "Empty", instance_type="COLLECTION", location=(-1.8, 0.5, 1.0))
    empty.instance_collection, empty.lightgroup, owner.lightgroup = collection, "sun", "shapes"


def written(scene, folder, engine):
    """The passes of two seeds."""
    files = []
    for seed in (0, 1):
        scene.cycles.seed = scene.pt_engine.seed = seed
        exr(scene, folder / f"{engine}{seed}.exr", multilayer=True)
        bpy.ops.render.render(write_still=True)
        files.append(passes(folder / f"{engine}{seed}.exr"))
    return files


def both(scene, folder):
    choose_cycles(SAMPLES, SIZE)
    theirs = written(scene, folder, "cycles")
    scene.render.engine = "PT_ENGINE"
    own = scene.pt_engine
    own.samples, own.max_depth, own.transparent_depth = SAMPLES, BOUNCES + 2, BOUNCES
    own.pixel_filter = "FILE"
    return theirs, written(scene, folder, "own")


@pytest.mark.parametrize("catches", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_each_group_is_that_of_cycles(scene, tmp_path, catches):
    """Also beside a shadow catcher, whose light is in none."""
    bpy.data.objects["Floor"].is_shadow_catcher = catches
    theirs, ours = both(scene, tmp_path)
    names = {"Combined", *(f"Combined_{name}" for name in GROUPS)}
    assert set(ours[0]) == names == {name for name in theirs[0] if name.startswith("Combined")}
    assert not ours[0]["Combined_empty"].any()
    for name in names - {"Combined_empty"}:
        found = ztest.compare((ours[0][name], ours[1][name]), (theirs[0][name], theirs[1][name]), CELLS)
        assert found.agrees(0.01), f"{name}: {found}"
        assert theirs[0][name].mean() > 0.005, name
    if not catches:
        rest = ours[0]["Combined"] - sum(ours[0][name] for name in names - {"Combined"})
        assert (rest > -1e-5).all()
        assert rest.mean() > 0.01  # the lamp in no group


def test_objects_lamps_and_world_are_in_them_and_nothing_is_listed(scene):
    snapshot = export()
    assert snapshot.light_groups == GROUPS
    assert {light.name: light.light_group for light in snapshot.lights} == {"Lamp": 1, "Sun": 2, "Rest": 0}
    rows = snapshot.instances
    assert sorted(rows.names[k] for k in (rows.light_group == 3).nonzero()[0]) == ["Glow", "Spark"]
    assert snapshot.world_light_group == 4
    assert not [entry for entry in snapshot.unsupported if "group" in entry[1]]
