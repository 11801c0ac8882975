"""No closure node makes light: white ones in a white furnace, at the corners of their parameters.

E(θ) = ∫ f·|cosθo| dωo ≤ 1, by quadrature over the compiled closures; single-scattering models lose what
bounces between facets, so those are held from above only. Where tables make up for it (MULTI_GGX), E is 1
up to their interpolation: 1.5 % as in the tests of the tables.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from support.bsdf_checks import direction
from support.closures import furnace_albedo

from pt_engine.scene.snapshot import Graph, Link, Node

pytestmark = pytest.mark.slow  # physics that no Python changes

WHITE = (1.0, 1.0, 1.0, 1.0)
COSINES = (1.0, 0.4, 0.05)
QUADRATURE = 0.012  # a grid of 64² loses or finds so much at the edge of the failed samples
ROUGH = (0.0, 1e-4, 0.02, 0.5, 1.0, 2.0, -1.0)
IORS = (1.0, 1.0001, 1.5, 50.0, 0.3, 0.0)


def albedos(kind: str, inputs: dict[str, Any], **props: Any) -> list[float]:
    """E of a closure node alone at some angles, the largest channel."""
    node = Node(kind, kind, {"Color": WHITE, "Base Color": WHITE, "Edge Tint": WHITE} | inputs, props)
    graph = Graph("White", (node,), {"Surface": Link(0, "BSDF")})
    return [float(furnace_albedo(graph, direction(cos), rows=64).max()) for cos in COSINES]


@pytest.mark.parametrize("rough", ROUGH)
@pytest.mark.parametrize("kind", ["BsdfDiffuse", "BsdfTranslucent", "BsdfTransparent"])
def test_simple_closures_reflect_at_most_all(kind: str, rough: float) -> None:
    for albedo in albedos(kind, {"Roughness": rough}):
        assert 0 <= albedo <= 1 + 1e-3  # the grid's error


@pytest.mark.parametrize("anisotropy", [0.0, 1.0, -1.0, 5.0])
@pytest.mark.parametrize("distribution", ["BECKMANN", "GGX", "MULTI_GGX", "ASHIKHMIN_SHIRLEY"])
@pytest.mark.parametrize("kind", ["BsdfAnisotropic", "BsdfMetallic"])
def test_metals_reflect_at_most_all(kind: str, distribution: str, anisotropy: float) -> None:
    for rough in ROUGH:
        inputs = {"Roughness": rough, "Anisotropy": anisotropy, "Rotation": 0.3}
        for albedo in albedos(kind, inputs, distribution=distribution):
            assert 0 <= albedo <= 1 + QUADRATURE


@pytest.mark.parametrize("distribution", ["BECKMANN", "GGX", "MULTI_GGX"])
@pytest.mark.parametrize("kind", ["BsdfGlass", "BsdfRefraction"])
def test_glass_passes_on_at_most_all(kind: str, distribution: str) -> None:
    for rough, ior in itertools.product(ROUGH, IORS):
        for albedo in albedos(kind, {"Roughness": rough, "IOR": ior}, distribution=distribution):
            assert 0 <= albedo <= 1.02


@pytest.mark.parametrize("kind", ["BsdfAnisotropic", "BsdfMetallic", "BsdfGlass"])
def test_many_bounces_lose_nothing(kind: str) -> None:
    for rough in (0.0, 0.2, 0.5, 1.0):
        found = albedos(kind, {"Roughness": rough, "IOR": 1.5}, distribution="MULTI_GGX")
        np.testing.assert_allclose(found[:2], 1.0, atol=0.015 + QUADRATURE)


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0, 7.0, -1.0])
def test_mixing_keeps_energy(share: float) -> None:
    """Mix takes t and 1 − t of its two, t clamped."""
    closures = tuple(Node(kind, kind, {"Color": WHITE}) for kind in ("BsdfDiffuse", "BsdfTransparent"))
    mix = Node("MixShader", "Mix", {"Fac": share, "Shader": Link(0, "BSDF"), "Shader_001": Link(1, "BSDF")})
    graph = Graph("White", (*closures, mix), {"Surface": Link(2, "Shader")})
    np.testing.assert_allclose(furnace_albedo(graph, direction(0.5), rows=32), 1.0, atol=1e-4)
