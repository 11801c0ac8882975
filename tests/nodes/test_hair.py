"""Shader nodes for hair: their closures' parameters, and where hair lies on triangles."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.bsdf_checks import direction
from support.closures import compiled_closures, name_of
from support.node_lanes import NodeLanes
from support.scenes import rgba, shader

from pt_engine.bsdfs import hair_chiang
from pt_engine.nodes import hair, hair_huang
from pt_engine.nodes.batch import Closure
from pt_engine.nodes.compile import compile_materials
from pt_engine.nodes.coverage import APPROXIMATE
from pt_engine.scene.snapshot import Graph, Link, Node

X_EDGE = np.array([[1.0], [0.0], [0.0]], np.float32)


def principled(way: str = "COLOR", model: str = "CHIANG", **sockets: Any) -> Closure:
    """The closure of a round Principled Hair; underscores stand for spaces."""
    inputs = {name.replace("_", " "): value for name, value in ({"Aspect_Ratio": 1.0} | sockets).items()}
    graph = shader("BsdfHairPrincipled", props={"model": model, "parametrization": way}, **inputs)
    (closure,) = compiled_closures(graph, direction(0.6, np.pi / 2))
    assert name_of(closure) == f"hair_{model.lower()}"
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


@pytest.mark.parametrize(("model", "effect"), [("CHIANG", "bumped; here not"), ("HUANG", "toward lamps")])
def test_where_hair_is_not_cycles_is_listed(model: str, effect: str) -> None:
    graph = shader("BsdfHairPrincipled", props={"model": model})
    (entry,) = compile_materials([graph]).coverage
    assert entry.state == APPROXIMATE
    assert effect in entry.effect


def test_huangs_hair_has_one_roughness_and_its_lobes_strengths() -> None:
    """None where all are 1, and never below 0; the colour's absorption goes by the one roughness."""
    closure = principled(model="HUANG", Roughness=0.4, Radial_Roughness=0.9, Offset=0.1, IOR=1.4)
    assert closure.params.strength is None
    np.testing.assert_allclose(closure.params.alpha, 0.4)
    np.testing.assert_allclose(closure.params.tilt, -0.1)
    np.testing.assert_allclose(closure.params.eta, 1.4)
    other = principled(model="CHIANG", Roughness=0.9, Radial_Roughness=0.4)
    np.testing.assert_allclose(closure.params.sigma, other.params.sigma)
    weak = principled(model="HUANG", R_lobe=0.5, TT_lobe=-1.0, TRT_lobe=2.0)
    np.testing.assert_allclose(weak.params.strength[:, 0], [0.5, 0, 2])


def test_huangs_hair_is_drawn_anew_with_each_path() -> None:
    """Even and independent uniforms from the lanes' noise, other ones for another node; without, halves."""
    n = 4096
    noise = np.random.default_rng(3).integers(0, 2**32, (2, n), dtype=np.uint32)
    one, other = (np.concatenate(vectors) for vectors in (drawn(noise, 1), drawn(noise, 2)))
    np.testing.assert_allclose(one.mean(axis=1), 0.5, atol=4 / np.sqrt(12 * n))
    table = np.corrcoef(np.concatenate([one, other]))
    assert np.abs(table - np.eye(len(table))).max() < 5 / np.sqrt(n)
    assert all((u == 0.5).all() for u in hair_huang.ways.function(NodeLanes(n), 1))


def drawn(noise: np.ndarray, key: int) -> list[np.ndarray]:
    return [np.atleast_2d(u) for u in hair_huang.ways.function(NodeLanes(noise.shape[1], noise=noise), key)]


@pytest.mark.parametrize("aspect", [0.4, 2.5])
def test_flat_hair_is_the_narrower_the_more_it_is_seen_from_its_edge(aspect: float) -> None:
    """√(cos²φ + b² sin²φ) of the radius; either axis may be the longer one on strands, as in Cycles."""
    b = hair_huang.shorter.function(np.float32([aspect]), np.float32([1]))
    np.testing.assert_allclose(b, 0.4)
    phi = np.float32([0, np.pi / 2, 1])
    edge = np.sqrt(np.cos(phi) ** 2 + 0.16 * np.sin(phi) ** 2)
    for share, missed in ((0.99, 0), (1.01, 1)):
        np.testing.assert_array_equal(hair_huang.beside.function(-share * edge, phi, b), missed)


def test_strands_have_random_numbers_of_their_own() -> None:
    """Where Random is not linked and something asks for it; meshes have the socket's."""
    lanes = NodeLanes(3)
    lanes.rounds = SimpleNamespace(curves=np.array([0, 2]))
    lanes.strand = lambda: np.array([[0.0], [0], [0.75], [0]], np.float32).repeat(3, axis=1)
    np.testing.assert_allclose(hair.own_random.function(lanes, np.float32([0.25])), [0.75, 0.25, 0.75])
