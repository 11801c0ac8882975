"""Attributes of every domain and type, properties of objects and of the view layer: the same as in Cycles."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.seen_nodes import EXACT, build, case, compare  # noqa: E402

PROPERTY = {  # data type: property to set, components, made from uniforms u
    "FLOAT": ("value", 1, lambda u: u * 2 - 0.5),
    "INT": ("value", 1, lambda u: (u * 7).astype(np.int32) - 3),
    "INT8": ("value", 1, lambda u: (u * 7).astype(np.int32)),
    "BOOLEAN": ("value", 1, lambda u: u > 0.6),
    "FLOAT2": ("vector", 2, lambda u: u),
    "FLOAT_VECTOR": ("vector", 3, lambda u: u * 2 - 0.5),
    "FLOAT_COLOR": ("color", 4, lambda u: u),
    "BYTE_COLOR": ("color", 4, lambda u: u),
    "QUATERNION": ("value", 4, lambda u: u),
}
DOMAINS = ("POINT", "EDGE", "FACE", "CORNER")
BYTES = 1e-3  # Cycles decodes sRGB at corners with a fast power, off by up to 7e-4
OUTPUTS = ("Color", "Vector", "Fac", "Alpha")


def filled(data, name, kind, domain, rng):
    """A new attribute of random values."""
    attribute = data.attributes.new(name, kind, domain)
    prop, size, make = PROPERTY[kind]
    attribute.data.foreach_set(prop, make(rng.random(len(attribute.data) * size, dtype=np.float32)))


@pytest.fixture(scope="module")
def stage():
    scene, tree = build()
    rng = np.random.default_rng(11)
    for name in ("Ball", "Box"):
        owner = bpy.data.objects[name]
        for kind in PROPERTY:
            for domain in DOMAINS:
                filled(owner.data, f"{kind} {domain}", kind, domain, rng)
    ball = bpy.data.objects["Ball"]
    for name, kind in (("density", "FLOAT"), ("color", "FLOAT_COLOR")):
        filled(ball.data, name, kind, "POINT", rng)
    ball["number"], ball["whole"], ball["flag"] = 0.25, 3, True
    ball["pair"], ball["four"], ball["three whole"] = (0.5, 0.75), (0.1, 0.2, 0.3, 0.4), (1, 2, 3)
    ball["word"], ball["five"] = "text", (1.0, 2.0, 3.0, 4.0, 5.0)
    ball.data["of mesh"] = 0.75
    scene["of scene"] = (0.3, 0.6, 0.9)
    bpy.context.view_layer["of layer"] = 0.125
    return scene, tree


def attribute(name, output, kind="GEOMETRY", **more):
    return case("Attribute", output, attribute_name=name, attribute_type=kind, **more)


CASES = [
    *(
        attribute(f"{kind} {domain}", "Color", tolerance=BYTES if kind == "BYTE_COLOR" else EXACT)
        for kind in PROPERTY
        for domain in DOMAINS
    ),
    *(
        attribute(f"{kind} POINT", output)
        for kind in ("FLOAT", "BOOLEAN", "FLOAT2", "FLOAT_VECTOR", "FLOAT_COLOR", "QUATERNION")
        for output in OUTPUTS[1:]
    ),
    *(attribute("missing", output) for output in OUTPUTS),
    *(case("VolumeInfo", output) for output in ("Color", "Density", "Flame")),
    *(attribute("", output) for output in ("Color", "Alpha")),
    *(attribute(name, "Color") for name in ("uv", "generated", "vertex_color", "position", "sharp_face")),
    *(attribute(name, "Fac") for name in ("UVMap", "uv", "generated")),
    *(
        attribute(name, output, kind)
        for kind in ("OBJECT", "INSTANCER")
        for name, outputs in (
            *((name, ("Color",)) for name in ("number", "whole", "flag", "pair", "three whole")),
            *((name, ("Color",)) for name in ("word", "five", "of mesh", "missing")),
            *((name, ("Color",)) for name in ("location", "pass_index", '["number"]', "matrix_world")),
            ("four", OUTPUTS),
            ("color", OUTPUTS),
            ("missing", ("Fac", "Alpha")),
        )
        for output in outputs
    ),
    *(
        attribute(name, output, "VIEW_LAYER")
        for name in ("of scene", "of layer", "missing", "frame_current", "render.fps", "gravity")
        for output in (OUTPUTS if name == "of scene" else ("Color", "Alpha"))
    ),
    *(
        case("VertexColor", output, layer_name=name)
        for output in ("Color", "Alpha")
        for name in ("FLOAT_COLOR POINT", "BYTE_COLOR FACE", "missing")
    ),
]


@pytest.mark.parametrize("c", CASES)
def test_attribute_is_what_cycles_reads(c, stage):
    compare(*stage, c)
