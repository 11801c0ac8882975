"""A lamp whose nodes vary shines the same however it is found, and costs nothing where none does."""

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.estimates import assert_same_mean, mean_and_error
from support.rooms import ROUGH, SOFT_LAMP, room

from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Graph, LightData, Link, Node, Visibility

BALL = LightData("POINT", "ball", make.translation(-0.5, -0.5, 2.2), 100.0, radius=0.4)
SOFT = replace(BALL, soft_falloff=True)


def striped(kind, output):
    """A lamp's tree that shines with some coordinate, three times over."""
    nodes = (
        Node(kind, "where", {}),
        Node("VectorMath", "often", {"Vector": Link(0, output), "Scale": 3.0}, {"operation": "SCALE"}),
        Node("VectorMath", "saw", {"Vector": Link(1, "Vector")}, {"operation": "FRACTION"}),
        Node("Emission", "shine", {"Color": Link(2, "Vector"), "Strength": 1.0}),
    )
    return Graph("striped", nodes, {"Surface": Link(3, "Emission")})


@pytest.mark.parametrize("lamp", [SOFT_LAMP, BALL, SOFT], ids=["area", "ball", "soft ball"])
@pytest.mark.parametrize("output", [("TexCoord", "UV"), ("NewGeometry", "Position")], ids=lambda o: o[1])
def test_three_strategies_agree(lamp, output):
    snapshot = room(ROUGH, replace(lamp, graph=striped(*output)))
    a, b, c = (
        make.rendered(snapshot, 16, samples=64, integrator=name, seed=k)
        for k, name in enumerate(("direct_bsdf", "direct_emitter", "direct_mis"))
    )
    assert_same_mean(a, c)
    assert_same_mean(b, c)
    assert mean_and_error(c)[0].max() > 0.01


def test_a_camera_sees_the_stripes():
    lamp = replace(BALL, graph=striped("NewGeometry", "Normal"), visibility=Visibility.ALL)
    picture = make.rendered(room(ROUGH, lamp), 64, samples=4).image()[..., 0]
    plain = make.rendered(room(ROUGH, replace(lamp, graph=None)), 64, samples=4).image()[..., 0]
    ball = plain > 0.9 * plain.max()
    assert ball.sum() > 20
    assert np.std(picture[ball] / plain[ball]) > 0.1


def test_constant_lamps_have_no_shader():
    """Their factor is in their strength; only lamps that vary are evaluated where they are sampled."""
    red = make.emission((1.0, 0.0, 0.0), "red")
    scene = prepare(room(ROUGH, replace(BALL, graph=red)))
    assert [part._shaders for part in scene.lights._lamps] == [[]]


def test_a_dark_side_does_not_make_a_lamp_vanish():
    """Bright in a cone of two degrees alone: too thin for the mean, but it keeps a chance to be chosen."""
    nodes = (
        Node("NewGeometry", "where", {}),
        Node("SeparateXYZ", "axes", {"Vector": Link(0, "Incoming")}),
        Node("Math", "beam", {"Value": Link(1, "Z"), "Value_001": -0.9998}, {"operation": "LESS_THAN"}),
        Node("Emission", "shine", {"Color": (1.0, 1.0, 1.0, 1.0), "Strength": Link(2, "Value")}),
    )
    beam = Graph("beam", nodes, {"Surface": Link(3, "Emission")})
    lamp = LightData("POINT", "beam", make.translation(0, 0, 3), 4 * np.pi * 9 * np.pi, graph=beam)
    floor = (make.quad(100.0), make.translation(0, 0, 0), make.diffuse(1.0))
    camera = make.perspective((0, -0.1, 4), (0, 0, 0), 0.001)
    mean, _ = mean_and_error(make.rendered(make.scene([floor], camera, [lamp]), 2, samples=4))
    np.testing.assert_allclose(mean, 1.0, rtol=1e-3)  # E/π = Φ/4π / d² / π
