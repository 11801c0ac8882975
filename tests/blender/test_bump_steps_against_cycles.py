"""How far Bump looks: any Filter Width, and steps in the image of what reads it; the same as in Cycles."""

import pytest

bpy = pytest.importorskip("bpy")
from support.seen_nodes import build, case, check, compare, set_up, since_5  # noqa: E402

FINE = ("TexNoise", "Fac")
WINDOW = ("TexCoord", "Window")


def widened(width, source=FINE, **more):
    return case("Bump", "Normal", links={"Height": source, "Filter Width": width, **more})


CASES = [
    *(widened(width) for width in (0.0, 1e-3, 0.0123, 0.5, 7.0, -0.3)),
    widened(0.0, Normal=("TexCoord", "Object")),
    *since_5(
        "before Blender 5 the steps in the image follow the face",
        *(widened(width, WINDOW, Distance=distance) for width in (0.1, 2.5) for distance in (0.1, -0.5)),
    ),
]


@pytest.fixture(scope="module")
def stage():
    return build()


@pytest.mark.parametrize("c", CASES)
def test_bump_looks_as_far_as_in_cycles(c, stage):
    compare(*stage, c)


@pytest.mark.parametrize(("source", "given"), [("TexNoise", None), ("Value", 3.0), ("Value", 0.0)])
def test_a_width_that_varies_is_the_sockets_own(source, given, stage):
    """Cycles takes a width that is linked to a constant, but reads no other link."""
    scene, tree = stage
    (c,) = widened((source, "Fac" if given is None else "Value")).values
    set_up(tree, c)
    for node in tree.nodes:
        if node.type == "BUMP":
            node.inputs["Filter Width"].default_value = 1.5
        if node.type == "VALUE":
            node.outputs[0].default_value = given
        if node.type == "TEX_NOISE":
            node.inputs["Scale"].default_value = 40.0
    check(scene)
