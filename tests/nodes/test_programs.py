"""What the compiler does to graphs: folding, sharing, dropping, batching, and truthful coverage."""

import numpy as np
import pytest
from support.node_lanes import NodeLanes
from support.scenes import rgba, shader

from pt_engine.nodes.compile import compile_materials
from pt_engine.nodes.coverage import APPROXIMATE, EXACT, IGNORED
from pt_engine.scene.snapshot import Graph, Link, Node


def graph(*nodes, socket="Emission", name="test"):
    """A material whose surface is the last node."""
    return Graph(name, nodes, {"Surface": Link(len(nodes) - 1, socket)})


def shining(*nodes, socket, strength=1.0):
    """A material that shines with an output of the last node."""
    lamp = Node("Emission", "lamp", {"Color": Link(len(nodes) - 1, socket), "Strength": strength})
    return graph(*nodes, lamp)


def math(operation, a, b=0.0, c=0.0):
    return Node("Math", operation, {"Value": a, "Value_001": b, "Value_002": c}, {"operation": operation})


def attribute(name="A"):
    return Node("VertexColor", name, {}, {"layer_name": name})


def steps(compiled, material=0):
    """Names of what the material's emission does at run time."""
    entry = compiled.batches[compiled.batch_of[material]].emission_entry
    return [] if entry is None else [s.op.name for s in entry.steps]


def emitted(compiled, material=0, **lanes):
    batch = compiled.batches[compiled.batch_of[material]]
    return batch.emission(NodeLanes(material=material, **lanes))


def test_constants_fold_to_a_constant_radiance():
    compiled = compile_materials(
        [shining(math("ADD", 2.0, 3.0), math("MULTIPLY", Link(0, "Value"), 0.5), socket="Value")]
    )
    assert steps(compiled) == []
    assert not compiled.emission_varies[0]
    np.testing.assert_allclose(compiled.emission_constant[0], 2.5)


def test_common_subexpressions_are_computed_once():
    twice = [attribute(), math("SINE", Link(0, "Alpha")), math("SINE", Link(0, "Alpha"))]
    compiled = compile_materials(
        [shining(*twice, math("ADD", Link(1, "Value"), Link(2, "Value")), socket="Value")]
    )
    assert steps(compiled).count("math") == 2  # one sine, one addition


def test_what_a_constant_factor_hides_is_not_reachable():
    hidden = Node("NoSuchNode", "mystery", {})
    mix = Node(
        "Mix",
        "mix",
        {"Factor_Float": 0.0, "A_Color": rgba(0.25), "B_Color": Link(0, "Color")},
        {"data_type": "RGBA"},
    )
    compiled = compile_materials([shining(hidden, mix, socket="Result_Color")])
    assert [entry.node for entry in compiled.coverage] == ["mix", "lamp"]
    np.testing.assert_allclose(compiled.emission_constant[0], 0.25)


@pytest.mark.parametrize(("factor", "kinds"), [(0.0, ("diffuse",)), (1.0, ("transparent",)), (0.5, None)])
def test_closures_of_weight_zero_do_not_exist(factor, kinds):
    nodes = (
        Node("BsdfDiffuse", "diffuse", {"Color": rgba(0.5)}),
        Node("BsdfTransparent", "clear", {"Color": rgba(1.0)}),
        Node("MixShader", "mix", {"Fac": factor, "Shader": Link(0, "BSDF"), "Shader_001": Link(1, "BSDF")}),
    )
    compiled = compile_materials([graph(*nodes, socket="Shader")])
    assert set(compiled.batches[0].kinds) == set(kinds or ("diffuse", "transparent"))
    assert compiled.batches[0].has_transparency == (factor > 0)


def test_weights_multiply_through_mixes_of_any_depth():
    nodes = (
        Node("Emission", "a", {"Color": rgba((1, 0, 0)), "Strength": 2.0}),
        Node("Emission", "b", {"Color": rgba((0, 1, 0)), "Strength": 3.0}),
        Node(
            "MixShader", "m", {"Fac": 0.25, "Shader": Link(0, "Emission"), "Shader_001": Link(1, "Emission")}
        ),
        Node("AddShader", "s", {"Shader": Link(2, "Shader"), "Shader_001": Link(0, "Emission")}),
        Node("MixShader", "n", {"Fac": 0.5, "Shader": Link(3, "Shader"), "Shader_001": None}),
    )
    compiled = compile_materials([graph(*nodes, socket="Shader")])
    # ½·(0.75·2 + 2, 0.25·3, 0)
    np.testing.assert_allclose(compiled.emission_constant[0], [1.75, 0.375, 0])


def test_three_hundred_materials_share_a_batch():
    rng = np.random.default_rng(0)
    albedos = rng.uniform(0.01, 0.99, (300, 3))
    compiled = compile_materials([shader("BsdfDiffuse", Color=rgba(a)) for a in albedos])
    assert len(compiled.batches) == 1
    lanes = NodeLanes(n=300)
    lanes.material = np.arange(300, dtype=np.int32)[::-1].copy()
    (closure,) = compiled.batches[0].closures(lanes)
    np.testing.assert_allclose(closure.weight.T, albedos[::-1], rtol=1e-6)


def test_materials_that_differ_in_what_they_emit_share_a_batch():
    """A lamp is a surface like others; a batch in which nothing emits has no program for it."""
    glows = [Node("BsdfPrincipled", "p", {"Emission Strength": power}) for power in (0.0, 2.0, 3.0)]
    compiled = compile_materials([graph(glow, socket="BSDF") for glow in glows])
    assert len(compiled.batches) == 1
    assert not compiled.emission_varies.any()
    np.testing.assert_allclose(compiled.emission_constant, [[0] * 3, [2] * 3, [3] * 3])
    dark = compile_materials([graph(glows[0], socket="BSDF")]).batches[0]
    assert not dark.has_emission
    assert dark.emission_entry is None


def test_one_material_does_nothing_at_run_time():
    compiled = compile_materials([shader("BsdfDiffuse", Color=rgba(0.5))])
    lanes = NodeLanes(n=10)
    first, second = (compiled.batches[0].closures(lanes) for _ in range(2))
    assert first is second
    assert first[0].weight.shape == (3, 1)


def test_only_constants_that_differ_are_gathered():
    graphs = [
        shining(attribute(), math("MULTIPLY_ADD", Link(0, "Alpha"), 2.0, k), socket="Value")
        for k in (0.5, 0.7)
    ]
    compiled = compile_materials(graphs)
    assert len(compiled.batches) == 1
    assert len(compiled.batches[0].table.varying) == 1
    colors = {"A": np.zeros((3, 4), np.float32)}
    np.testing.assert_allclose(emitted(compiled, 0, colors=colors), 2.5)
    np.testing.assert_allclose(emitted(compiled, 1, colors=colors), 2.7)


def test_different_images_or_settings_are_different_programs():
    sine, cosine = (
        shining(attribute(), math(k, Link(0, "Alpha")), socket="Value") for k in ("SINE", "COSINE")
    )
    assert len(compile_materials([sine, cosine, sine]).batches) == 2


def test_result_does_not_depend_on_batch_size():
    noise = Node("TexNoise", "noise", {"Vector": Link(0, "Color"), "Detail": Link(0, "Alpha"), "Scale": 3.0})
    compiled = compile_materials([shining(attribute(), noise, socket="Fac")])
    points = np.random.default_rng(3).uniform(-5, 5, (3, 20000)).astype(np.float32)
    whole = emitted(compiled, colors={"A": points})
    part = emitted(compiled, colors={"A": points[:, 9000:9100]})
    np.testing.assert_array_equal(whole[:, 9000:9100], part)


def test_an_unknown_node_gives_the_sockets_default_and_is_listed():
    unknown = Node("FancyNoise", "fancy", {})
    compiled = compile_materials([shining(unknown, math("ADD", Link(0, "Out"), 1.0), socket="Value")])
    np.testing.assert_allclose(compiled.emission_constant[0], 1.5)
    states = {entry.node: entry.state for entry in compiled.coverage}
    assert states == {"fancy": IGNORED, "ADD": EXACT, "lamp": EXACT}


def test_an_unknown_shader_is_black_and_listed():
    compiled = compile_materials([graph(Node("BsdfFancy", "fancy", {}), socket="BSDF")])
    assert not compiled.batches[0].has_bsdf
    assert compiled.coverage[0].state == IGNORED


def test_a_loop_ends_with_a_default():
    nodes = (math("ADD", Link(1, "Value"), 1.0), math("SINE", Link(0, "Value")))
    compiled = compile_materials([shining(*nodes, socket="Value")])
    assert any(entry.state == IGNORED and "cyclic" in entry.effect for entry in compiled.coverage)
    np.testing.assert_allclose(compiled.emission_constant[0], np.sin(1.5), rtol=1e-6)


def test_a_very_long_chain_compiles():
    nodes = [attribute()] + [math("ADD", Link(k, "Alpha" if k == 0 else "Value"), 1.0) for k in range(150)]
    compiled = compile_materials([shining(*nodes, socket="Value")])
    np.testing.assert_allclose(emitted(compiled, colors={"A": np.zeros((3, 2), np.float32)}), 151)


def test_nonfinite_sockets_count_as_zero():
    compiled = compile_materials([shining(math("ADD", float("nan"), 1.0), socket="Value")])
    np.testing.assert_allclose(compiled.emission_constant[0], 1)


def test_a_missing_image_is_magenta_and_listed():
    texture = Node("TexImage", "picture", {"Vector": None}, {"image": 7})
    compiled = compile_materials([shining(texture, socket="Color")])
    np.testing.assert_allclose(compiled.emission_constant[0], [1, 0, 1])
    assert compiled.coverage[0].state == IGNORED


def test_displacement_and_notes_are_listed():
    nodes = (Node("BsdfDiffuse", "d", {}), Node("Displacement", "up", {}))
    outputs = {"Surface": Link(0, "BSDF"), "Displacement": Link(1, "Displacement")}
    material = Graph("m", nodes, outputs, (("elsewhere", "left out"),))
    states = {entry.node: entry.state for entry in compile_materials([material]).coverage}
    assert states == {"d": EXACT, "up": EXACT, "elsewhere": IGNORED}


def test_needs_name_the_attributes():
    texture = Node("TexChecker", "c", {"Vector": Link(0, "UV")})
    compiled = compile_materials(
        [shining(Node("UVMap", "uv", {}, {"uv_map": "second"}), texture, socket="Color")]
    )
    assert compiled.needs == {"uv:second"}


def test_varying_emission_has_a_finite_estimate():
    compiled = compile_materials(
        [
            shining(
                Node("TexCoord", "t", {}), Node("TexChecker", "c", {"Vector": Link(0, "UV")}), socket="Color"
            )
        ]
    )
    assert compiled.emission_varies[0]
    assert np.isfinite(compiled.emission_constant).all()
    assert 0.2 <= compiled.emission_constant[0, 0] <= 0.8


def test_approximations_are_listed():
    compiled = compile_materials(
        [shining(Node("TexSky", "sky", {}, {"sky_type": "TOMORROW"}), socket="Color")]
    )
    assert {entry.node: entry.state for entry in compiled.coverage}["sky"] == APPROXIMATE


@pytest.mark.parametrize("mode", ["MIX", "SCREEN", "MULTIPLY", "DODGE"])
def test_a_blend_of_factor_0_is_its_first_color(mode):
    """As in Cycles, but for blends that clamp: they stay, at full cost."""
    inputs = {"Factor_Float": 0.0, "A_Color": Link(0, "Color"), "B_Color": rgba(0.5)}
    mix = Node("Mix", "mix", inputs, {"data_type": "RGBA", "blend_type": mode})
    compiled = compile_materials([shining(attribute(), mix, socket="Result_Color")])
    assert ("mix_color" in steps(compiled)) == (mode == "DODGE")


@pytest.mark.parametrize(("second", "count"), [({}, 1), ({"Roughness": 0.5}, 2)])
def test_equal_closures_are_one_with_the_sum_of_their_weights(second, count):
    """w₁ f(x) + w₂ f(x) = (w₁ + w₂) f(x): two Lambertian closures are one, two different ones are not."""
    nodes = (
        attribute(),
        Node("BsdfDiffuse", "a", {"Color": Link(0, "Color")}),
        Node("BsdfDiffuse", "b", {"Color": rgba(0.25)} | second),
        Node("AddShader", "sum", {"Shader": Link(1, "BSDF"), "Shader_001": Link(2, "BSDF")}),
    )
    compiled = compile_materials([graph(*nodes, socket="Shader")])
    colors = np.random.default_rng(0).random((3, 5), np.float32)
    closures = compiled.batches[0].closures(NodeLanes(colors={"A": colors}))
    assert len(closures) == count
    total = sum(np.broadcast_to(c.weight, (3, 5)) for c in closures)
    np.testing.assert_allclose(total, colors + np.float32(0.25), rtol=1e-6)


def test_noise_is_computed_once_for_its_color_and_its_factor():
    """The factor is the color's first component: both cost three fractals, not four, of the same values."""
    noise = Node("TexNoise", "noise", {"Vector": Link(0, "Color")})
    alone = Node("Emission", "lamp", {"Color": Link(1, "Color"), "Strength": 1.0})
    both = Node("Emission", "lamp", {"Color": Link(1, "Color"), "Strength": Link(1, "Fac")})
    compiled = compile_materials([graph(attribute(), noise, alone), graph(attribute(), noise, both)])
    assert [name for name in steps(compiled, 1) if "noise" in name] == ["noise_color"]
    points = np.random.default_rng(0).random((3, 50), np.float32) * 10
    color = emitted(compiled, 0, colors={"A": points})
    squared = emitted(compiled, 1, colors={"A": points})
    np.testing.assert_array_equal(squared, np.float32(color[0]) * color)


def test_a_result_that_nothing_reads_costs_nothing():
    """Of Voronoi's four results the distance alone is less work, and the same."""
    cells = Node("TexVoronoi", "cells", {"Vector": Link(0, "Color")})
    compiled = compile_materials(
        [
            graph(
                attribute(),
                cells,
                Node("Emission", "lamp", {"Color": Link(1, "Color"), "Strength": strength}),
            )
            for strength in (1.0, Link(1, "Distance"))
        ]
        + [shining(attribute(), cells, socket="Distance")]
    )
    voronoi = [[name for name in steps(compiled, k) if "voronoi" in name] for k in range(3)]
    assert voronoi == [["voronoi_points"], ["voronoi_points"], ["voronoi_distance"]]
    points = np.random.default_rng(0).random((3, 50), np.float32) * 10
    color, product, distance = (emitted(compiled, k, colors={"A": points}) for k in range(3))
    np.testing.assert_array_equal(product, color * distance)


@pytest.mark.parametrize(("scale", "detail"), [(5.0, 0.0), (5.0, 1.5), (7.0, 0.0)])
def test_the_nearest_and_the_second_nearest_point_are_looked_for_once(scale, detail):
    """F1 and F2 of the same cells are one step; of cells of another size they are two. The same values."""
    link, nodes = {"Vector": Link(0, "Color")}, []
    for feature, size in (("F1", 5.0), ("F2", scale)):
        inputs = link | {"Scale": size, "Detail": detail}
        nodes.append(Node("TexVoronoi", feature, inputs, {"feature": feature, "normalize": True}))
    both = Node("Emission", "lamp", {"Color": Link(1, "Distance"), "Strength": Link(2, "Distance")})
    compiled = compile_materials(
        [graph(attribute(), *nodes, both)] + [shining(attribute(), node, socket="Distance") for node in nodes]
    )
    found = [name for name in steps(compiled) if "voronoi" in name]
    assert found == (["voronoi_distances"] if scale == 5 else ["voronoi_distance"] * 2)
    points = np.random.default_rng(0).random((3, 2000), np.float32) * 10
    product, nearest, second = (emitted(compiled, k, colors={"A": points}) for k in range(3))
    np.testing.assert_array_equal(product, nearest * second)


def test_channels_of_noise_that_nothing_reads_cost_nothing():
    """Red and blue of the noise are taken apart: green's fractal is left out, and they stay as they were."""
    noise = Node("TexNoise", "noise", {"Vector": Link(0, "Color")})
    apart = Node("SeparateColor", "apart", {"Color": Link(1, "Color")})
    joined = Node("CombineColor", "joined", {"Red": Link(2, "Red"), "Blue": Link(2, "Blue")})
    some = shining(attribute(), noise, apart, joined, socket="Color")
    compiled = compile_materials([some, shining(attribute(), noise, socket="Color")])
    assert [[name for name in steps(compiled, k) if "noise" in name] for k in (0, 1)] == [
        ["noise_rb"],
        ["noise_color"],
    ]
    points = np.random.default_rng(0).random((3, 5000), np.float32) * 10
    found, whole = (emitted(compiled, k, colors={"A": points}) for k in (0, 1))
    np.testing.assert_array_equal(found, whole * np.array([[1], [0], [1]], np.float32))
