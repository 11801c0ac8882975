"""`python -m pt_engine coverage` and `explain`: what they list, and how they fail."""

import json

import bpy
import pytest
from support.engine_scene import engine_scene

from pt_engine.nodes.registry import NODES


@pytest.fixture(scope="module")
def blend(tmp_path_factory):
    """A cube of noisy, bevelled plastic with a dead branch, and three of plain plastic."""
    scene = engine_scene()
    material = bpy.data.materials.new("Plastic")
    if not material.node_tree:
        material.use_nodes = True
    tree = material.node_tree
    principled = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfPrincipled")
    noise, mix = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeMix")
    unused, value = tree.nodes.new("ShaderNodeTexWave"), tree.nodes.new("ShaderNodeValue")
    scale = tree.nodes.new("ShaderNodeMath")
    mix.data_type = "RGBA"
    mix.inputs["Factor"].default_value = 0
    links = tree.links
    links.new(noise.outputs[1], next(s for s in mix.inputs if s.identifier == "A_Color"))
    links.new(unused.outputs[0], next(s for s in mix.inputs if s.identifier == "B_Color"))
    links.new(value.outputs[0], scale.inputs[0])
    links.new(scale.outputs[0], noise.inputs["Scale"])
    links.new(next(s for s in mix.outputs if s.identifier == "Result_Color"), principled.inputs["Base Color"])
    links.new(tree.nodes.new("ShaderNodeBevel").outputs[0], principled.inputs["Normal"])
    bpy.data.objects["Cube"].data.materials.append(material)
    for number in range(3):
        other = bpy.data.materials.new(f"Mate {number}")
        if not other.node_tree:
            other.use_nodes = True
        shader = next(n for n in other.node_tree.nodes if n.bl_idname == "ShaderNodeBsdfPrincipled")
        shader.inputs["Base Color"].default_value = (0.1 * number + 0.1, 0.5, 0.5, 1)
        copy = bpy.data.objects["Cube"].copy()
        copy.data = copy.data.copy()
        copy.data.materials[0] = other
        scene.collection.objects.link(copy)
    path = tmp_path_factory.mktemp("inspection") / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


@pytest.fixture(autouse=True)
def bevel(monkeypatch):
    """A node that is sure to be ignored, and something that is sure not to be supported."""

    def ignored(n):
        n.ignored("edges stay sharp")
        return {"Normal": None}

    monkeypatch.setitem(NODES, "Bevel", ignored)
    asked = [("Scene Scene", "fur", "the cube is bald")]
    monkeypatch.setattr("pt_engine.blender.export.scene.scene_wide", lambda depsgraph, scene: asked)


def test_coverage_lists_every_node_and_what_else_the_file_asks_for(run, blend):
    code, out, err = run("coverage", blend)
    assert (code, err) == (0, "")
    lines = out.splitlines()
    start = lines.index("Material Plastic")
    assert lines[start + 1] == "  ignored      Bevel: edges stay sharp"
    listed = {line.split(None, 1)[1].partition(":")[0] for line in lines[start + 1 :] if line[:2] == "  "}
    assert {"Noise Texture", "Mix", "Value", "Math", "Principled BSDF", "Wave Texture"} <= listed
    assert "  exact        Wave Texture: has no effect on the image" in lines  # its mix has the factor 0
    also = lines.index("Also asked for")
    assert lines[also + 1] == "  ignored      Scene Scene: fur: the cube is bald"
    assert also > start
    states = [line.split()[0] for line in lines if line[:2] == "  "]
    assert lines[-1] == ", ".join(f"{states.count(s)} {s}" for s in ("exact", "approximate", "ignored"))


def with_a_tree(name):
    """A new material with the nodes that Blender gives it."""
    made = bpy.data.materials.new(name)
    if not made.node_tree:  # before Blender 5
        made.use_nodes = True
    return made


def test_what_a_volume_is_made_of_is_left_out_with_it_and_not_exact(run, tmp_path):
    engine_scene()
    cloud = with_a_tree("Cloud")
    nodes, links = cloud.node_tree.nodes, cloud.node_tree.links
    noise, volume = nodes.new("ShaderNodeTexNoise"), nodes.new("ShaderNodeVolumePrincipled")
    output = next(node for node in nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    links.new(noise.outputs[0], volume.inputs["Density"])
    links.new(volume.outputs[0], output.inputs["Volume"])
    bpy.data.objects["Cube"].data.materials.append(cloud)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "cloud.blend"))
    lines = run("coverage", tmp_path / "cloud.blend")[1].splitlines()
    assert "  ignored      Principled Volume: the volume is left out: clear inside" in lines
    assert "  ignored      Noise Texture: a part of the volume, which is left out" in lines


def test_a_material_without_anything_at_its_output_is_told_to_be_black(run, tmp_path):
    engine_scene()
    bare = with_a_tree("Bare")
    bare.node_tree.links.clear()
    bpy.data.objects["Cube"].data.materials.append(bare)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "bare.blend"))
    lines = run("coverage", tmp_path / "bare.blend")[1].splitlines()
    place = lines.index("Material Bare")
    assert lines[place + 1] == "  exact        Material Output: nothing is connected to it: black"


def test_strict_coverage_ends_with_1(run, blend, tmp_path, monkeypatch):
    assert run("coverage", blend, "--strict")[0] == 1
    monkeypatch.setattr("pt_engine.blender.export.scene.scene_wide", lambda depsgraph, scene: [])
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    tree = bpy.data.materials["Plastic"].node_tree
    tree.nodes.remove(tree.nodes["Bevel"])
    exact = tmp_path / "exact.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(exact))
    code, out, _ = run("coverage", exact, "--strict")
    assert code == 0, out


def test_coverage_as_json_has_the_same(run, blend):
    code, out, _ = run("coverage", blend, "--json")
    found = json.loads(out)
    assert code == 0
    entries = [entry for section in found["sections"] for entry in section["entries"]]
    for state, count in found["totals"].items():
        assert count == sum(entry["state"] == state for entry in entries)
    bevel = next(entry for entry in entries if entry["node"] == "Bevel")
    assert bevel == {"of": "Plastic", "node": "Bevel", "state": "ignored", "effect": "edges stay sharp"}


def test_explain_prints_steps_inputs_folded_and_dropped_nodes(run, blend):
    code, out, err = run("explain", blend, "Plastic")
    assert (code, err) == (0, "")
    folded = next(line for line in out.splitlines() if line.startswith("Folded to constants: "))
    assert {"Math", "Value"} <= set(folded.partition(": ")[2].split(", "))
    assert "Dropped, no effect here: Wave Texture" in out
    noise = next(line for line in out.splitlines() if "noise_color[" in line)
    assert "<- Noise Texture" in noise
    assert all(f"{name}=" in noise for name in ("vector", "scale", "detail", "lacunarity"))
    assert float(noise.split()[0]) > 0
    assert "closure diffuse: weight v" in out
    assert "Batch: alone" in out


def test_explain_names_the_batch_mates_and_what_differs_in_the_batch(run, blend):
    out = run("explain", blend, "Mate 0")[1]
    assert "Mate 1, Mate 2" in next(line for line in out.splitlines() if line.startswith("Batch:"))
    assert "(0.1 0.5 0.5) (differs in the batch)" in out


def test_an_unknown_material_is_answered_with_near_names(run, blend):
    code, out, err = run("explain", blend, "plastik")
    assert (code, out) == (1, "")
    assert "no material 'plastik' is in" in err
    assert "is it Plastic" in err


def test_a_collection_of_materials_needs_neither_camera_nor_somebody_who_wears_them(run, tmp_path):
    scene = engine_scene()
    scene.camera = None
    with_a_tree("Shelved").use_fake_user = True
    path = tmp_path / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    code, out, err = run("coverage", path)
    assert (code, err) == (0, "")
    assert "World World" in out.splitlines()
    code, out, err = run("explain", path, "Shelved")
    assert (code, err) == (0, "")
    assert out.startswith("Material Shelved: nodes: 1")
    assert run("render", path, "-o", tmp_path / "x.exr", "--quiet")[2].rstrip().endswith("has no camera")


@pytest.mark.parametrize("words", [("coverage",), ("explain", "X")])
def test_bad_files_are_told_apart(run, tmp_path, words):
    command, *rest = words
    broken = tmp_path / "broken.blend"
    broken.write_bytes(b"BLENDER, but not really")
    for path, told in (
        (tmp_path / "none.blend", "no such file"),
        (tmp_path, "directory"),
        (broken, "read as"),
    ):
        code, out, err = run(command, path, *rest)
        assert (code, out) == (1, "")
        assert told in err
