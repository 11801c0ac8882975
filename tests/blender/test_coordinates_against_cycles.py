"""Nodes that read the shading point, seen by a camera: our whole way from export to hit against Cycles.

Objects with shear, mirroring, smooth and flat faces shine with a node's output. Cycles takes one sample
per pixel at its centre, we look there too; pixels on an edge may see different faces, so a small share
of pixels may differ.
"""

from typing import NamedTuple

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_scenes import add, cube, empty_scene  # noqa: E402
from support.camera_view import cycles, one_sample, ours  # noqa: E402

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="the nodes follow Cycles 5")
EDGES = 0.02  # share of pixels on an edge between faces


def sphere():
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12)
    owner = bpy.context.object
    data = owner.data
    bpy.data.objects.remove(owner)
    data.shade_smooth()
    return data


def with_layers(data):
    """A uv map and a corner colour attribute that vary."""
    if not data.uv_layers:
        data.uv_layers.new(name="UVMap")
    uv = np.array([c for k in range(len(data.loops)) for c in ((k % 4) in (1, 2), (k % 4) > 1)], np.float32)
    if len(data.polygons) == 6:
        data.uv_layers[0].data.foreach_set("uv", uv * 1.3 - 0.1)
    color = data.color_attributes.new("Tint", "FLOAT_COLOR", "CORNER")
    values = np.random.default_rng(5).uniform(0, 1, (len(data.loops), 4)).astype(np.float32)
    color.data.foreach_set("color", values.ravel())
    return data


def build():
    scene = empty_scene()
    camera = scene.camera
    camera.location, camera.rotation_euler = (0.4, -7.0, 2.2), (1.28, 0.05, 0.06)
    settings = {"pass_index": 3, "color": (0.2, 0.5, 0.7, 0.6)}
    made = bpy.data.materials.new("Test")
    made.use_nodes = True
    ball_data, box_data = with_layers(sphere()), with_layers(cube())
    for data in (ball_data, box_data):
        data.materials.append(made)
    ball = add(ball_data, "Ball", location=(-1.4, 0, 0.2), scale=(1.2, 1.2, 1.2), **settings)
    ball.rotation_euler = (0.3, 0.5, 0.2)
    box = add(box_data, "Box", location=(1.4, 0.5, 0), scale=(0.8, -0.7, 1.1), **settings)
    box.rotation_euler = (0.4, 0.3, 0.7)
    one_sample(scene)
    return scene, made.node_tree


class Case(NamedTuple):
    """Nodes from source to output; what feeds the node; how many pixels may differ and by how much."""

    kind: str
    output: str
    settings: dict
    links: dict
    share: float = EDGES
    tolerance: float = 2e-3


def case(kind, output, share=EDGES, tolerance=2e-3, links=None, **settings):
    label = " ".join([kind, output, *(str(v) for v in settings.values() if isinstance(v, str | bool))])
    return pytest.param(Case(kind, output, settings, links or {}, share, tolerance), id=label)


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
    # approximate: tangents per triangle
    case("NormalMap", "Normal", 0.12, 0.05, links={"Color": (0.6, 0.3, 0.9, 1), "Strength": 0.7}),
    case("Tangent", "Tangent", 0.12, 0.05, direction_type="UV_MAP"),
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


def picture():
    """A small byte image with structure in every channel."""
    image = bpy.data.images.get("Picture")
    if image is None:
        image = bpy.data.images.new("Picture", 7, 5, alpha=True)
        values = np.random.default_rng(2).integers(0, 256, (5, 7, 4)).astype(np.float32) / 255
        values[..., 3] = np.maximum(values[..., 3], 0.3)
        image.pixels.foreach_set(values.ravel())
        image.update()
        image.pack()
    return image


@pytest.fixture(scope="module")
def stage():
    return build()


def set_up(tree, c):
    """The material shines with the case's output."""
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNode" + c.kind)
    for key, value in c.settings.items():
        setattr(node, key, picture() if key == "image" else value)
    sources = {}
    for name, source in c.links.items():
        if isinstance(source, tuple) and isinstance(source[0], str):
            kind, output = source
            if kind not in sources:
                sources[kind] = tree.nodes.new("ShaderNode" + kind)
            tree.links.new(sources[kind].outputs[output], node.inputs[name])
        else:
            node.inputs[name].default_value = source
    shine, end = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(next(s for s in node.outputs if s.identifier == c.output), shine.inputs["Color"])
    tree.links.new(shine.outputs[0], end.inputs["Surface"])


@pytest.mark.parametrize("c", CASES)
def test_camera_sees_what_cycles_sees(c, stage):
    scene, tree = stage
    set_up(tree, c)
    theirs, mine = cycles(scene), ours()
    error = np.abs(mine - theirs).max(axis=0) / (np.abs(theirs).max(axis=0) + 0.1)
    seen = np.abs(theirs).max(axis=0) + np.abs(mine).max(axis=0) > 0
    wrong = ~(error <= c.tolerance) & seen
    worst = np.argsort(error * seen)[-3:]
    assert wrong.sum() <= c.share * max(seen.sum(), 1000), (
        f"{wrong.sum()} of {seen.sum()} pixels differ, for example at {worst}: "
        f"{mine[:, worst].T} instead of {theirs[:, worst].T}"
    )
