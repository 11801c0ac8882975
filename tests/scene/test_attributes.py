"""Shading attributes at known barycentrics, over instances with and without the layer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.hits import lanes_of, placed, rotation, shoot

from pt_engine.core import vectors
from pt_engine.nodes.tangents import uv_tangent
from pt_engine.scene import attributes
from pt_engine.scene.geometry import flatten
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Graph, Link, Node

CAMERA = make.perspective((0, 0, 5), (0, 0, 0))
RNG = np.random.default_rng(12)
# corners of one triangle and a square; per-corner layers
CORNERS = np.arange(6, dtype=np.int32).reshape(2, 3)
UV = RNG.random((6, 2)).astype(np.float32)
COLOR = RNG.random((6, 4)).astype(np.float32)
BARY = np.array([(0, 0), (1, 0), (0, 1), (1 / 3, 1 / 3), (0.2, 0.7)], np.float32).T


def with_layers(mesh, **more):
    defaults = {"corner_index": CORNERS, "uvs": {"map": UV}, "colors": {"paint": COLOR}}
    return replace(mesh, **{**defaults, "active_uv": "map", "active_color": "paint", **more})


def blend(corner_values, u, v):
    """a + u (b − a) + v (c − a) in float64, (C, N)."""
    a, b, c = np.asarray(corner_values, np.float64)
    return ((1 - u - v)[:, None] * a + u[:, None] * b + v[:, None] * c).T


@pytest.fixture(name="world")
def _world():
    """Instances: with layers, without, with again (another mesh before it in the table), and no triangles."""
    rich, plain = with_layers(make.quad()), make.box()
    other = with_layers(make.quad(3.0), uvs={"map": 1 - UV}, colors={"paint": 1 - COLOR})
    hollow = make.mesh(np.zeros((0, 3)), np.zeros((0, 3)))
    grey = make.diffuse(0.5)
    meshes = [plain, rich, hollow, plain, other, rich]
    snapshot = make.scene([(m, make.translation(9 * k, 0, 0), grey) for k, m in enumerate(meshes)], CAMERA)
    return snapshot, flatten(snapshot)


@pytest.mark.parametrize(("kind", "default"), [("uv", (0, 0)), ("color", (0, 0, 0, 0))])
@pytest.mark.parametrize("name", ["", "map/paint"])
def test_layers_blend_corners_by_barycentrics(world, kind, default, name):
    """(1 − u − v) a + u b + v c where the mesh has the layer, zero where it has not, as in Blender."""
    snapshot, geometry = world
    build, table = {
        "uv": (attributes.uv_layer, UV),
        "color": (attributes.color_layer, COLOR),
    }[kind]
    layer = build(snapshot, geometry, name and {"uv": "map", "color": "paint"}[kind])
    u, v = BARY
    for instance, values in ((0, None), (1, table), (3, None), (4, 1 - table), (5, table)):
        first = int(geometry.first_triangle[instance])
        for triangle in range(2):
            prim = np.full(len(u), first + triangle, np.int32)
            got = layer.at(prim, np.full(len(u), instance, np.int32), u, v)
            expected = (
                np.tile(np.array([default], float).T, len(u))
                if values is None
                else blend(values[CORNERS[triangle]], u, v)
            )
            np.testing.assert_allclose(got, expected, atol=2e-7)
            assert got.dtype == np.float32


def test_lanes_of_different_instances_do_not_mix(world):
    snapshot, geometry = world
    layer = attributes.uv_layer(snapshot, geometry, "")
    prim = RNG.integers(0, geometry.first_triangle[-1], 300).astype(np.int32)
    instance = (np.searchsorted(geometry.first_triangle, prim, side="right") - 1).astype(np.int32)
    u, v = (RNG.random((2, 300)) / 2).astype(np.float32)
    whole = layer.at(prim, instance, u, v)
    for k in (0, 17, 299):
        one = slice(k, k + 1)
        np.testing.assert_array_equal(layer.at(prim[one], instance[one], u[one], v[one]), whole[:, one])


def test_a_name_that_nobody_has_is_zero_everywhere(world):
    snapshot, geometry = world
    prim, instance = np.arange(4, dtype=np.int32), np.zeros(4, np.int32)
    half = np.full(4, 0.5, np.float32)
    assert (attributes.uv_layer(snapshot, geometry, "?").at(prim, instance, half, half) == 0).all()


def test_vertex_colours_are_found_by_vertex():
    """A layer too short for the corners belongs to the vertices."""
    paint = RNG.random((4, 4)).astype(np.float32)
    mesh = with_layers(make.quad(), colors={"paint": paint})
    snapshot = make.scene([(mesh, np.eye(4), make.diffuse(0.5))], CAMERA)
    layer = attributes.color_layer(snapshot, flatten(snapshot), "paint")
    for t in range(2):
        prim = np.full(BARY.shape[1], t, np.int32)
        got = layer.at(prim, np.zeros_like(prim), *BARY)
        np.testing.assert_allclose(got, blend(paint[mesh.triangles[t]], *BARY), atol=2e-7)


def test_generated_maps_the_texture_space_to_the_unit_cube():
    """0 at the box's low corner, ½ at its centre, 1 at its high one; by undeformed positions."""
    space = np.array([(1, 2, 3), (2, 4, 0)], np.float32)  # a size of 0 counts as 1
    corners = np.array([(-1, -2, 3), (3, 6, 3), (1, 2, 3)], np.float32)
    expected = np.array([(0, 0, 0.5), (1, 1, 0.5), (0.5, 0.5, 0.5)])
    moved = replace(make.mesh(corners + 7, [(0, 1, 2)]), texture_space=space, orco=corners)
    for mesh in (replace(make.mesh(corners, [(0, 1, 2)]), texture_space=space), moved):
        snapshot = make.scene([(mesh, placed(rotation() * 5, (1, 2, 3)), make.diffuse(0.5))], CAMERA)
        layer = attributes.generated_layer(snapshot, flatten(snapshot))
        prim = np.zeros(BARY.shape[1], np.int32)
        np.testing.assert_allclose(layer.at(prim, prim, *BARY), blend(expected, *BARY), atol=1e-6)


def test_normals_of_flat_meshes_are_left_out():
    """No layer where nothing is smooth; a default for flat meshes beside smooth ones."""
    flat, ball = make.box(), make.sphere(1, 6)
    grey = make.diffuse(0.5)
    only_flat = make.scene([(flat, np.eye(4), grey)], CAMERA)
    assert attributes.normal_layer(only_flat, flatten(only_flat)) is None
    both = make.scene([(flat, np.eye(4), grey), (ball, np.eye(4), grey)], CAMERA)
    layer = attributes.normal_layer(both, flatten(both))
    assert layer.has.tolist() == [False, True]
    prim, u, v = np.full(BARY.shape[1], 12 + 40, np.int32), *BARY
    got = layer.at(prim, np.ones_like(prim), u, v)
    np.testing.assert_allclose(got, blend(ball.normals[ball.triangles[40]], u, v), atol=2e-7)


# ------------------------------------------------------------------ tangents


def painted(mesh, matrix):
    """A prepared scene whose material asks for the tangent, and hits all over it from both sides."""
    nodes = (
        Node(
            "NormalMap",
            "map",
            {"Color": (0.5, 0.5, 1.0, 1.0), "Strength": 0.5},
            {"space": "TANGENT", "uv_map": "map"},
        ),
        Node("BsdfDiffuse", "d", {"Color": make.WHITE, "Roughness": 0.0, "Normal": Link(0, "Normal")}),
    )
    graph = Graph("bumpy", nodes, {"Surface": Link(1, "BSDF")})
    scene = prepare(make.scene([(mesh, matrix, graph)], CAMERA))
    # pick one lane per triangle and side through its middle
    p = mesh.vertices.astype(np.float64)[mesh.triangles].mean(axis=1) @ matrix[:3, :3].T + matrix[:3, 3]
    n = scene.geometry.records[:-1, :3].astype(np.float64)
    return scene, shoot(scene, np.concatenate([p + 0.1 * n, p - 0.1 * n]), np.concatenate([-n, n])).si


@pytest.mark.parametrize(
    "scale",
    [
        (1, 1, 1),
        (1, 2, 3),
        pytest.param((-1, 1, 1), id="mirrored"),
        pytest.param((2, -1, -3), id="turned"),
        pytest.param((1, 1, -2), id="mirrored in z"),
    ],
)
@pytest.mark.parametrize("flip", [False, True], ids=["uv", "mirrored uv"])
def test_the_tangent_follows_u_and_the_bitangent_v(scale, flip):
    """t ∝ ∂p/∂u and sign · n × t on the side of ∂p/∂v, in the object.

    On the plane (x, y) with u = (x + y)/2, v = (y − x)/2 (or −v): ∂p/∂u = (1, 1, 0), ∂p/∂v = ±(−1, 1, 0).
    Normal maps are read in object space, where a mirrored instance is no special case.
    """
    quad = make.quad(2.0)
    x, y, _ = quad.vertices[quad.triangles.ravel()].T
    v = (y - x) / 2 * (-1 if flip else 1)
    mesh = with_layers(quad, uvs={"map": np.stack([(x + y) / 2, v], axis=1)})
    linear = rotation(3) @ np.diag(scale)
    scene, si = painted(mesh, placed(linear, (4, 5, 6)))
    assert si.size == 4
    assert si.back.sum() == 2
    lanes = lanes_of(scene, si)
    tangent, sign = lanes.object_tangent("map")
    np.testing.assert_allclose(tangent, np.array([[0.5**0.5], [0.5**0.5], [0]]) * np.ones(4), atol=1e-6)
    normal = lanes.to_object_normal(lanes.ng * (1 - 2 * lanes.backfacing))
    assert (normal[2] > 0).all()  # the face's own side, whatever the matrix and the viewer
    along_v = np.array((1, -1, 0) if flip else (-1, 1, 0))
    assert (along_v @ (sign * vectors.cross(normal, tangent)) > 0).all()


@pytest.mark.parametrize("turn", [1, 2])
def test_the_tangent_is_orthogonal_to_the_shading_normal(turn):
    ball = make.sphere(1.0, 8)
    corners = np.arange(3 * len(ball.triangles), dtype=np.int32).reshape(-1, 3)
    p = ball.vertices[ball.triangles.ravel()]
    mesh = replace(
        ball, corner_index=corners, uvs={"map": np.ascontiguousarray(p[:, [0, 2]])}, active_uv="map"
    )
    scene, si = painted(mesh, placed(rotation(turn) @ np.diag([1, 2, 0.5])))
    lanes = lanes_of(scene, si, smooth=True)
    tangent = uv_tangent(lanes, "map")
    np.testing.assert_allclose(vectors.dot(tangent, lanes.ns), 0, atol=1e-6)
    np.testing.assert_allclose(vectors.length(tangent), 1, atol=1e-6)


@pytest.mark.parametrize(("uvs", "tangent"), [({}, 0), ({"map": np.zeros((6, 2), np.float32)}, 1)])
def test_a_tangent_without_uv_is_no_number_out_of_range(uvs, tangent):
    """No map: nothing. One without area: along x, as MikkTSpace begins."""
    scene, si = painted(with_layers(make.quad(), uvs=uvs), np.eye(4))
    found, _ = lanes_of(scene, si).object_tangent("map")
    np.testing.assert_array_equal(found, np.array([[tangent], [0], [0]]) * np.ones(si.size))
