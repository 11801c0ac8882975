"""Holdouts: holes in the film, for the camera's rays alone."""

from __future__ import annotations

import numpy as np
import pytest
from support import scenes as make
from support.rooms import MIRROR

from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Graph, Link, Node

SKY = make.world((1.0, 0.5, 0.25))
HOLE = make.shader("Holdout")
INTEGRATORS = ["path", "path_fixed", "direct_mis"]


def mixed(kind, hole_share, **inputs):
    """A shader, by a share covered by a holdout."""
    other = make.output_of(kind)
    nodes = (
        Node(kind, "other", inputs),
        Node("Holdout", "hole", {}),
        Node(
            "MixShader",
            "mix",
            {"Fac": hole_share, "Shader": Link(0, other), "Shader_001": Link(1, "Holdout")},
        ),
    )
    return Graph(f"mix {kind}", nodes, {"Surface": Link(2, "Shader")})


def added(kind, **inputs):
    """A shader added to a holdout."""
    nodes = (
        Node(kind, "other", inputs),
        Node("Holdout", "hole", {}),
        Node("AddShader", "add", {"Shader": Link(0, make.output_of(kind)), "Shader_001": Link(1, "Holdout")}),
    )
    return Graph(f"add {kind}", nodes, {"Surface": Link(2, "Shader")})


def pixel(*layers, samples=1, clear=False, integrator="path", sky=SKY):
    """RGBA where a parallel camera looks straight down on wide sheets, the first one on top."""
    sheets = [(make.quad(9.0), make.translation(0, 0, -k), graph) for k, graph in enumerate(layers)]
    snapshot = make.scene(sheets, make.orthographic((0, 0, 3), (0, 0, 0), 1.0), sky=sky)
    image = make.rendered(snapshot, 2, samples=samples, film_transparent=clear, integrator=integrator).image()
    return image.reshape(-1, 4).mean(axis=0, dtype=np.float64)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("clear", [False, True])
def test_a_holdout_is_a_black_hole(clear, integrator):
    """Alpha 0 and no light, whether the sky is part of the image or not."""
    np.testing.assert_array_equal(pixel(HOLE, clear=clear, integrator=integrator), 0)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_share_of_it_is_a_share_of_a_hole(integrator):
    """Alpha is 1 − h and the emission (1 − h) Le: no random choice is made between them."""
    veil = mixed("Emission", 0.3, Color=make.WHITE, Strength=2.0)
    np.testing.assert_allclose(pixel(veil, integrator=integrator), [1.4, 1.4, 1.4, 0.7], rtol=1e-6)


def test_behind_a_veil_it_takes_what_the_veil_lets_through():
    """1 − mean(τ): the veil's absorption stays."""
    veil = make.shader("BsdfTransparent", Color=(0.9, 0.6, 0.3, 1.0))
    np.testing.assert_allclose(pixel(veil, HOLE), [0, 0, 0, 1 - 0.6], atol=1e-6)


@pytest.mark.parametrize(("clear", "alpha"), [(False, 1 - 0.25), (True, 1 - 0.25 - 0.75)])
def test_what_shows_through_it_counts_too(clear, alpha):
    """A quarter hole, the rest clear: the sky fills the rest where it is part of the image."""
    window = mixed("BsdfTransparent", 0.25, Color=make.WHITE)
    found = pixel(window, clear=clear)
    np.testing.assert_allclose(found[3], alpha, atol=1e-6)
    np.testing.assert_allclose(found[:3], np.array([1.0, 0.5, 0.25]) * 0.75 * (not clear), rtol=1e-6)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_nothing_that_is_added_to_it_is_seen(integrator):
    """A whole holdout ends the ray: neither emission nor reflection nor what is behind."""
    for graph in (
        added("Emission", Color=make.WHITE, Strength=5.0),
        added("BsdfDiffuse", Color=make.WHITE),
        added("BsdfTransparent", Color=make.WHITE),
    ):
        np.testing.assert_array_equal(pixel(graph, integrator=integrator), 0)


def test_to_other_rays_it_is_black_and_what_is_added_to_it_is_seen():
    """In a mirror: a black sheet without a hole; and an emission that the camera itself would not see."""
    below = make.orthographic((0, 0, 0.5), (0, 0, 0), 0.1)

    def reflected(graph):
        objects = [(make.quad(9.0), np.eye(4), MIRROR), (make.quad(9.0), make.translation(0, 0, 1), graph)]
        return make.rendered(make.scene(objects, below, sky=SKY), 2, samples=1).image()[0, 0]

    np.testing.assert_allclose(reflected(HOLE), [0, 0, 0, 1], atol=1e-7)
    shining = added("Emission", Color=make.WHITE, Strength=5.0)
    np.testing.assert_allclose(reflected(shining), [4.5, 4.5, 4.5, 1], rtol=1e-4)


def test_scenes_without_one_carry_no_coverage():
    """No memory and no work: the film's alpha is not kept, and the record says that it is off."""
    plain = make.scene(
        [(make.quad(), np.eye(4), make.diffuse(0.5))], make.orthographic((0, 0, 3), (0, 0, 0), 1.0)
    )
    scene = prepare(plain)
    assert scene.for_unit(4).alpha is None
    assert scene.features["holdouts"].startswith("off: ")
    assert prepare(make.scene([(make.quad(), np.eye(4), HOLE)], plain.camera)).features["holdouts"] == "on"
