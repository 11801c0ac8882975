"""The Principled as it renders: which closures it becomes, what they weigh, what they add up to."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.bsdf_checks import direction, f32
from support.closures import closure_albedo, compiled_closures, furnace_albedo, name_of
from support.node_lanes import NodeLanes
from support.scenes import rgba

from pt_engine.nodes.compile import compile_materials
from pt_engine.nodes.coverage import APPROXIMATE, EXACT
from pt_engine.scene.snapshot import Graph, Link, Node

SINGLE = {"distribution": "GGX"}
WHITE = (1.0, 1.0, 1.0)
UP = direction(1.0)


def principled(props: dict[str, Any] | None = None, **sockets: Any) -> Graph:
    """The node alone; `ior_level` is named as in Blender, underscores stand for spaces, colours for RGBA.

    A socket given as ``"A.color"`` or ``"A.alpha"`` is linked to the colour attribute A.
    """
    inputs: dict[str, Any] = {}
    for name, value in sockets.items():
        key = name.replace("_", " ").title().replace("Ior", "IOR")
        if value in ("A.color", "A.alpha"):
            value = Link(0, value[2:].title())
        inputs[key] = rgba(value) if isinstance(value, tuple) and not isinstance(value, Link) else value
    attribute = Node("VertexColor", "attribute", {}, {"layer_name": "A"})
    node = Node("BsdfPrincipled", "principled", inputs, props or {})
    return Graph("test", (attribute, node), {"Surface": Link(1, "BSDF")})


def models(**sockets: Any) -> list[str]:
    lanes = {"colors": {"A": np.full((3, 1), 0.3, np.float32)}}
    return [name_of(c) for c in compiled_closures(principled(**sockets), direction(0.5), **lanes)]


def coverage(**sockets: Any) -> tuple[str, str]:
    """State and effect of the node."""
    (entry,) = (e for e in compile_materials([principled(**sockets)]).coverage if e.node == "principled")
    return entry.state, entry.effect


# ------------------------------------------------------------------------- which closures there are


@pytest.mark.parametrize(
    ("sockets", "expected"),
    [
        ({}, ["specular", "diffuse"]),
        ({"metallic": 1.0}, ["conductor"]),
        ({"transmission_weight": 1.0}, ["dielectric"]),
        ({"ior": 1.0}, ["diffuse"]),
        ({"ior": 1.0, "specular_ior_level": "A.alpha"}, ["diffuse"]),
        ({"specular_ior_level": 0.0}, ["diffuse"]),
        ({"specular_ior_level": -1.0, "ior": "A.alpha"}, ["diffuse"]),
        ({"specular_ior_level": 0.0, "thin_film_thickness": 300.0}, ["specular", "diffuse"]),
        ({"specular_ior_level": 0.0, "ior": "A.alpha"}, ["diffuse"]),
        ({"base_color": (0.0, 0.0, 0.0)}, ["specular"]),
        ({"coat_weight": 0.5}, ["specular", "specular", "diffuse"]),
        ({"coat_weight": 0.5, "metallic": 0.5}, ["specular", "conductor", "specular", "diffuse"]),
        ({"sheen_weight": 0.3}, ["sheen", "specular", "diffuse"]),
        ({"sheen_weight": "A.alpha", "metallic": 1.0}, ["sheen", "conductor"]),
        ({"diffuse_roughness": 0.5}, ["specular", "oren_nayar"]),
        ({"subsurface_weight": 0.5}, ["specular", "diffuse"]),
        ({"diffuse_roughness": 0.5, "subsurface_weight": 0.5}, ["specular", "diffuse", "oren_nayar"]),
        ({"metallic": "A.alpha"}, ["conductor", "specular", "diffuse"]),
        ({"alpha": 0.0}, ["transparent"]),
        ({"alpha": 0.4, "metallic": 1.0}, ["transparent", "conductor"]),
    ],
)
def test_closures_exist_only_if_no_constant_rules_them_out(
    sockets: dict[str, Any], expected: list[str]
) -> None:
    assert models(**sockets) == expected


@pytest.mark.parametrize(
    ("sockets", "dirac"),
    [
        ({"metallic": 1.0, "roughness": 0.0}, True),
        ({"transmission_weight": 1.0, "roughness": 0.0}, True),
        ({"alpha": 0.0}, True),
        ({"roughness": 0.0}, False),
    ],
)
def test_only_smooth_metal_and_glass_are_nothing_but_dirac(sockets: dict[str, Any], dirac: bool) -> None:
    assert compile_materials([principled(**sockets)]).batches[0].delta_only == dirac


# ------------------------------------------------------------------------- what they weigh


def test_layers_leave_what_they_do_not_reflect() -> None:
    """At normal incidence the gloss of index 1.5 reflects 4 %, so the diffuse below gets 96 %."""
    gloss, diffuse = compiled_closures(principled(base_color=(0.5, 0.5, 0.5), roughness=0.0), UP)
    np.testing.assert_allclose(gloss.weight, 1)
    np.testing.assert_allclose(diffuse.weight, 0.5 * 0.96, rtol=1e-3)


def test_metal_takes_its_share() -> None:
    metal, diffuse = compiled_closures(
        principled(SINGLE, metallic=0.25, ior=1.0, base_color=(0.8, 0.8, 0.8)), UP
    )
    np.testing.assert_allclose(metal.weight, 0.25)
    np.testing.assert_allclose(diffuse.weight, 0.75 * 0.8, rtol=1e-6)


@pytest.mark.parametrize("level", [0.2, 0.5, 1.0])
@pytest.mark.parametrize("ior", [0.7, 1.5, 3.0])
def test_specular_level_scales_the_reflectance_at_normal_incidence(ior: float, level: float) -> None:
    """F0 = 2·level·((ior − 1)/(ior + 1))², on the same side of 1 as the ior; to float32's rounding."""
    gloss, _ = compiled_closures(principled(ior=ior, specular_ior_level=level), UP)
    eta = gloss.params.eta.astype(np.float64)
    np.testing.assert_allclose(
        ((eta - 1) / (eta + 1)) ** 2, 2 * level * ((ior - 1) / (ior + 1)) ** 2, rtol=1e-5
    )
    assert (eta > 1) == (ior > 1)


def test_specular_level_ends_at_a_reflectance_of_99_per_cent() -> None:
    """As in Cycles: η = (1 + √0.99)/(1 − √0.99)."""
    gloss, _ = compiled_closures(principled(ior=50.0, specular_ior_level=1.0), UP)
    np.testing.assert_allclose(gloss.params.eta, (1 + 0.99**0.5) / (1 - 0.99**0.5), rtol=1e-4)


def test_a_tint_beyond_that_limit_dims_what_the_level_asked_for() -> None:
    """F0 = min(2·level·F0(ior)·tint, 1), as in Cycles: 2·0.92311·(0.5, 0.2, 1)."""
    graph = principled(ior=50.0, specular_ior_level=1.0, specular_tint=(0.5, 0.2, 1.0))
    gloss, _ = compiled_closures(graph, UP)
    f0 = ((gloss.params.eta - 1) / (gloss.params.eta + 1)) ** 2 * gloss.params.tint[:, 0]
    np.testing.assert_allclose(np.minimum(f0, 1), [0.92311, 0.36924, 1.0], rtol=1e-4)


def test_a_film_too_thin_costs_nothing() -> None:
    """A constant thickness of at most 0.1 nm leaves no parameter; a linked one always does."""
    for thickness, there in ((0.1, False), (0.11, True), ("A.alpha", True)):
        graph = principled(thin_film_thickness=thickness, metallic=0.5, transmission_weight=0.5)
        closures = compiled_closures(graph, UP, colors={"A": np.ones((3, 1), np.float32)})
        assert [c.params.film_thickness is not None for c in closures[:3]] == [there] * 3


def test_subsurface_takes_its_share_of_the_diffuse() -> None:
    """In its diffuse limit: a colour in [0, 1] looks the same, one above is cut off in that share."""
    base = {"ior": 1.0, "base_color": (0.5, 1.0, 3.0)}
    (half,) = compiled_closures(principled(subsurface_weight=0.5, **base), UP)
    np.testing.assert_allclose(half.weight[:, 0], [0.5, 1.0, 2.0], rtol=1e-6)


def test_emission_is_dimmed_by_alpha() -> None:
    compiled = compile_materials(
        [principled(alpha=0.5, emission_color=(1.0, 2.0, 3.0), emission_strength=2.0)]
    )
    np.testing.assert_allclose(compiled.emission_constant[0], [1, 2, 3])
    np.testing.assert_allclose(compiled.batches[0].transparency(NodeLanes(n=2)), 0.5)


def test_coat_dims_emission_and_colours_it() -> None:
    """At normal incidence a coat of index 1.5 takes 4 % and its tint what it says."""
    graph = principled(
        coat_weight=1.0, coat_roughness=0.0, coat_tint=(1.0, 0.5, 0.25), emission_color=WHITE,
        emission_strength=1.0,
    )  # fmt: skip
    emitted = compile_materials([graph]).batches[0].emission(NodeLanes(n=1))
    assert emitted is not None
    np.testing.assert_allclose(emitted[:, 0], np.array([1.0, 0.5, 0.25]) * 0.96, atol=2e-3)


def test_sheen_dims_what_is_below_by_its_brightest_channel() -> None:
    """1 − w·max(tint)·R of the emission is left, R being the fibres' albedo."""
    graph = principled(
        sheen_weight=0.8, sheen_roughness=0.7, sheen_tint=(0.2, 1.0, 0.5), emission_color=WHITE,
        emission_strength=1.0,
    )  # fmt: skip
    wi = direction(0.3)
    emitted = compile_materials([graph]).batches[0].emission(NodeLanes(n=1, wi=wi))
    fibres = compiled_closures(graph, wi)[0]
    albedo = fibres.bsdf.albedo(fibres.params, wi[2])
    np.testing.assert_allclose(fibres.weight[:, 0], [0.16, 0.8, 0.4], rtol=1e-6)
    assert emitted is not None
    np.testing.assert_allclose(emitted, np.full((3, 1), 1 - 0.8 * albedo), rtol=1e-6)


def test_sheen_stands_on_the_coat_as_far_as_there_is_one() -> None:
    """With a coat of weight 1 its normal is the coat's, of half that the one halfway between."""
    tilted = Node("CombineXYZ", "tilted", {"X": 0.6, "Y": 0.0, "Z": 0.8})
    for coat, expected in ((0.0, [0, 0, 1]), (1.0, [0.6, 0, 0.8]), (0.5, [0.3162278, 0, 0.9486833])):
        inputs = {"Sheen Weight": 1.0, "Coat Weight": coat, "Coat Normal": Link(0, "Vector")}
        graph = Graph("test", (tilted, Node("BsdfPrincipled", "p", inputs, {})), {"Surface": Link(1, "BSDF")})
        fibres = compiled_closures(graph, direction(0.5))[0]
        normal = [0, 0, 1] if fibres.normal is None else fibres.normal[:, 0]
        np.testing.assert_allclose(normal, expected, atol=1e-6)


def test_black_glass_gains_what_its_gloss_would() -> None:
    """Light between facets has the colour of what passes; of black glass, that of what is reflected."""
    rough = {"transmission_weight": 1.0, "roughness": 1.0}
    (black,) = compiled_closures(principled(base_color=(0.0, 0.0, 0.0), **rough), UP)
    (dark,) = compiled_closures(principled(base_color=(1e-12, 0.0, 0.0), **rough), UP)
    assert (black.weight > 1).all()
    np.testing.assert_allclose(dark.weight, 1, rtol=1e-5)


def test_glass_is_entered_and_left() -> None:
    """From behind the index is inverted; the colour is halved between the two faces."""
    behind = np.array([0, 1], np.float32)
    graph = principled(transmission_weight=1.0, ior=1.5, base_color=(0.25, 1.0, 1.0))
    (glass,) = compiled_closures(graph, np.repeat(direction(0.5), 2, axis=1), backfacing=behind)
    np.testing.assert_allclose(glass.params.eta, [1.5, 1 / 1.5], rtol=1e-6)
    assert glass.params.transmission_tint[0, 0] == pytest.approx(0.5)


def test_linked_inputs_weigh_as_constants_do() -> None:
    """Folded at compile time or computed per lane, the same numbers give the same bits."""
    fixed = {"ior": 1.4, "coat_weight": 0.6, "coat_tint": (0.8, 0.9, 1.0), "transmission_weight": 0.2}
    color = (0.25, 0.5, 0.75)
    wi = np.concatenate([direction(c) for c in np.linspace(0.1, 1, 5)], axis=1)
    linked = principled(base_color="A.color", metallic=0.3, **fixed)
    attribute = np.repeat(f32(*color), 5, axis=1)
    ours = compiled_closures(linked, wi, colors={"A": attribute})
    folded = compiled_closures(principled(base_color=color, metallic=0.3, **fixed), wi)
    for a, b in zip(ours, folded, strict=True):
        assert a.weight.dtype == b.weight.dtype == np.float32
        np.testing.assert_array_equal(np.broadcast_to(a.weight, (3, 5)), np.broadcast_to(b.weight, (3, 5)))


def test_materials_of_other_numbers_share_a_batch() -> None:
    """Constants that differ are gathered: each lane weighs what its material alone would."""
    graphs = [principled(metallic=m, roughness=0.3 + m) for m in (0.2, 0.5)]
    wi = np.repeat(direction(0.6), 2, axis=1)
    compiled = compile_materials(graphs)
    assert len(compiled.batches) == 1
    lanes = NodeLanes(n=2, wi=wi)
    lanes.material = np.array([1, 0], np.int32)
    shared = compiled.batches[0].closures(lanes)
    for column, graph in enumerate(graphs[::-1]):
        for a, b in zip(shared, compiled_closures(graph, direction(0.6)), strict=True):
            np.testing.assert_array_equal(np.broadcast_to(a.weight, (3, 2))[:, column], b.weight[:, 0])


# ------------------------------------------------------------------------- what they add up to


def reflectance(graph: Graph, cos: float) -> np.ndarray:
    """As `furnace_albedo`, but Oren-Nayar, which peaks at grazing, counts as its bound of 1 per weight."""
    wi, total = direction(cos, 0.3), np.zeros(3)
    for closure in compiled_closures(graph, wi):
        bound = np.ones(1) if name_of(closure) == "oren_nayar" else closure_albedo(closure, wi, 48)
        total += closure.weight.mean(axis=-1) * bound
    return total


@settings(max_examples=40, deadline=None)
@given(
    st.floats(0, 1), st.floats(0, 1), st.floats(1, 2.5), st.floats(0, 1), st.floats(0, 1),
    st.floats(0, 1), st.floats(0, 1), st.floats(0.1, 1), st.floats(0, 1), st.floats(0, 1), st.floats(0, 1),
)  # fmt: skip
def test_energy_is_conserved(
    metallic: float,
    roughness: float,
    ior: float,
    level: float,
    transmission: float,
    coat: float,
    coat_roughness: float,
    cos: float,
    subsurface: float,
    diffuse_roughness: float,
    sheen: float,
) -> None:
    """A white surface of any make reflects at most all. 3 %: the tables' interpolation, and layers take
    albedos at the viewer's side alone, as Cycles does."""
    graph = principled(
        base_color=WHITE, metallic=metallic, roughness=roughness, ior=ior, specular_ior_level=level,
        transmission_weight=transmission, coat_weight=coat, coat_roughness=coat_roughness,
        subsurface_weight=subsurface, diffuse_roughness=diffuse_roughness, sheen_weight=sheen,
    )  # fmt: skip
    assert reflectance(graph, cos).max() <= 1.03


@pytest.mark.parametrize("roughness", [0.0, 0.3, 0.7, 1.0])
@pytest.mark.parametrize("cos", [0.2, 0.6, 1.0])
@pytest.mark.parametrize(
    "sockets", [{}, {"metallic": 1.0}, {"transmission_weight": 1.0}, {"coat_weight": 1.0}]
)
def test_white_surface_keeps_its_light(roughness: float, cos: float, sockets: dict[str, float]) -> None:
    """White plastic, metal, glass and coated plastic lose nothing: within 3 % (see above)."""
    graph = principled(base_color=WHITE, roughness=roughness, **sockets)
    np.testing.assert_allclose(furnace_albedo(graph, direction(cos, 0.3), rows=48), 1.0, atol=0.03)


ENDS = {
    "metallic": (0.0, 0.5, 1.0), "roughness": (0.0, 0.3, 1.0), "ior": (1.0, 1.5, 4.0),
    "diffuse_roughness": (0.0, 1.0), "subsurface_weight": (0.0, 1.0),
    "subsurface_anisotropy": (-1.0, 0.0, 1.0), "specular_ior_level": (0.0, 0.5, 1.0),
    "anisotropic": (0.0, 1.0), "anisotropic_rotation": (0.0, 0.3), "transmission_weight": (0.0, 0.5, 1.0),
    "coat_weight": (0.0, 0.5, 1.0), "coat_roughness": (0.0, 0.5, 1.0), "coat_ior": (1.0, 1.5, 4.0),
    "alpha": (0.0, 0.5, 1.0), "thin_wall": (False, True),
    "thin_film_thickness": (0.0, 1.0, 300.0, 1e4), "thin_film_ior": (1.0, 1.33, 3.0),
}  # fmt: skip


@pytest.mark.parametrize("film", [False, True], ids=["bare", "film"])
def test_energy_is_conserved_at_every_corner(film: bool) -> None:
    """Each input at the ends and the middle of its range, 150 draws of all of them, white.

    1 %: the tables' interpolation. 5 % with a film: layers below a rough gloss then take its albedo for that
    of a mirror, as in Cycles.
    """
    rng = np.random.default_rng(4)
    for _ in range(150):
        drawn = {name: values[rng.integers(len(values))] for name, values in ENDS.items()}
        if not film:
            drawn["thin_film_thickness"] = 0.0
        total = reflectance(principled(base_color=WHITE, **drawn), float(rng.choice([0.1, 0.4, 1.0])))
        assert total.max() <= (1.05 if film else 1.01), drawn


# ------------------------------------------------------------------------- what is said about it


@pytest.mark.parametrize(
    ("sockets", "effect"),
    [
        ({"subsurface_weight": 0.5}, "subsurface light leaves where it enters"),
    ],
)
def test_what_is_not_rendered_is_listed(sockets: dict[str, Any], effect: str) -> None:
    assert coverage(**sockets) == (APPROXIMATE, effect)


@pytest.mark.parametrize(
    "sockets",
    [
        {},
        {"sheen_weight": 0.0, "sheen_roughness": 0.5, "subsurface_radius": (1.0, 0.2, 0.1)},
        {"thin_film_thickness": 0.05},
        {"subsurface_weight": 1.0, "metallic": 1.0},
        {"thin_wall": True},
        {"coat_weight": 1.0, "alpha": 0.5, "anisotropic": 0.5, "emission_strength": 1.0, "sheen_weight": 1.0},
    ],
)
def test_what_has_no_effect_is_not_listed(sockets: dict[str, Any]) -> None:
    assert coverage(**sockets) == (EXACT, "")
