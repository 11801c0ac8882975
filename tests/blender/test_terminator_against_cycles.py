"""Coarse smooth meshes where light grazes: Cycles' picture, with its default geometry offset and without.

Lamps of a single direction make no noise, so that steps of the shadow show as they are.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
import bmesh  # noqa: E402
from support import ztest  # noqa: E402
from support.bpy_nodes import with_nodes  # noqa: E402
from support.bpy_scenes import add, empty_scene, export  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402

SIZE, CELLS, SAMPLES = (64, 48), (8, 6), 32
SIDE = {"location": (3.2, -0.6, 0.7), "rotation_euler": (0, 1.3, -0.2)}
FRONT = {"location": (2, -3.2, 1), "rotation_euler": (1.2, 0, 0.6)}
LAMPS = {
    "SUN": {"energy": 3.0, "angle": 0.0},
    "POINT": {"energy": 300.0, "shadow_soft_size": 0.0},
    "AREA": {"energy": 300.0, "size": 2.0},
}


def material(kind):
    made = bpy.data.materials.new(kind)
    tree = with_nodes(made)
    shader, end = tree.nodes.new("ShaderNode" + kind), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], end.inputs["Surface"])
    return made


def shape(kind):
    """A ball of few faces, its open half, or a cone."""
    data, work = bpy.data.meshes.new(kind), bmesh.new()
    if kind == "cone":
        bmesh.ops.create_cone(work, segments=7, radius1=1, radius2=0.3, depth=1.6, cap_ends=True)
    else:
        bmesh.ops.create_uvsphere(work, u_segments=8, v_segments=6, radius=1)
    if kind == "half":
        bmesh.ops.delete(work, geom=[v for v in work.verts if v.co.y < -0.3], context="VERTS")
    work.to_mesh(data)
    work.free()
    data.shade_smooth()
    return data


def build(kind="ball", lamp="SUN", offset=0.1, shader="BsdfDiffuse", place=SIDE, **settings):
    scene = empty_scene()
    data = shape(kind)
    data.materials.append(material(shader))
    owner = add(data, "Shape", **settings)
    owner.shadow_terminator_geometry_offset = offset
    light = bpy.data.lights.new("Lamp", lamp)
    for name, value in LAMPS[lamp].items():
        setattr(light, name, value)
    add(light, "Lamp", **place)
    scene.camera.location, scene.camera.rotation_euler = (0, -4, 0.6), (1.42, 0, 0)
    scene.camera.data.lens = 60
    return owner


def pictures(folder):
    """Colours of Cycles' pair and of ours."""
    pairs = by_cycles(SAMPLES, SIZE, folder), by_engine(SAMPLES, SIZE)
    return [[image[..., :3] for image in pair] for pair in pairs]


def assert_same(folder):
    """To one per cent: silhouettes jitter differently where there is no noise else to tell them apart."""
    cycles, ours = pictures(folder)
    agreement = ztest.compare(ours, cycles, CELLS)
    assert np.mean(cycles) > 1e-3
    assert agreement.agrees(0.01), str(agreement)


@pytest.mark.parametrize("offset", [0.0, 0.1])
@pytest.mark.parametrize("lamp", LAMPS)
@pytest.mark.parametrize("kind", ["ball", "cone"])
def test_shadow_is_that_of_cycles(kind, lamp, offset, tmp_path):
    build(kind, lamp, offset)
    assert_same(tmp_path)


MORE = {
    "through": {"shader": "BsdfTranslucent"},
    "through, point": {"shader": "BsdfTranslucent", "lamp": "POINT"},
    "gloss": {"shader": "BsdfPrincipled", "offset": 0.3},
    "from within": {"kind": "half", "place": FRONT},
    "from within, point": {"kind": "half", "place": FRONT, "lamp": "POINT"},
    "cone, wide": {"kind": "cone", "offset": 1.0, "lamp": "AREA"},
}


@pytest.mark.parametrize("name", MORE)
def test_other_shadows_are_too(name, tmp_path):
    build(**MORE[name])
    assert_same(tmp_path)


@pytest.mark.parametrize("height", [1.3, -1.3])
@pytest.mark.parametrize("users", [1, 2])
def test_stretched_and_mirrored(users, height, tmp_path):
    """Cycles blends other normals where it moves a mesh into the world: 4 to 6 % of the image (`alone`)."""
    owner = build(scale=(1, 0.6, height))
    if users == 2:
        add(owner.data, "Other", location=(0, 50, 0))
    assert_same(tmp_path)


def test_the_comparison_sees_the_steps(tmp_path):
    """Without the offset the ball's shadow follows its faces: ten times the tolerance above."""
    build(offset=0.1)
    cycles, _ = pictures(tmp_path)
    bpy.data.objects["Shape"].shadow_terminator_geometry_offset = 0.0
    ours = [image[..., :3] for image in by_engine(SAMPLES, SIZE)]
    agreement = ztest.compare(ours, cycles, CELLS)
    assert agreement.error > 0.1, str(agreement)


def test_each_object_has_its_own():
    owner = build(offset=0.25)
    add(owner.data, "Other").shadow_terminator_geometry_offset = 0.0
    instances = export().instances
    found = dict(zip(instances.names, instances.terminator.tolist(), strict=True))
    assert found == {"Shape": 0.25, "Other": 0.0}
