"""Tangents of meshes without a uv map, and of meshes smooth in part: the same as in Cycles."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
import bmesh  # noqa: E402  (bpy brings it along)
from support.seen_nodes import build, case, compare, since_5  # noqa: E402

BENT = {"Color": (0.6, 0.3, 0.9, 1), "Strength": 0.7}
WHERE = [
    *(case("Tangent", "Tangent", direction_type="UV_MAP", uv_map=name) for name in ("", "missing")),
    *(case("NormalMap", "Normal", links=BENT, uv_map=name) for name in ("", "missing")),
    case("Attribute", "Vector", attribute_name="tangent"),
    case("Attribute", "Fac", attribute_name="tangent_sign"),
]


@pytest.fixture(scope="module")
def stage():
    """A monkey and a box without maps, turned so that the seam of their longitude is in sight."""
    scene, tree = build()
    ball, box = bpy.data.objects["Ball"], bpy.data.objects["Box"]
    bpy.ops.mesh.primitive_monkey_add(size=2.2, location=ball.location, rotation=(0.3, 0.2, 0.1))
    monkey = bpy.context.object
    monkey.data.materials.append(bpy.data.materials["Test"])
    monkey.data.shade_smooth()
    bpy.data.objects.remove(ball)
    box.rotation_euler = (0.2, 0.1, 3.0)
    for owner in (monkey, box):
        while owner.data.uv_layers:
            owner.data.uv_layers.remove(owner.data.uv_layers[0])
    return scene, tree


@pytest.fixture(scope="module")
def smooth_in_part():
    """A box of many faces, some of them flat, whose map is curved."""
    scene, tree = build()
    box = bpy.data.objects["Box"]
    made = bmesh.new()
    made.from_mesh(box.data)
    bmesh.ops.subdivide_edges(made, edges=made.edges, cuts=3, use_grid_fill=True)
    made.to_mesh(box.data)
    made.free()
    box.data.polygons.foreach_set("use_smooth", np.arange(len(box.data.polygons)) % 5 > 0)
    at = np.array([box.data.vertices[loop.vertex_index].co for loop in box.data.loops], np.float32)
    uv = np.stack([at[:, 0] + at[:, 1] * at[:, 2], at[:, 2] + at[:, 0] * at[:, 1]], axis=1)
    box.data.uv_layers[0].data.foreach_set("uv", uv.ravel())
    return scene, tree


@pytest.mark.parametrize("c", since_5("Cycles 4.5 has a seam", *WHERE))
def test_longitude_has_no_seam(c, stage):
    compare(*stage, c)


@pytest.mark.parametrize("c", since_5("Cycles 4.5 keeps normals otherwise", *WHERE))
def test_flat_faces_beside_smooth_ones(c, smooth_in_part):
    compare(*smooth_in_part, c)
