"""Nodes that read the shading point, seen by a camera: our whole way from export to hit against Cycles."""

import pytest

bpy = pytest.importorskip("bpy")
from support.seen_nodes import build, case, compare  # noqa: E402

UV = ("TexCoord", "UV")
CASES = [
    *(case("TexCoord", o) for o in ("Generated", "Normal", "UV", "Object", "Reflection")),
    *(case("NewGeometry", o) for o in ("Position", "Normal", "True Normal", "Incoming", "Backfacing")),
    case("NewGeometry", "Tangent", 0.03),
    case("UVMap", "UV", uv_map="UVMap"),
    *(case("ObjectInfo", o) for o in ("Location", "Color", "Alpha", "Object Index", "Random")),
    *(case("LightPath", o) for o in ("Is Camera Ray", "Is Glossy Ray", "Ray Length", "Ray Depth")),
    case("VertexColor", "Color", layer_name="Tint"),
    case("Attribute", "Color", attribute_name="Tint"),
    case("Attribute", "Vector", attribute_name="UVMap"),
    case("Fresnel", "Fac", links={"IOR": 1.3}),
    case("LayerWeight", "Fresnel"),
    case("LayerWeight", "Facing", links={"Blend": 0.7}),
    *(case("Tangent", "Tangent", 0.03, direction_type="RADIAL", axis=a) for a in "XYZ"),
    *(
        case("VectorTransform", "Vector", links={"Vector": source}, vector_type=kind, **spaces)
        for kind, source in (
            ("POINT", ("NewGeometry", "Position")),
            ("VECTOR", ("NewGeometry", "Incoming")),
            ("NORMAL", ("NewGeometry", "Normal")),
        )
        for spaces in (
            {"convert_from": "WORLD", "convert_to": "OBJECT"},
            {"convert_from": "OBJECT", "convert_to": "WORLD"},
        )
    ),
    *(
        case("NormalMap", "Normal", links={"Color": (0.6, 0.3, 0.9, 1), "Strength": 0.7}, space=space)
        for space in ("OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD")
    ),
    # Cycles looks within 1/200 of a pixel of the centre, Bump's step is 1/10 long
    *(
        case("Bump", "Normal", 0.03, 0.02, links={"Height": ("TexNoise", "Fac"), **links})
        for links in (
            {"Normal": ("NewGeometry", "True Normal"), "Distance": 0.3},
            {"Normal": ("TexCoord", "Object"), "Distance": -0.3},
            {"Strength": 1.7, "Filter Width": 3.0},
            {"Strength": ("TexWave", "Fac"), "Distance": ("TexWave", "Fac")},
        )
    ),
    *(
        case(
            "Bump", "Normal", 0.03, 0.02, links={"Height": source, "Distance": 0.2, "Strength": 0.8}, **invert
        )
        for source in (
            ("TexNoise", "Fac"),
            ("TexWave", "Fac"),
            ("TexCoord", "UV"),
            ("NewGeometry", "Position"),
        )
        for invert in ({}, {"invert": True})
    ),
    *(
        case("TexImage", o, 0.03, 5e-3, links={"Vector": UV}, interpolation=i, extension=e, image=True)
        for o in ("Color", "Alpha")
        for i in ("Linear", "Closest", "Cubic")
        for e in ("REPEAT", "EXTEND", "CLIP", "MIRROR")
    ),
    *(
        case("TexImage", "Color", 0.03, 5e-3, projection=p, projection_blend=0.4, image=True)
        for p in ("BOX", "SPHERE", "TUBE")
    ),
    case("TexEnvironment", "Color", 0.03, 5e-3, links={"Vector": ("NewGeometry", "Incoming")}, image=True),
    case(
        "TexEnvironment",
        "Color",
        0.03,
        5e-3,
        links={"Vector": ("NewGeometry", "Incoming")},
        projection="MIRROR_BALL",
        image=True,
    ),
]


@pytest.fixture(scope="module")
def stage():
    return build()


@pytest.mark.parametrize("c", CASES)
def test_camera_sees_what_cycles_sees(c, stage):
    compare(*stage, c)
