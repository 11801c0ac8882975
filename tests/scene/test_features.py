"""The report's list of effects: on where the scene calls for one, else off with the reason."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.rooms import MIRROR, ROUGH, half_transparent

from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Graph, LightData, Link, Node

UP = np.eye(4)
CAMERA = make.perspective((0, -5, 0), (0, 0, 0))
GREY = make.diffuse(0.5)
PLAIN = ((make.quad(), GREY),)


def of(objects=PLAIN, lights=(), sky=None, camera=CAMERA, film_transparent=False):
    row = [(m, make.translation(3 * k, 0, 0), g) for k, (m, g) in enumerate(objects)]
    return prepare(make.scene(row, camera, lights, sky), film_transparent).features


def lamp(kind="POINT", power=10.0, **more):
    return LightData(kind, kind, make.translation(0, 0, 3), power, **more)


def test_a_bare_scene_calls_for_nothing():
    """One grey square in the dark: every effect is off, each with its reason."""
    found = of()
    assert [name for name, state in found.items() if state == "on"] == []
    assert all(state.startswith("off: ") and len(state) > 10 for state in found.values())


@pytest.mark.parametrize(
    "nothing",
    [
        {"lights": [lamp(power=0.0)]},
        {"lights": [lamp("SUN", 0.0, angle=0.1)]},
        {"lights": [lamp("AREA", 10.0, color=(0, 0, 0))]},
        {"lights": [lamp("AREA", 10.0, size=(0.0, 1.0))]},
        {"sky": make.world(0.0)},
        {"sky": make.shader("Background", "w", Color=make.WHITE, Strength=0.0)},
        {"camera": replace(CAMERA, aperture_radius=0.0, blades=6)},
        {"objects": [(make.quad(), half_transparent(0.0))]},
        {"objects": [(make.quad(), make.emission(0.0))]},
        {"objects": [(make.quad(), make.shining_diffuse(0.5, 0.0))]},
        {"objects": [(make.quad(), make.shader("Emission", "e", Color=make.WHITE, Strength=0.0))]},
    ],
    ids=lambda what: str(next(iter(what))),
)
def test_what_is_set_to_nothing_is_no_feature(nothing):
    """Power, strength, colour, size, aperture or mix factor 0: as if it were not there."""
    found = of(**nothing)
    assert [name for name, state in found.items() if state == "on"] == []


ON = [
    ("depth of field", {"camera": replace(CAMERA, aperture_radius=0.1)}),
    ("environment", {"sky": make.world(0.5)}),
    ("lamps", {"lights": [lamp()]}),
    ("Dirac lamps", {"lights": [lamp()]}),
    ("lamps met by rays", {"lights": [lamp(radius=0.2)]}),
    ("mesh lights", {"objects": [(make.quad(), make.emission(1.0))]}),
    ("light choice", {"lights": [lamp(), lamp("SUN")]}),
    ("light choice", {"objects": [(make.quad(), make.emission(1.0)), (make.quad(), make.emission(2.0))]}),
    ("shading normals", {"objects": [(make.sphere(1, 6), GREY)]}),
    ("transparent surfaces", {"objects": [(make.quad(), half_transparent(0.5))]}),
    ("several closures", {"objects": [(make.quad(), half_transparent(0.5))]}),
    ("transparent film", {"film_transparent": True}),
    ("ideal specular", {"objects": [(make.quad(), MIRROR)]}),
    ("material batches", {"objects": [(make.quad(), GREY), (make.quad(), ROUGH)]}),
]


@pytest.mark.parametrize(("name", "what"), ON, ids=[name for name, _ in ON])
def test_an_effect_that_is_there_is_on(name, what):
    assert of(**what)[name] == "on"


def test_effects_are_told_apart():
    """A lamp with a size is no Dirac lamp; one without is met by no ray; like materials share a program."""
    sized, point = of(lights=[lamp(radius=0.2)]), of(lights=[lamp()])
    assert sized["Dirac lamps"].startswith("off")
    assert point["lamps met by rays"].startswith("off")
    assert point["light choice"].startswith("off")
    assert of([(make.quad(), make.emission(1.0))])["light choice"].startswith("off")  # one, of two triangles
    greys = [(make.quad(), make.diffuse(k / 10, f"m{k}")) for k in range(9)]
    assert of(greys)["material batches"].startswith("off")
    assert of(sky=make.world(0.5))["environment sampling"].startswith("off")
    assert of([(make.quad(), ROUGH)])["ideal specular"].startswith("off")


def reads(node: Node, shader: str) -> Graph:
    output = {"UVMap": "UV", "VertexColor": "Color", "NewGeometry": "Position"}[node.kind]
    end = Node(shader, "end", {"Color": Link(0, output), "Strength": 1.0, "Roughness": 0.0})
    return Graph(f"reads {node.kind}", (node, end), {"Surface": Link(1, make.output_of(shader))})


@pytest.mark.parametrize("shader", ["BsdfDiffuse", "Emission"])
@pytest.mark.parametrize(
    ("name", "node"),
    [
        ("uv maps", Node("UVMap", "uv", {}, {"uv_map": "map"})),
        ("colour attributes", Node("VertexColor", "paint", {}, {"layer_name": "paint"})),
    ],
)
def test_attributes_are_on_where_a_visible_material_reads_one(name, node, shader):
    """Whether it scatters or only shines; a material that no triangle has does not count."""
    graph = reads(node, shader)
    assert of([(make.quad(), graph)])[name] == "on"
    unused = make.scene([(make.quad(), UP, GREY)], CAMERA)
    unused = replace(unused, materials=(*unused.materials, graph))
    assert prepare(unused).features[name].startswith("off")


def test_light_that_varies_over_a_mesh():
    graph = reads(Node("VertexColor", "paint", {}, {"layer_name": "paint"}), "Emission")
    paint = np.random.default_rng(1).random((4, 4)).astype(np.float32)
    found = of([(replace(make.quad(), colors={"paint": paint}), graph)])
    assert found["mesh lights that vary"] == "on"
    assert of([(make.quad(), make.emission(1.0))])["mesh lights that vary"].startswith("off")


def test_the_world_is_sampled_where_it_varies():
    nodes = (
        Node("TexCoord", "where", {}, {}),
        Node("Background", "sky", {"Color": Link(0, "Generated"), "Strength": 1.0}),
    )
    found = of(sky=Graph("varying", nodes, {"Surface": Link(1, "Background")}))
    assert found["environment"] == found["environment sampling"] == "on"


def test_a_material_in_no_visible_slot_calls_for_nothing():
    """Transparent, mirror and lamp lie in slots that no triangle uses."""
    snapshot = make.scene([(make.quad(), UP, GREY)], CAMERA)
    more = (half_transparent(0.5), MIRROR, make.emission(1.0))
    snapshot = replace(
        snapshot,
        materials=snapshot.materials + more,
        instances=replace(snapshot.instances, materials=np.array([[1, 2, 3, 4]], np.int32)),
    )
    found = prepare(snapshot).features
    assert [name for name, state in found.items() if state == "on"] == []
