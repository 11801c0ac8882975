"""Textures behind masks are computed where these let something through, and nothing else changes."""

import numpy as np
import pytest
from support.node_lanes import NodeLanes
from support.scenes import rgba

from pt_engine.nodes import gates, noise
from pt_engine.nodes.compile import compile_materials
from pt_engine.nodes.gates import Gates
from pt_engine.scene.snapshot import Graph, Link, Node

N = 400


def masked(mask: Link, *before: Node) -> Graph:
    """Grey diffuse where a mask is 0, diffuse coloured by a noise bent by another where it is 1."""
    first = len(before)
    nodes = (
        *before,
        Node("TexNoise", "within", {"Vector": Link(0, "Color")}),
        Node("TexNoise", "noise", {"Vector": Link(first, "Color")}),
        Node("BsdfDiffuse", "plain", {"Color": rgba(0.5), "Roughness": 0.0}),
        Node("BsdfDiffuse", "textured", {"Color": Link(first + 1, "Color"), "Roughness": 0.7}),
        Node(
            "MixShader",
            "mix",
            {"Fac": mask, "Shader": Link(first + 2, "BSDF"), "Shader_001": Link(first + 3, "BSDF")},
        ),
    )
    return Graph("masked", nodes, {"Surface": Link(len(nodes) - 1, "Shader")})


def attributes() -> tuple[Node, Node]:
    return (
        Node("VertexColor", "points", {}, {"layer_name": "points"}),
        Node("VertexColor", "mask", {}, {"layer_name": "mask"}),
    )


def lanes(mask, size=N):
    points = np.random.default_rng(0).random((3, N), np.float32)[:, :size] * 10
    return NodeLanes(colors={"points": points, "mask": np.broadcast_to(np.float32(mask), (3, N))[:, :size]})


@pytest.fixture
def sizes(monkeypatch):
    """Lanes of each fractal that is computed, channels together."""
    seen, own = [], noise.FRACTALS["FBM"]

    def counted(point, *settings):
        seen.append(max(p.shape[-1] for p in point))
        return own(point, *settings)

    monkeypatch.setitem(noise.FRACTALS, "FBM", counted)
    return seen


@pytest.mark.parametrize("share", [0, 0.01, 0.5, 1])
def test_a_texture_is_computed_where_its_closure_has_weight(sizes, share):
    mask = np.random.default_rng(1).random(N) < share
    batch = compile_materials([masked(Link(1, "Color"), *attributes())]).batches[0]
    plain, textured = batch.closures(lanes(mask))
    assert sum(sizes) == 2 * 3 * np.count_nonzero(mask)
    whole = batch.closures(lanes(np.ones(N)))[-1]
    np.testing.assert_array_equal(textured.weight, whole.weight * mask)
    np.testing.assert_array_equal(np.broadcast_to(plain.weight, (3, N)), 0.5 * np.broadcast_to(~mask, (3, N)))


def test_a_lane_alone_is_the_lane_among_others():
    """Whether others are open or not: closed lanes have values of their own, too."""
    mask = np.arange(N) % 3 == 0
    batch = compile_materials([masked(Link(1, "Color"), *attributes())]).batches[0]
    together = batch.closures(lanes(mask))
    for k in (0, 1):
        alone = batch.closures(lanes(mask, size=k + 1))
        for a, b in zip(together, alone, strict=True):
            for x, y in zip((a.weight, *a.params), (b.weight, *b.params), strict=True):
                np.testing.assert_array_equal(x[..., min(k, x.shape[-1] - 1)], y[..., -1])


def test_a_mask_made_of_the_texture_it_hides_is_no_gate(sizes):
    """The first noise decides where the second is wanted; its own Factor is wanted everywhere."""
    factor = Node("Math", "step", {"Value": Link(3, "Fac"), "Value_001": 0.5}, {"operation": "GREATER_THAN"})
    graph = masked(Link(2, "Value"), *attributes(), factor)
    batch = compile_materials([graph]).batches[0]
    _, textured = batch.closures(lanes(np.ones(N)))
    open_lanes = np.count_nonzero(textured.weight.any(axis=0))
    assert 0 < open_lanes < N
    assert sum(sizes) == N + 2 * open_lanes + 3 * open_lanes


def test_colors_in_parts_are_the_colors(monkeypatch):
    """Factor read without a mask and Color behind one: the same numbers as from all at once."""
    factor = Node("Math", "step", {"Value": Link(3, "Fac"), "Value_001": 0.5}, {"operation": "GREATER_THAN"})
    graph = masked(Link(2, "Value"), *attributes(), factor)
    parts = compile_materials([graph]).batches[0].closures(lanes(np.ones(N)))
    monkeypatch.setattr(gates, "firsts_apart", lambda *_: {})
    wholes = compile_materials([graph]).batches[0].closures(lanes(np.ones(N)))
    for part, whole in zip(parts, wholes, strict=True):
        for a, b in zip((part.weight, *part.params), (whole.weight, *whole.params), strict=True):
            np.testing.assert_array_equal(a, b)


def test_gates_that_wait_for_each_other_are_not_made():
    """An order exists whatever is chosen: every step comes after all that it reads."""
    compiled = compile_materials([masked(Link(1, "Color"), *attributes())])
    steps = compiled.batches[0].closure_entry.steps
    known = set()
    for step in steps:
        assert {s.number for s in step.args if not s.constant} <= known
        known |= {step.first + k for k in range(len(step.op.types))}
    assert Gates(steps, []).order() == list(range(len(steps)))
