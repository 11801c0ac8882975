"""Light through transparent surfaces: the product of what each lets through, up to a limit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.hits import column, unit
from support.rooms import half_transparent

from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Graph, LightData, Link, Node
from pt_engine.scene.transmittance import transmittance

UP = np.eye(4)
TAU = [(0.9, 0.5, 0.1), (0.8, 0.8, 0.3), (1.0, 0.2, 0.7)]
NONE = np.zeros(3)


def clear(rgb) -> object:
    return make.shader("BsdfTransparent", f"clear {rgb}", Color=make.rgba(rgb))


def stack(materials):
    """Sheets at z = 1, 2, 3 …, recentred to the middle of the stack; z of the recentred zero."""
    sheets = [(make.quad(4.0), make.translation(0, 0, k + 1), m) for k, m in enumerate(materials)]
    scene = prepare(make.scene(sheets, make.perspective((0, 0, 9), (0, 0, 0))))
    return scene, scene.geometry.origin[2]


def through(materials, tfar, limit=8, z0=0.0, d=(0, 0, 1.0)):
    """What is left of the light of one ray up from z0."""
    scene, centre = stack(materials)
    tfar = np.atleast_1d(np.float32(tfar))
    n = len(tfar)
    o, d = column([(0.1, 0.2, z0 - centre)] * n), np.tile(unit([d]), n)
    return transmittance(scene, o, d, tfar.copy(), limit)


@pytest.mark.parametrize("layers", [1, 2, 3])
@pytest.mark.parametrize("d", [(0, 0, 1.0), (0.2, -0.1, 1.0)])
def test_the_product_of_all_sheets_between(layers, d):
    """T = Π τ_k, per channel, whatever the angle."""
    left = through([clear(t) for t in TAU[:layers]], 100, d=d)
    np.testing.assert_allclose(left[:, 0], np.prod(TAU[:layers], axis=0), rtol=1e-6)


def test_only_what_lies_before_the_end_counts():
    """tfar between the sheets, and on either side of each."""
    tfar = [0.5, 0.999, 1.001, 1.5, 2.5, 3.5, 1e30]
    left = through([clear(t) for t in TAU], tfar)
    expected = [np.prod(TAU[:k], axis=0) if k else np.ones(3) for k in (0, 0, 1, 1, 2, 3, 3)]
    np.testing.assert_allclose(left, np.transpose(expected), rtol=1e-6)


def test_opaque_surfaces_block_and_black_ones_too():
    opaque = make.diffuse(0.5)
    glass = make.shader("BsdfGlass", "glass", Color=make.WHITE, Roughness=0.0, IOR=1.5)
    for materials, tfar, expected in (
        ([clear(TAU[0]), opaque], 100, NONE),
        ([clear(TAU[0]), opaque], 1.5, TAU[0]),
        ([opaque, clear(TAU[0])], 100, NONE),
        ([clear(TAU[0]), make.emission(5.0)], 100, NONE),
        ([clear((1, 0, 0)), clear((0, 1, 1))], 100, NONE),
        ([clear(TAU[0]), glass], 9, NONE),
    ):
        np.testing.assert_allclose(through(materials, tfar)[:, 0], expected, rtol=1e-6)


@pytest.mark.parametrize("factor", [0.0, 0.25, 1.0])
def test_a_mix_lets_its_share_through(factor):
    """Mix of Lambert and Transparent by `factor`; at 0 it is opaque, at 1 clear."""
    veil = clear(TAU[0])
    left = through([half_transparent(factor), veil], 50)[:, 0]
    np.testing.assert_allclose(left, factor * np.array(TAU[0]), rtol=1e-6)


@pytest.mark.parametrize("limit", [0, 1, 2, 3])
def test_a_ray_passes_no_more_surfaces_than_the_limit(limit):
    """Three sheets: with a limit of k, light from behind the (k + 1)st is lost."""
    tfar = [0.5, 1.5, 2.5, 3.5]
    left = through([clear((0.5, 0.5, 0.5))] * 3, tfar, limit=limit)
    expected = [0.5**k if k <= limit else 0.0 for k in range(4)]
    np.testing.assert_allclose(left, np.tile(expected, (3, 1)), rtol=1e-6)


def test_a_ray_that_starts_on_a_sheet_does_not_meet_it_again():
    """64 sheets 10⁻³ apart: each passed once, 0.98⁶⁴."""
    sheets = [(make.quad(4.0), make.translation(0.3, 0.1, k / 1000), clear((0.98,) * 3)) for k in range(64)]
    scene = prepare(make.scene(sheets, make.perspective((0, 0, 9), (0, 0, 0))))
    rng = np.random.default_rng(1)
    n = 500
    o = column(np.c_[rng.uniform(-1, 1, (n, 2)), np.full(n, -1.0)])
    d = unit(np.c_[rng.uniform(-0.3, 0.3, (n, 2)), np.ones(n)])
    left = transmittance(scene, o, d, np.full(n, 1e30, np.float32), 64)
    np.testing.assert_allclose(left, 0.98**64, rtol=2e-5)
    assert (transmittance(scene, o, d, np.full(n, 1e30, np.float32), 63) == 0).all()


def test_lanes_keep_their_order_and_do_not_mix():
    """Rays up, down, switched off, blocked and clear side by side; alone the same bits."""
    scene, centre = stack([clear(TAU[0]), half_transparent(0.5), clear(TAU[1])])
    rng = np.random.default_rng(2)
    n = 400
    o = column(np.c_[rng.uniform(-3, 3, (n, 2)), rng.uniform(0, 4, n) - centre])
    d = unit(rng.normal(size=(n, 3)))
    tfar = rng.uniform(0.1, 8, n).astype(np.float32)
    whole = transmittance(scene, o, d, tfar.copy(), 4)
    for k in range(0, n, 23):
        one = slice(k, k + 1)
        alone = transmittance(scene, *(np.ascontiguousarray(a[:, one]) for a in (o, d)), tfar[one].copy(), 4)
        np.testing.assert_array_equal(alone, whole[:, one])
    z, up = o[2] + centre, d[2]
    sheets = np.array([[1.0], [2.0], [3.0]])
    crosses = ((z - sheets) * (z + tfar * up - sheets) < 0).any(axis=0)
    assert (~crosses).sum() > 20
    assert (whole[:, ~crosses] == 1).all()


def test_transparency_may_vary_over_the_surface():
    """τ from a colour attribute: the sheet's own corner colours, interpolated where each ray passes."""
    nodes = (
        Node("VertexColor", "paint", {}, {"layer_name": "paint"}),
        Node("BsdfTransparent", "t", {"Color": Link(0, "Color")}),
    )
    graph = Graph("painted", nodes, {"Surface": Link(1, "BSDF")})
    x, y = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]).T
    paint = np.stack([(x + 1) / 2, (y + 1) / 2, 0.5 + 0 * x, 1 + 0 * x], axis=1).astype(np.float32)
    sheet = replace(make.quad(2.0), colors={"paint": paint}, active_color="paint")
    scene = prepare(make.scene([(sheet, UP, graph)], make.perspective((0, 0, 9), (0, 0, 0))))
    p = np.random.default_rng(3).uniform(-0.99, 0.99, (100, 2))
    o = column(np.c_[p, np.full(100, -1.0)])
    left = transmittance(scene, o, column([(0, 0, 1)] * 100), np.full(100, 5, np.float32), 8)
    np.testing.assert_allclose(left[:2], (p.T + 1) / 2, atol=1e-6)
    np.testing.assert_allclose(left[2], 0.5, atol=1e-6)


def test_lamps_without_shadows_shine_through_everything():
    """cast_shadow off: L = ρ/π Φ/(4π h²), with something in the way or not, transparent or not."""
    expected = 0.8 / np.pi * 100 / (4 * np.pi * 2**2)
    lid = make.quad(0.5), make.translation(0, 0, 1.9)
    aside = (make.quad(0.1), make.translation(5, 5, 1), clear(TAU[0]))
    for cast, others, factor in (
        (True, [], 1.0),
        (False, [], 1.0),
        (True, [(*lid, make.diffuse(0.5))], 0.0),
        (False, [(*lid, make.diffuse(0.5))], 1.0),
        (True, [aside], 1.0),
        (False, [aside], 1.0),
        (False, [aside, (*lid, make.diffuse(0.5))], 1.0),
        (False, [(*lid, clear((0.5,) * 3))], 1.0),
        (True, [(*lid, clear((0.5,) * 3))], 0.5),
    ):
        lamp = LightData("POINT", "lamp", make.translation(0, 0, 2), 100.0, cast_shadow=cast)
        plane = (make.quad(100.0), UP, make.diffuse(0.8))
        snapshot = make.scene([plane, *others], make.orthographic((0, 0, 1.0), (0, 0, 0), 0.02), [lamp])
        image = make.rendered(snapshot, 4, samples=2, max_depth=2).image()[..., :3]
        np.testing.assert_allclose(
            image, expected * factor, rtol=1e-3, err_msg=f"{cast}, {len(others)} objects"
        )
