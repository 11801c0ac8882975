"""EEVEE's own nodes: stand-ins that say so."""

from __future__ import annotations

import numpy as np
import pytest
from support.bsdf_checks import direction
from support.node_lanes import NodeLanes
from support.scenes import WHITE, rgba, shader

from pt_engine.nodes.compile import compile_materials
from pt_engine.nodes.coverage import APPROXIMATE, EXACT
from pt_engine.nodes.world import compile_world
from pt_engine.scene.snapshot import Graph, Link, Node


def seen(*nodes, output="Color"):
    """What the last node's shader gives as a colour or alpha, shining."""
    last = len(nodes)
    to_rgb = Node("ShaderToRGB", "to rgb", {"Shader": Link(last - 1, "BSDF")})
    shine = Node("Emission", "shine", {"Color": Link(last, output), "Strength": 1.0})
    graph = Graph("test", (*nodes, to_rgb, shine), {"Surface": Link(last + 1, "Emission")})
    compiled = compile_materials([graph])
    states = {entry.node: entry.state for entry in compiled.coverage}
    assert (states["to rgb"], states["shine"]) == (APPROXIMATE, EXACT)
    value = compiled.batches[0].emission(NodeLanes(n=1, wi=direction(0.5)))
    return np.zeros(3) if value is None else value[:, 0]


def test_a_diffuse_shader_is_its_colour():
    """ρ under radiance 1 from everywhere."""
    node = Node("BsdfDiffuse", "d", {"Color": rgba((0.8, 0.4, 0.1)), "Roughness": 0.0})
    np.testing.assert_allclose(seen(node), [0.8, 0.4, 0.1], rtol=1e-6)


def test_an_emission_is_itself():
    node = Node("Emission", "e", {"Color": rgba((0.8, 0.4, 0.1)), "Strength": 3.0})
    np.testing.assert_allclose(seen(node), [2.4, 1.2, 0.3], rtol=1e-6)


@pytest.mark.parametrize("roughness", [0.0, 0.5])
def test_a_white_principled_is_about_white(roughness):
    """The gloss counts as Fresnel's law has it for the smooth surface, so the sum errs a little."""
    node = Node("BsdfPrincipled", "p", {"Base Color": WHITE, "Roughness": roughness})
    np.testing.assert_allclose(seen(node), 1.0, atol=0.05)


def test_alpha_is_what_is_not_transparent():
    nodes = (
        Node("BsdfDiffuse", "d", {"Color": rgba(0.5), "Roughness": 0.0}),
        Node("BsdfTransparent", "t", {"Color": WHITE}),
        Node("MixShader", "m", {"Fac": 0.25, "Shader": Link(0, "BSDF"), "Shader_001": Link(1, "BSDF")}),
    )
    np.testing.assert_allclose(seen(*nodes, output="Alpha"), 0.75, rtol=1e-6)
    np.testing.assert_allclose(seen(*nodes), 0.375, rtol=1e-6)


def test_in_a_world_only_emission_counts():
    nodes = (
        Node("Background", "b", {"Color": rgba((0.1, 0.2, 0.3)), "Strength": 1.0}),
        Node("ShaderToRGB", "to rgb", {"Shader": Link(0, "Background")}),
        Node("Background", "sky", {"Color": Link(1, "Color"), "Strength": 2.0}),
    )
    world = compile_world(Graph("w", nodes, {"Surface": Link(2, "Background")}))
    np.testing.assert_allclose(world.constant, [0.2, 0.4, 0.6], rtol=1e-6)


@pytest.mark.parametrize(
    ("sockets", "kinds"),
    [
        ({"Specular": rgba(0.0)}, ("diffuse",)),
        ({"Specular": rgba(0.04)}, ("conductor", "diffuse")),
        ({"Clear Coat": 0.5, "Transparency": 0.2}, ("specular", "conductor", "diffuse", "transparent")),
    ],
)
def test_the_specular_node_has_its_layers(sockets, kinds):
    graph = shader("EeveeSpecular", **{"Emissive Color": rgba(0.5)} | sockets)
    compiled = compile_materials([graph])
    assert sorted(compiled.batches[0].kinds) == sorted(kinds)
    assert compiled.coverage[0].state == APPROXIMATE
    np.testing.assert_allclose(compiled.emission_constant[0], 0.5)
