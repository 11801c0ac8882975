"""Nodes that ask for a face, a strand or an object, on lamps and in the sky, which have none."""

from __future__ import annotations

import numpy as np
import pytest

from pt_engine.core.raykind import RayKind
from pt_engine.core.view import View
from pt_engine.nodes.coverage import APPROXIMATE
from pt_engine.nodes.world import compile_light, compile_world
from pt_engine.scene.arrivals import Arrivals
from pt_engine.scene.lamp_shader import LampShader
from pt_engine.scene.sky_lanes import SkyLanes
from pt_engine.scene.snapshot import Graph, LightData, Link, Node

UP = (0.0, 0.0, 1.0)
OUTPUTS = {
    "NewGeometry": ("Normal", "Tangent", "True Normal", "Parametric", "Backfacing", "Pointiness"),
    "HairInfo": ("Is Strand", "Intercept", "Length", "Thickness", "Tangent Normal", "Random"),
    "PointInfo": ("Position", "Radius", "Random"),
    "TexCoord": ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection"),
    "ParticleInfo": ("Index", "Random", "Age", "Lifetime", "Location", "Size", "Velocity"),
    "ObjectInfo": ("Location", "Color", "Object Index", "Material Index", "Random"),
    "Attribute": ("Color", "Vector", "Fac", "Alpha"),
    "VertexColor": ("Color", "Alpha"),
    "Tangent": ("Tangent",),
    "Wireframe": ("Fac",),
    "UVMap": ("UV",),
    "LightPath": ("Ray Length", "Ray Depth", "Diffuse Depth", "Transparent Depth", "Is Shadow Ray"),
}
WITH_INPUTS = (
    (Node("Bevel", "n", {"Radius": 0.1}), "Normal"),
    (Node("Bump", "n", {"Height": Link(0, "Incoming"), "Strength": 1.0, "Distance": 1.0}), "Normal"),
    (Node("NormalMap", "n", {"Color": (0.7, 0.4, 0.9, 1.0), "Strength": 1.0}), "Normal"),
    (Node("Displacement", "n", {"Height": 1.0, "Midlevel": 0.0, "Scale": 1.0}), "Displacement"),
    *(
        (Node("VectorDisplacement", "n", {"Vector": UP, "Scale": 1.0}, {"space": space}), "Displacement")
        for space in ("TANGENT", "OBJECT", "WORLD")
    ),
    (Node("AmbientOcclusion", "n", {"Color": (1.0,) * 4, "Distance": 1.0}), "AO"),
)
CASES = [(Node(kind, "n"), output) for kind, outputs in OUTPUTS.items() for output in outputs]
CASES += [*WITH_INPUTS]


def shining(node, output):
    """An emitter's graph that takes its colour from an output of a node."""
    shine = Node("Emission", "shine", {"Color": Link(1, output), "Strength": 1.0})
    return Graph("g", (Node("NewGeometry", "g"), node, shine), {"Surface": Link(2, "Emission")})


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "SUN", "AREA"])
def test_a_lamp_answers_every_node(kind):
    data = LightData("lamp", kind, np.eye(4), 1.0, (1.0, 1.0, 1.0), radius=0.1, size=(1.0, 1.0))
    p = np.array([[0.2, 0.1, -2], [0.5, -0.3, -1]], np.float32).T.copy()
    wo = -p / np.linalg.norm(p, axis=0)
    for node, output in CASES:
        program = compile_light(shining(node, output))
        if program.batch is not None:
            seen = LampShader(program.batch, data, np.zeros(3), 1.0, View()).factor(p, wo)
            assert np.isfinite(seen).all(), (node.kind, output)


def test_the_sky_answers_every_node():
    d = np.array([[0.6, 0, 0.8], [0.28, -0.96, 0.1]], np.float32).T.copy()
    for node, output in CASES:
        world = compile_world(shining(node, output))
        seen = world.emission(SkyLanes(d, Arrivals.by(RayKind.CAMERA, 2), View()))
        assert np.isfinite(seen).all(), (node.kind, output)


@pytest.mark.parametrize("output", ["Ray Depth", "Diffuse Depth", "Glossy Depth", "Transparent Depth"])
def test_a_lamp_that_asks_for_the_path_is_listed(output):
    """How deep the path is that its light joins, a lamp cannot know."""
    states = {entry.state for entry in compile_light(shining(Node("LightPath", "n"), output)).coverage}
    assert APPROXIMATE in states


def test_a_lamp_knows_its_object():
    color = (0.3, 0.7, 0.2, 0.6)
    data = LightData("lamp", "AREA", np.eye(4), 1.0, object_color=color, pass_index=3, random=0.4)
    p, wo = np.zeros((3, 1), np.float32), np.array([[0], [0], [1]], np.float32)
    for output, value in (("Color", color[:3]), ("Alpha", 0.6), ("Object Index", 3), ("Random", 0.4)):
        batch = compile_light(shining(Node("ObjectInfo", "n"), output)).batch
        seen = LampShader(batch, data, np.zeros(3), 1.0, View()).factor(p, wo)
        np.testing.assert_allclose(seen.mean(axis=1), value, rtol=1e-6)
