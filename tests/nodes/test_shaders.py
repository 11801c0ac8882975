"""Shader nodes become the closures they should, with the parameters they should."""

import numpy as np
import pytest
from support.node_lanes import NodeLanes
from support.scenes import rgba, shader

from pt_engine.nodes.compile import compile_materials
from pt_engine.nodes.coverage import APPROXIMATE, EXACT
from pt_engine.nodes.world import compile_light, compile_world
from pt_engine.scene.snapshot import Graph, Link, Node

PHONG = {"distribution": "ASHIKHMIN_SHIRLEY"}


def closures(graph, **lanes):
    compiled = compile_materials([graph])
    batch = compiled.batches[0]
    return batch, batch.closures(NodeLanes(n=3, **lanes))


@pytest.mark.parametrize(
    ("graph", "kinds", "dirac"),
    [
        (shader("BsdfDiffuse", Roughness=0.0), ("diffuse",), False),
        (shader("BsdfDiffuse", Roughness=0.4), ("oren_nayar",), False),
        (shader("BsdfTranslucent"), ("translucent",), False),
        (shader("BsdfSheen"), ("sheen",), False),
        (shader("BsdfSheen", props={"distribution": "ASHIKHMIN"}), ("velvet",), False),
        (shader("BsdfToon", props={"component": "DIFFUSE"}), ("toon",), False),
        (shader("BsdfToon", props={"component": "GLOSSY"}), ("toon_glossy",), False),
        (shader("BsdfAnisotropic", props=PHONG, Roughness=0.02), ("ashikhmin_shirley",), False),
        (shader("BsdfAnisotropic", props=PHONG, Roughness=0.01), ("ashikhmin_shirley",), True),
        (shader("BsdfRayPortal"), ("ray_portal",), True),
        (shader("BsdfTransparent"), ("transparent",), True),
        (shader("BsdfGlossy", props={"distribution": "GGX"}, Roughness=0.3), ("conductor",), False),
        (shader("BsdfAnisotropic", props={"distribution": "BECKMANN"}), ("conductor_beckmann",), False),
        (shader("BsdfGlossy", Roughness=0.0), ("conductor",), True),
        (
            shader("BsdfGlass", props={"distribution": "BECKMANN"}, Roughness=0.2),
            ("dielectric_beckmann",),
            False,
        ),
        (shader("BsdfGlass", Roughness=0.0), ("dielectric",), True),
        (shader("BsdfRefraction", Roughness=0.0), ("refraction",), True),
        (shader("PtConductor", Roughness=0.0), ("conductor",), True),
        (shader("PtDielectric", Roughness=0.3), ("dielectric",), False),
        (shader("PtRoughPlastic"), ("plastic",), False),
    ],
)
def test_closures_and_whether_they_are_only_dirac(graph, kinds, dirac):
    batch, made = closures(graph)
    assert batch.kinds == kinds
    assert batch.delta_only == dirac
    assert [c.bsdf.__name__.rpartition(".")[2] for c in made] == list(kinds)
    arrays = [c.weight for c in made] + [p for c in made for p in c.params if p is not None]
    assert {a.dtype for a in arrays} == {np.dtype(np.float32)}


def test_roughness_is_squared():
    _, (closure,) = closures(shader("BsdfGlossy", Roughness=0.3))
    np.testing.assert_allclose(closure.params.alpha_x, 0.09, rtol=1e-6)


@pytest.mark.parametrize(
    ("anisotropy", "x", "y"), [(0.5, 0.25 * 0.5, 0.25 / 0.5), (-0.5, 0.25 / 0.5, 0.25 * 0.5)]
)
def test_glossy_anisotropy(anisotropy, x, y):
    _, (closure,) = closures(shader("BsdfGlossy", Roughness=0.5, Anisotropy=anisotropy))
    np.testing.assert_allclose([closure.params.alpha_x[0], closure.params.alpha_y[0]], [x, y], rtol=1e-5)
    assert closure.tangent.shape == (3, 3)


def test_glass_turns_its_index_around_behind_the_face():
    behind = np.array([0, 1, 0], np.float32)
    _, (closure,) = closures(shader("BsdfGlass", IOR=1.5), backfacing=behind)
    np.testing.assert_allclose(closure.params.eta, [1.5, 1 / 1.5, 1.5], rtol=1e-6)


@pytest.mark.parametrize("kind", ["SubsurfaceScattering"])
def test_stand_ins_are_listed(kind):
    compiled = compile_materials([shader(kind)])
    assert compiled.coverage[0].state == APPROXIMATE
    assert compiled.coverage[0].effect


@pytest.mark.parametrize(("roughness", "state"), [(0.2, EXACT), (0.5, APPROXIMATE)])
def test_rough_ashikhmin_shirley_is_not_cycles_sampler(roughness, state):
    (entry,) = compile_materials([shader("BsdfAnisotropic", props=PHONG, Roughness=roughness)]).coverage
    assert entry.state == state


@pytest.mark.parametrize("roughness", [0.0, 0.6, 0.7, 1.0])
@pytest.mark.parametrize(
    ("kind", "inputs"),
    [("BsdfGlass", {}), ("BsdfRefraction", {}), ("BsdfPrincipled", {"Transmission Weight": 1.0})],
)
def test_what_cycles_adds_to_rough_glass_is_listed(kind, inputs, roughness):
    (entry,) = compile_materials([shader(kind, Roughness=roughness, **inputs)]).coverage
    assert entry.state == (EXACT if roughness <= 0.6 else APPROXIMATE)


def test_a_portal_leads_straight_on_unless_told_otherwise():
    """No direction, or one of length 0: −wi; the hit point stays where it is."""
    wi = np.array([[0.6], [0.0], [0.8]], np.float32)
    for inputs, expected in (({}, [-0.6, 0, -0.8]), ({"Direction": (0.0, 3.0, 4.0)}, [0, 0.6, 0.8])):
        compiled = compile_materials([shader("BsdfRayPortal", **inputs)])
        (closure,) = compiled.batches[0].closures(NodeLanes(n=1, wi=wi))
        np.testing.assert_allclose(closure.params.direction[:, 0], expected, atol=1e-7)
        assert closure.params.position is None
        assert [entry.state for entry in compiled.coverage] == [EXACT]


def test_a_constant_world():
    world = compile_world(shader("Background", Color=rgba((0.1, 0.2, 0.3)), Strength=2.0))
    np.testing.assert_allclose(world.constant, [0.2, 0.4, 0.6], rtol=1e-6)
    assert world.emits


def test_a_black_world_does_not_emit():
    assert not compile_world(None).emits
    assert not compile_world(shader("Background", Strength=0.0)).emits


def test_a_varying_world_depends_on_direction():
    nodes = (
        Node("TexCoord", "where", {}),
        Node("Background", "sky", {"Color": Link(0, "Generated"), "Strength": 1.0}),
    )
    world = compile_world(Graph("w", nodes, {"Surface": Link(1, "Background")}))
    assert world.constant is None
    direction = np.eye(3, dtype=np.float32)
    np.testing.assert_allclose(world.emission(NodeLanes(position=direction)), direction)


def test_a_lamp_tree_folds_to_its_factor():
    factor, coverage, _ = compile_light(shader("Emission", Color=rgba((1, 0.5, 0)), Strength=3.0))
    np.testing.assert_allclose(factor, [3, 1.5, 0])
    assert [entry.state for entry in coverage] == ["exact"]
    assert compile_light(None)[0].tolist() == [1, 1, 1]


def test_film_on_glass_is_seen_from_the_glass_when_behind():
    """Its index is then divided by the glass', as air lies beyond: 1.33/1.5."""
    graph = shader("BsdfGlass", **{"IOR": 1.5, "Thin Film Thickness": 300.0, "Thin Film IOR": 1.33})
    _, (closure,) = closures(graph, backfacing=np.array([0, 1, 0], np.float32))
    np.testing.assert_allclose(closure.params.film_ior, [1.33, 1.33 / 1.5, 1.33], rtol=1e-6)
    np.testing.assert_allclose(closure.params.film_thickness, 300)


@pytest.mark.parametrize("kind", ["Bump", "NormalMap", "Bevel"])
@pytest.mark.parametrize("socket", ["Color", "Strength"])
def test_a_normal_that_is_left_as_it_is_can_be_read(kind, socket):
    """A bump without height, a map of strength 0, a bevel without radius: the surface's normal."""
    bender = Node(kind, "b", {"Strength": 0.0, "Radius": 0.0})
    toward = Node("NewGeometry", "g")
    facing = Node(
        "VectorMath",
        "f",
        {"Vector": Link(0, "Normal"), "Vector_001": Link(1, "Incoming")},
        {"operation": "DOT_PRODUCT"},
    )
    source = Link(0, "Normal") if socket == "Color" else Link(2, "Value")
    shine = Node("Emission", "e", {"Color": rgba((1, 1, 1)), "Strength": 1.0} | {socket: source})
    compiled = compile_materials(
        [Graph("g", (bender, toward, facing, shine), {"Surface": Link(3, "Emission")})]
    )
    lanes = NodeLanes(n=1, wi=np.array([[0.6], [0.0], [0.8]], np.float32))
    lanes.ns = lanes.ng = np.array([[0.0], [0.0], [1.0]], np.float32)
    expected = [0, 0, 1] if socket == "Color" else [0.8] * 3
    np.testing.assert_allclose(compiled.batches[0].emission(lanes)[:, 0], expected, atol=1e-6)
