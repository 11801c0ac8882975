"""Principled's thin walls: their closures, and what a sheet reflects and lets through."""

from __future__ import annotations

import numpy as np
import pytest
from support.bsdf_checks import direction, f32
from support.closures import compiled_closures, furnace_albedo, name_of
from support.node_lanes import NodeLanes
from support.scenes import rgba

from pt_engine.bsdfs import fresnel
from pt_engine.core.raykind import RayKind
from pt_engine.nodes.compile import compile_materials
from pt_engine.nodes.coverage import APPROXIMATE, EXACT
from pt_engine.nodes.thin_walls import is_true, sheet_shares
from pt_engine.scene.snapshot import Graph, Link, Node

WHITE = rgba((1.0, 1.0, 1.0))


def wall(**sockets: object) -> Graph:
    """A Principled that is a thin wall; underscores stand for spaces."""
    inputs = {"Thin Wall": True, "Base Color": WHITE}
    inputs |= {name.replace("_", " "): value for name, value in sockets.items()}
    attribute = Node("VertexColor", "attribute", {}, {"layer_name": "A"})
    node = Node("BsdfPrincipled", "principled", inputs, {})
    return Graph("test", (attribute, node), {"Surface": Link(1, "BSDF")})


def models(graph: Graph, **lanes: object) -> list[str]:
    return [name_of(c) for c in compiled_closures(graph, direction(0.5), **lanes)]


def test_glass_is_a_reflection_and_a_transmission() -> None:
    assert models(wall(Transmission_Weight=1.0, Roughness=0.3)) == ["conductor", "thin_transmission"]


def test_smooth_glass_is_transparent_but_to_the_camera() -> None:
    graph = wall(Transmission_Weight=1.0, Roughness=0.0)
    assert sorted(models(graph)) == ["conductor", "thin_transmission", "transparent"]
    batch = compile_materials([graph]).batches[0]
    assert batch.delta_only
    for kind, seen, clear in ((RayKind.CAMERA, 1, 0), (RayKind.SHADOW, 0, 1)):
        lanes = NodeLanes(n=1, wi=direction(0.5), ray_kind=np.array([kind], np.int32))
        through = {name_of(c): c.weight for c in batch.closures(lanes)}
        assert (through["thin_transmission"] > 0).all() == seen
        assert (batch.transparency(lanes) > 0).all() == clear


def test_matter_is_split_by_its_anisotropy() -> None:
    """(1 − g)/2 comes back, (1 + g)/2 passes."""
    graph = wall(Subsurface_Weight=1.0, Subsurface_Anisotropy=0.5, IOR=1.0)
    weights = {name_of(c): c.weight[0, 0] for c in compiled_closures(graph, direction(0.5))}
    assert weights == {"translucent": pytest.approx(0.75), "diffuse": pytest.approx(0.25)}
    rough = wall(Subsurface_Weight=1.0, Diffuse_Roughness=0.5, IOR=1.0)
    assert models(rough) == ["rough_translucent", "oren_nayar"]


def test_a_linked_switch_has_both() -> None:
    graph = wall(Thin_Wall=Link(0, "Alpha"), Transmission_Weight=1.0)
    lanes = {"colors": {"A": np.zeros((3, 1), np.float32)}}  # of alpha 1
    by_name = {name_of(c): c.weight.max() for c in compiled_closures(graph, direction(0.5), **lanes)}
    assert set(by_name) == {"conductor", "thin_transmission", "dielectric"}
    assert by_name["dielectric"] == 0
    assert by_name["thin_transmission"] > 0
    np.testing.assert_array_equal(is_true(np.array([0.0, 0.9, 1.0, -1.0], np.float32)), [0, 0, 1, 1])


@pytest.mark.parametrize("film", [(), (f32(400.0), f32(1.4))], ids=["bare", "film"])
def test_clear_sheets_lose_nothing(film: tuple[np.ndarray, ...]) -> None:
    """R + T = 1, to rounding, for faces of any index; 1e-5: t₁t₂/(1 − r²) of small differences."""
    cos = np.linspace(0.02, 1, 50, dtype=np.float32)
    one = f32(1.0, 1.0, 1.0)
    for eta in (1.0, 1.3, 2.5):
        r, t = sheet_shares(cos, f32(eta), one, one, *film)
        if not film:  # a film's own faces differ from within by the mean over wavelengths
            np.testing.assert_allclose(r + t, 1, atol=1e-5)
        assert (r + t).max() <= 1 + 1e-5


def test_shares_are_the_sum_of_all_crossings() -> None:
    """r + t²c²r + t²c⁴r³ + … and t²c + t²c³r² + …, twenty terms of them; at 60°, with η = 1.5."""
    cos, eta, color = f32(0.5), f32(1.5), f32(0.2, 0.6, 0.9)
    r, g = (x.astype(np.float64) for x in fresnel.dielectric(cos, eta))
    c = color.astype(np.float64) ** (eta / g)
    t = 1 - r
    k = np.arange(20)
    ours = sheet_shares(cos, eta, f32(1.0, 1.0, 1.0), color)
    np.testing.assert_allclose(
        ours[0], r + ((r * c) ** (2 * k + 1) * c * t * t).sum(1, keepdims=True), rtol=1e-5
    )
    np.testing.assert_allclose(ours[1], ((r * c) ** (2 * k) * c * t * t).sum(1, keepdims=True), rtol=1e-5)


@pytest.mark.parametrize("roughness", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("cos", [0.2, 1.0])
def test_white_walls_keep_their_light(roughness: float, cos: float) -> None:
    """3 %: as of Principled at large."""
    for sockets in ({"Transmission_Weight": 1.0}, {"Subsurface_Weight": 1.0}):
        graph = wall(Roughness=roughness, **sockets)
        np.testing.assert_allclose(furnace_albedo(graph, direction(cos, 0.3), rows=48), 1, atol=0.03)


@pytest.mark.parametrize(
    ("sockets", "state"),
    [
        ({"Transmission_Weight": 0.5}, EXACT),
        ({"Subsurface_Weight": 0.5}, EXACT),
        ({"Subsurface_Weight": 0.5, "Thin_Wall": False}, APPROXIMATE),
    ],
)
def test_walls_are_exact(sockets: dict[str, object], state: str) -> None:
    (entry,) = (e for e in compile_materials([wall(**sockets)]).coverage if e.node == "principled")
    assert entry.state == state
