"""Shader nodes for hair: their closures' parameters, and where hair lies on triangles."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.bsdf_checks import direction
from support.closures import compiled_closures, name_of
from support.scenes import rgba, shader

from pt_engine.bsdfs import hair_chiang
from pt_engine.nodes.batch import Closure
from pt_engine.nodes.compile import compile_materials
from pt_engine.nodes.coverage import APPROXIMATE
from pt_engine.scene.snapshot import Graph, Link, Node

X_EDGE = np.array([[1.0], [0.0], [0.0]], np.float32)


def principled(way: str = "COLOR", model: str = "CHIANG", **sockets: Any) -> Closure:
    """The closure of a Principled Hair; underscores stand for spaces."""
    inputs = {name.replace("_", " "): value for name, value in sockets.items()}
    graph = shader("BsdfHairPrincipled", props={"model": model, "parametrization": way}, **inputs)
    (closure,) = compiled_closures(graph, direction(0.6, np.pi / 2))
    assert name_of(closure) == "hair_chiang"
    return closure


@pytest.mark.parametrize(
    ("component", "model"), [("Reflection", "hair_reflection"), ("Transmission", "hair_transmission")]
)
def test_component_chooses_the_lobe(component: str, model: str) -> None:
    graph = shader("BsdfHair", props={"component": component}, Color=rgba((0.5, 0.5, 0.5)), Offset=0.3)
    (closure,) = compiled_closures(graph, direction(0.6))
    assert name_of(closure) == model
    np.testing.assert_allclose(closure.weight, 0.5)
    assert closure.params.offset == 0  # triangles' own tangent is not tilted
    np.testing.assert_allclose(closure.tangent[:, 0], [0, 1, 0], atol=1e-7)  # the edge to corner 2


def test_linked_tangent_is_tilted_and_leans() -> None:
    nodes = (
        Node("Combxyz", "nothing", {}),
        Node("NewGeometry", "geometry", {}),
        Node("BsdfHair", "hair", {"Tangent": Link(1, "Incoming"), "Offset": 0.3}),
    )
    (closure,) = compiled_closures(Graph("test", nodes, {"Surface": Link(2, "BSDF")}), direction(0.6))
    np.testing.assert_allclose(closure.params.offset, -0.3, rtol=1e-6)
    np.testing.assert_allclose(closure.params.lean, 0.6, rtol=1e-6)


def test_principled_hair_lies_along_the_first_edge() -> None:
    """Seen across it at cosine 0.6: T × wi is (0, −0.6, 0.8), so the ray hits at h = −n·(T × wi) = −0.8."""
    closure = principled()
    np.testing.assert_allclose(closure.tangent[:, :1], X_EDGE, atol=1e-7)
    np.testing.assert_allclose(closure.params.h, -0.8, rtol=1e-6)


def test_melanin_absorbs() -> None:
    """−log(1 − m) of eumelanin and pheomelanin; a white tint adds nothing."""
    closure = principled("MELANIN", Melanin=0.5, Melanin_Redness=0.25, Tint=rgba((1.0, 1.0, 1.0)))
    amount = np.log(2.0)
    expected = amount * (0.75 * np.array([0.506, 0.841, 1.653]) + 0.25 * np.array([0.343, 0.733, 1.924]))
    np.testing.assert_allclose(closure.params.sigma[:, 0], expected, rtol=1e-5)


def test_color_absorbs_the_more_the_rougher_the_hair() -> None:
    """(log c / (5.969 − 0.215 β + 2.532 β² − 10.73 β³ + 5.574 β⁴ + 0.245 β⁵))²: Chiang's equation 9."""
    beta, color = 0.6, np.array([0.8, 0.3, 0.05])
    closure = principled(Color=rgba(tuple(color)), Radial_Roughness=beta)
    scale = np.polyval([0.245, 5.574, -10.73, 2.532, -0.215, 5.969], beta)
    np.testing.assert_allclose(closure.params.sigma[:, 0], (np.log(color) / scale) ** 2, rtol=1e-5)


def test_random_numbers_spread_roughness_and_melanin() -> None:
    """Times 1 ± amount: at Random 1, roughness 0.3 of amount 0.5 is 0.45, and melanin 0.4 of 0.25 is 0.5."""
    closure = principled(
        "MELANIN", Random=1.0, Random_Roughness=0.5, Roughness=0.3, Radial_Roughness=0.2, Melanin=0.4,
        Random_Color=0.25, Melanin_Redness=0.0, Tint=rgba((1.0, 1.0, 1.0)),
    )  # fmt: skip
    np.testing.assert_allclose(closure.params.v, hair_chiang.variance(np.float32(0.45)), rtol=1e-5)
    np.testing.assert_allclose(closure.params.s, hair_chiang.scale(np.float32(0.3)), rtol=1e-5)
    np.testing.assert_allclose(closure.params.sigma[0], np.log(2) * 0.506, rtol=1e-5)


def test_coat_makes_the_first_reflection_smoother() -> None:
    closure = principled(Coat=0.75, Roughness=0.4)
    np.testing.assert_allclose(closure.params.v0, hair_chiang.variance(np.float32(0.1)), rtol=1e-5)
    np.testing.assert_allclose(closure.params.v, hair_chiang.variance(np.float32(0.4)), rtol=1e-5)


@pytest.mark.parametrize(("model", "effect"), [("CHIANG", "on meshes"), ("HUANG", "instead of Huang's")])
def test_where_hair_is_not_cycles_is_listed(model: str, effect: str) -> None:
    graph = shader("BsdfHairPrincipled", props={"model": model})
    (entry,) = compile_materials([graph]).coverage
    assert entry.state == APPROXIMATE
    assert effect in entry.effect
    closure = principled(model=model, Roughness=0.4, Radial_Roughness=0.9, Coat=1.0)
    around = 0.4 if model == "HUANG" else 0.9  # Huang's has one roughness and no coat
    np.testing.assert_allclose(closure.params.s, hair_chiang.scale(np.float32(around)), rtol=1e-5)


def test_huangs_lobes_have_strengths() -> None:
    """None where all are 1, and never below 0; Chiang's model has no such inputs."""
    assert principled(model="HUANG").params.strength is None
    weak = principled(model="HUANG", R_lobe=0.5, TT_lobe=-1.0, TRT_lobe=2.0)
    np.testing.assert_allclose(weak.params.strength[:, 0], [0.5, 0, 2])
    assert principled(R_lobe=0.5).params.strength is None
