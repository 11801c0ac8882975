"""Shader nodes become the closures they should, with the parameters they should."""

import numpy as np
import pytest
from support.node_lanes import NodeLanes
from support.scenes import rgba, shader

from pt_engine.bsdfs import principled as model
from pt_engine.nodes.compile import compile_materials
from pt_engine.nodes.coverage import APPROXIMATE
from pt_engine.nodes.world import compile_light, compile_world
from pt_engine.scene.snapshot import Graph, Link, Node

SINGLE = {"distribution": "GGX"}


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
        (shader("PtRoughPlastic"), ("specular", "diffuse"), False),
        (shader("BsdfPrincipled"), ("specular", "diffuse"), False),
        (shader("BsdfPrincipled", Metallic=1.0), ("conductor",), False),
        (shader("BsdfPrincipled", Metallic=1.0, Roughness=0.0), ("conductor",), True),
        (shader("BsdfPrincipled", Transmission_Weight=1.0, Roughness=0.0), ("dielectric",), True),
        (shader("BsdfPrincipled", Coat_Weight=0.5), ("specular", "specular", "diffuse"), False),
        (shader("BsdfPrincipled", IOR=1.0), ("diffuse",), False),
        (shader("BsdfPrincipled", Alpha=0.0), ("transparent",), True),
        (shader("BsdfPrincipled", Alpha=0.4, Metallic=1.0), ("transparent", "conductor"), False),
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


def test_principled_layers_leave_what_they_do_not_reflect():
    """At normal incidence the gloss of index 1.5 reflects 4 %, so the diffuse below gets 96 %."""
    _, (gloss, diffuse) = closures(shader("BsdfPrincipled", Base_Color=rgba(0.5), Roughness=0.0))
    np.testing.assert_allclose(gloss.weight, 1)
    np.testing.assert_allclose(diffuse.weight, 0.5 * 0.96, rtol=1e-3)


def test_principled_metal_takes_its_share():
    _, made = closures(shader("BsdfPrincipled", props=SINGLE, Metallic=0.25, IOR=1.0, Base_Color=rgba(0.8)))
    np.testing.assert_allclose(made[0].weight, 0.25)
    np.testing.assert_allclose(made[1].weight, 0.75 * 0.8, rtol=1e-6)


def test_principled_emission_is_dimmed_by_alpha():
    graph = shader("BsdfPrincipled", Alpha=0.5, Emission_Color=rgba((1, 2, 3)), Emission_Strength=2.0)
    compiled = compile_materials([graph])
    np.testing.assert_allclose(compiled.emission_constant[0], [1, 2, 3])
    batch = compiled.batches[0]
    np.testing.assert_allclose(batch.transparency(NodeLanes(n=2)), 0.5)


@pytest.mark.parametrize("kind", ["SubsurfaceScattering", "BsdfToon", "BsdfHair", "BsdfSheen", "Holdout"])
def test_stand_ins_are_listed(kind):
    compiled = compile_materials([shader(kind)])
    assert compiled.coverage[0].state == APPROXIMATE
    assert compiled.coverage[0].effect


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
    factor, coverage = compile_light(shader("Emission", Color=rgba((1, 0.5, 0)), Strength=3.0))
    np.testing.assert_allclose(factor, [3, 1.5, 0])
    assert [entry.state for entry in coverage] == ["exact"]
    assert compile_light(None)[0].tolist() == [1, 1, 1]


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("distribution", ["GGX", "MULTI_GGX"])
def test_principled_is_the_model_of_bsdfs(seed, distribution):
    """The graph's closures, folded and gathered, weigh what `bsdfs.principled` says for the same numbers."""
    rng = np.random.default_rng(seed)
    given = {
        "base_color": rng.uniform(0, 1, 3),
        "metallic": rng.choice([0.0, 0.3, 1.0]),
        "roughness": rng.uniform(0.05, 1),
        "ior": rng.choice([1.2, 1.5, 2.0]),
        "subsurface_weight": rng.choice([0.0, 0.4]),
        "specular_ior_level": rng.choice([0.5, 0.2, 0.9]),
        "specular_tint": rng.choice([1.0, 0.6]) * np.ones(3),
        "transmission_weight": rng.choice([0.0, 0.5]),
        "coat_weight": rng.choice([0.0, 0.7]),
        "coat_roughness": 0.2,
        "coat_tint": rng.uniform(0.5, 1, 3),
    }
    sockets = {k: rgba(v) if np.ndim(v) else float(v) for k, v in given.items()}
    names = {"ior": "IOR", "specular_ior_level": "Specular IOR Level"}
    node = Node(
        "BsdfPrincipled",
        "p",
        {names.get(k, k.replace("_", " ").title()): v for k, v in sockets.items()},
        {"distribution": distribution},
    )
    wi = rng.normal(size=(3, 50)).astype(np.float32)
    wi[2] = np.abs(wi[2]) + 0.05
    wi /= np.sqrt((wi * wi).sum(axis=0))
    compiled = compile_materials([Graph("m", (node,), {"Surface": Link(0, "BSDF")})])
    made = compiled.batches[0].closures(NodeLanes(n=50, wi=wi))
    expected = model.layers(
        model.inputs(**given), wi[2], wi[2], np.zeros(1, np.float32), None, distribution == "MULTI_GGX"
    ).closures
    ours = sum(c.weight for c in made if c.bsdf.__name__.endswith("diffuse"))
    theirs = sum(c.weight for c in expected if c.bsdf.__name__.endswith("diffuse"))
    np.testing.assert_allclose(ours + np.zeros((3, 50)), theirs + np.zeros((3, 50)), rtol=2e-4, atol=1e-6)
    ours = [c for c in made if not c.bsdf.__name__.endswith("diffuse")]
    theirs = [c for c in expected if not c.bsdf.__name__.endswith("diffuse")]
    assert [c.bsdf for c in ours] == [c.bsdf for c in theirs]
    for a, b in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(
            a.weight + np.zeros((3, 50)), b.weight + np.zeros((3, 50)), rtol=2e-4, atol=1e-6
        )
        for x, y in zip(a.params, b.params, strict=True):
            if x is not None and y is not None:
                np.testing.assert_allclose(x + 0 * y, y + 0 * x, rtol=1e-5)
