"""Settings of a file that are not observed are named, each by what it is called, and nothing else is."""

import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_scenes import add, cube, empty_scene, export  # noqa: E402


@pytest.fixture(autouse=True)
def scene():
    made = empty_scene()
    add(cube(), "Box")
    lamp = bpy.data.lights.new("Lamp", "POINT")
    add(lamp, "Lamp")
    made.world = bpy.data.worlds.new("World")
    return made


def named():
    bpy.context.view_layer.update()
    return {what for _, what, _ in export().unsupported}


def caustics_off(scene):
    scene.cycles.caustics_reflective = scene.cycles.caustics_refractive = False


def shadow_caustics(scene):
    bpy.data.objects["Box"].cycles.is_caustics_caster = True
    bpy.data.objects["Box"].cycles.is_caustics_receiver = True


def world_bounces(scene):
    scene.world.cycles.max_bounces = 2


def fading_strands(scene):
    curves = bpy.data.hair_curves.new("Tuft")
    curves.add_curves([3])
    add(curves, "Tuft").shadow_terminator_shading_offset = 0.5


def uneven_strands(scene):
    curves = bpy.data.hair_curves.new("Tuft")
    curves.add_curves([3])
    add(curves, "Even", scale=(2, 2, -2))
    add(curves, "Tuft", scale=(1, 1.2, 1))


CASES = {
    "no reflective and refractive caustics": caustics_off,
    "shadow caustics": shadow_caustics,
    "max bounces": world_bounces,
    "shadow terminator shading offset": fading_strands,
    "uneven scale": uneven_strands,
}


@pytest.mark.parametrize("what", CASES)
def test_what_is_not_observed_is_named(scene, what):
    CASES[what](scene)
    assert named() == {what}


def test_only_uneven_scales_are_named(scene):
    uneven_strands(scene)
    bpy.context.view_layer.update()
    assert {where for where, _, _ in export().unsupported} == {"Object Tuft"}


def test_what_is_observed_is_not(scene):
    box = bpy.data.objects["Box"]
    box.shadow_terminator_shading_offset, box.shadow_terminator_geometry_offset = 0.5, 0.2
    box.lightgroup = scene.world.lightgroup = "group"
    bpy.context.view_layer.lightgroups.add(name="group")
    bpy.data.lights["Lamp"].cycles.max_bounces = 1
    scene.render.use_motion_blur, scene.cycles.rolling_shutter_type = True, "TOP"
    assert named() == set()


def test_what_a_lost_library_was_to_bring_is_named(scene, tmp_path):
    """Blender's placeholders are empty: a black box, an object less, and no world."""
    blocks = {
        bpy.data.materials.new("Wood"),
        bpy.data.worlds.new("Sky"),
        bpy.data.objects.new("Ball", cube()),
        bpy.data.materials.new("Unused"),
    }
    bpy.data.libraries.write(str(tmp_path / "lost.blend"), blocks, fake_user=True)
    made = empty_scene()
    with bpy.data.libraries.load(str(tmp_path / "lost.blend"), link=True) as (there, linked):
        linked.materials, linked.worlds, linked.objects = there.materials, ["Sky"], ["Ball"]
    made.world = linked.worlds[0]
    made.collection.objects.link(linked.objects[0])
    add(cube(), "Box").data.materials.append(bpy.data.materials["Wood"])
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    assert named() == set()
    (tmp_path / "lost.blend").unlink()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    lost = export().unsupported
    assert {where for where, _, _ in lost} == {"Material Wood", "World Sky", "Object Ball"}
    assert all("lost.blend" in effect for _, _, effect in lost)
