"""Tangents of meshes without a uv map: the same as in Cycles."""

import pytest

bpy = pytest.importorskip("bpy")
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


@pytest.mark.parametrize("c", since_5("Cycles 4.5 has a seam", *WHERE))
def test_longitude_has_no_seam(c, stage):
    compare(*stage, c)
