"""Nodes on faces seen from behind, of objects whose scale mirrors or not: as in Cycles."""

import pytest

bpy = pytest.importorskip("bpy")
from support.seen_nodes import build, case, compare, since_5  # noqa: E402

BENT = {"Color": (0.6, 0.3, 0.9, 1), "Strength": 0.7}
NORMAL = {"Vector": ("NewGeometry", "Normal")}
SPACES = ("TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD")


@pytest.fixture(scope="module")
def stage():
    scene, tree = build()
    for name in ("Ball", "Box"):
        bpy.data.objects[name].data.flip_normals()
    return scene, tree


CASES = [
    *(case("TexCoord", o) for o in ("Normal", "Object", "UV", "Reflection")),
    *(case("NewGeometry", o) for o in ("Normal", "True Normal", "Incoming", "Tangent", "Backfacing")),
    *(case("Tangent", "Tangent", direction_type="RADIAL", axis=axis) for axis in "XYZ"),
    case("Tangent", "Tangent", direction_type="UV_MAP"),
    *(case("NormalMap", "Normal", links=BENT, space=space) for space in SPACES[1:]),
    *since_5(
        "Cycles 4.5 shades in other tangent spaces",
        case("NormalMap", "Normal", links=BENT, space="TANGENT"),
        case("NormalMap", "Normal", links=BENT, space="TANGENT", convention="DIRECTX"),
    ),
    case("VectorTransform", "Vector", links=NORMAL, vector_type="NORMAL", convert_to="CAMERA"),
    case("VectorTransform", "Vector", links=NORMAL, vector_type="NORMAL", convert_to="OBJECT"),
    case("Fresnel", "Fac", links={"IOR": 1.3}),
    *(case("LayerWeight", o) for o in ("Fresnel", "Facing")),
    case("Bump", "Normal", 0.08, 0.02, links={"Height": ("TexNoise", "Fac"), "Distance": 0.2}),
    case("Bump", "Normal", 0.08, 0.02, links={"Height": ("TexCoord", "UV")}, invert=True),
    case("NewGeometry", "Pointiness"),
]


@pytest.mark.parametrize("c", CASES)
def test_back_face_is_what_cycles_sees(c, stage):
    compare(*stage, c)
