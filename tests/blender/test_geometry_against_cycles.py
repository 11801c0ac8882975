"""What Cycles computes from a mesh: Pointiness, islands, tangents; on smooth, flat and torn meshes."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
import bmesh  # noqa: E402  (bpy brings it along)
from support.bpy_scenes import add, cube  # noqa: E402
from support.seen_nodes import build, case, compare, since_5  # noqa: E402


def torn(data):
    """Every face apart from its neighbours, so that vertices lie in the same place."""
    made = bmesh.new()
    made.from_mesh(data)
    bmesh.ops.split_edges(made, edges=made.edges[:])
    made.to_mesh(data)
    made.free()
    return data


@pytest.fixture(scope="module")
def stage():
    scene, tree = build()
    material = bpy.data.materials["Test"]
    bpy.data.objects["Ball"].scale = (1.2, 0.8, 1.3)  # where the mesh of a single user is shaded in the world
    box = bpy.data.objects["Box"]
    box.modifiers.new("Bevel", "BEVEL").width = 0.3
    bpy.ops.mesh.primitive_monkey_add(size=1.8, location=(-1.4, 0, -1.9), rotation=(0.3, 0.2, 0.5))
    monkey = bpy.context.object  # three islands
    monkey.data.materials.append(material)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3)
    ico = bpy.context.object
    data = torn(ico.data.copy())
    bpy.data.objects.remove(ico)
    data.materials.append(material)
    add(data, "Torn", location=(0.3, -0.6, 1.8), scale=(0.7, 0.5, -0.6))
    pair = cube("Pair", 0.8)
    pair.uv_layers.new(name="UVMap")
    uv = np.random.default_rng(4).random(2 * len(pair.loops), dtype=np.float32)  # mirrored here and there
    uv[:8], uv[8:16] = 0.3, np.tile(uv[8:10], 4)  # faces without an area on the map
    pair.uv_layers[0].data.foreach_set("uv", uv)
    pair.materials.append(material)
    pair.shade_smooth()
    owner = add(pair, "Array", location=(0.9, 0.2, -1.9), rotation_euler=(0.4, 0.2, 0.3))
    array = owner.modifiers.new("Array", "ARRAY")
    array.count, array.relative_offset_displace[0] = 3, 1.3
    owner.modifiers.new("Subdivide", "SUBSURF").render_levels = 1
    return scene, tree


BENT = {"Color": (0.6, 0.3, 0.9, 1), "Strength": 0.7}
MOVED = {"Vector": (0.6, 0.3, 0.9, 1), "Scale": 0.7}
CASES = [
    case("NewGeometry", "Pointiness"),
    case("NewGeometry", "Random Per Island"),
    case("Attribute", "Color", attribute_name="pointiness"),
    case("NewGeometry", "Tangent"),
    *(case("Wireframe", "Fac", links={"Size": size}) for size in (0.02, 0.1)),
    *(case("Wireframe", "Fac", links={"Size": size}, use_pixel_size=True) for size in (1.0, 3.0)),
    *(case("Tangent", "Tangent", direction_type="UV_MAP", uv_map=name) for name in ("", "UVMap", "missing")),
    *since_5(
        "Cycles 4.5 shades in other tangent spaces",
        *(case("NormalMap", "Normal", links=BENT, uv_map=name) for name in ("", "UVMap", "missing")),
        case("NormalMap", "Normal", links=BENT | {"Strength": 1.6}),
        case("NormalMap", "Normal", links=BENT, convention="DIRECTX"),
        *(case("NormalMap", "Normal", links=BENT, base=base) for base in ("ORIGINAL", "DISPLACED")),
        case("VectorDisplacement", "Displacement", links=MOVED, space="TANGENT"),
        case("Attribute", "Vector", attribute_name="UVMap.tangent_sign"),
        case("Attribute", "Fac", attribute_name="tangent_sign"),
    ),
    *(case("Attribute", o, attribute_name="tangent") for o in ("Vector", "Fac", "Alpha")),
    case("Attribute", "Vector", attribute_name="UVMap.tangent"),
]


@pytest.mark.parametrize("c", CASES)
def test_geometry_is_what_cycles_makes_of_it(c, stage):
    compare(*stage, c)
