"""True displacement, seen by a camera: where vertices go and which way the new surface faces.

Each case displaces a smooth ball, a flat box and a box with one sharp edge under shear and mirroring, and
shows the position, the normal or the face's normal of what came of it.
"""

from typing import NamedTuple

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_scenes import add, cube, empty_scene  # noqa: E402
from support.camera_view import cycles, one_sample, ours  # noqa: E402
from support.seen_nodes import sphere  # noqa: E402

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="Cycles before 5 displaces otherwise")
EDGES = 0.02  # share of pixels on an edge between faces


class Case(NamedTuple):
    """Which displacement, of what settings and inputs, under which method; what is shown of it."""

    kind: str
    method: str
    shown: str
    settings: dict
    links: dict
    tolerance: float = 2e-3


def case(kind, method, shown="Position", links=None, tolerance=2e-3, **settings):
    label = " ".join([kind, method, shown, *map(str, settings.values()), *(links or {})])
    return pytest.param(Case(kind, method, shown, settings, links or {}, tolerance), id=label)


NOISE = {"Height": ("TexNoise", "Fac"), "Scale": 0.3, "Midlevel": 0.4}
CASES = [
    *(
        case("Displacement", method, shown, NOISE, space=space)
        for method, shown, space in (
            ("DISPLACEMENT", "Position", "OBJECT"),
            ("DISPLACEMENT", "Position", "WORLD"),
            ("DISPLACEMENT", "Normal", "OBJECT"),
            ("DISPLACEMENT", "True Normal", "OBJECT"),
            ("BOTH", "Position", "OBJECT"),
            ("BOTH", "True Normal", "WORLD"),
        )
    ),
    case("Displacement", "DISPLACEMENT", links={**NOISE, "Normal": ("NewGeometry", "Position")}),
    *(
        case("VectorDisplacement", "DISPLACEMENT", links={"Vector": (0.3, 0.2, -0.1), "Scale": 0.7}, space=s)
        for s in ("OBJECT", "WORLD", "TANGENT")
    ),
    # Cycles looks within 1/200 of a pixel of the centre, Bump's step is 1/10 long
    *(case("Displacement", "BOTH", "Normal", NOISE, 1e-2, space=s) for s in ("OBJECT", "WORLD")),
]


def subdivided(data):
    """The mesh with each face cut into 4 × 4."""
    import bmesh

    made = bmesh.new()
    made.from_mesh(data)
    bmesh.ops.subdivide_edges(made, edges=made.edges, cuts=3, use_grid_fill=True)
    made.to_mesh(data)
    made.free()
    return data


@pytest.fixture(scope="module")
def stage():
    scene = empty_scene()
    scene.camera.location, scene.camera.rotation_euler = (0.4, -7.0, 2.2), (1.28, 0.05, 0.06)
    made = bpy.data.materials.new("Test")
    made.use_nodes = True
    flat, mixed, round_ = subdivided(cube()), subdivided(cube("Mixed", 1.2)), sphere()
    mixed.polygons.foreach_set("use_smooth", np.arange(len(mixed.polygons)) % 5 > 0)
    for data in (flat, mixed, round_):
        data.materials.append(made)
    add(round_, "Ball", location=(-1.4, 0, 0.2), scale=(1.2, 1.0, 0.8), rotation_euler=(0.3, 0.5, 0.2))
    add(flat, "Box", location=(1.4, 0.5, 0), scale=(0.8, -0.7, 1.1), rotation_euler=(0.4, 0.3, 0.7))
    add(mixed, "Mixed", location=(0.1, -1.5, 1.4), rotation_euler=(0.4, 0.3, 0.3))
    one_sample(scene)
    return scene, made


def set_up(made, c):
    made.displacement_method = c.method
    tree = made.node_tree
    tree.nodes.clear()
    raised = tree.nodes.new("ShaderNode" + c.kind)
    for key, value in c.settings.items():
        setattr(raised, key, value)
    for name, source in c.links.items():
        if isinstance(source, tuple) and isinstance(source[0], str):
            tree.links.new(tree.nodes.new("ShaderNode" + source[0]).outputs[source[1]], raised.inputs[name])
        elif name == "Vector":
            vector = tree.nodes.new("ShaderNodeCombineXYZ")
            for k in range(3):
                vector.inputs[k].default_value = source[k]
            tree.links.new(vector.outputs[0], raised.inputs[name])
        else:
            raised.inputs[name].default_value = source
    shine, end = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(tree.nodes.new("ShaderNodeNewGeometry").outputs[c.shown], shine.inputs["Color"])
    tree.links.new(shine.outputs[0], end.inputs["Surface"])
    tree.links.new(raised.outputs[0], end.inputs["Displacement"])


@pytest.mark.parametrize("c", CASES)
def test_surface_goes_where_cycles_puts_it(c, stage):
    scene, made = stage
    set_up(made, c)
    theirs, mine = cycles(scene), ours()
    error = np.abs(mine - theirs).max(axis=0) / (np.abs(theirs).max(axis=0) + 0.1)
    seen = np.abs(theirs).max(axis=0) + np.abs(mine).max(axis=0) > 0
    wrong = ~(error <= c.tolerance) & seen
    worst = np.argsort(error * seen)[-3:]
    assert wrong.sum() <= EDGES * max(seen.sum(), 1000), (
        f"{wrong.sum()} of {seen.sum()} pixels differ, for example at {worst}: "
        f"{mine[:, worst].T} instead of {theirs[:, worst].T}"
    )
