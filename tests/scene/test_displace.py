"""Displaced meshes with known answers: places, areas, normals, and what stays where it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.hits import placed, rotation

from pt_engine.nodes.compile import compile_materials
from pt_engine.scene.displace import displaced
from pt_engine.scene.prepare import prepare, shading_layers
from pt_engine.scene.snapshot import Graph, Link, MeshData, Node

CAMERA = make.perspective((0, 0, 5), (0, 0, 0))
DIFFUSE = Node("BsdfDiffuse", "d", {})


def material(*nodes: Node, method: str = "DISPLACEMENT") -> Graph:
    """Grey, displaced by the last of `nodes`, which are numbered from 1."""
    outputs = {"Surface": Link(0, "BSDF"), "Displacement": Link(len(nodes), "Displacement")}
    return Graph("displaced", (DIFFUSE, *nodes), outputs, displacement_method=method)


def raised(height: float | Link, space: str = "OBJECT", **inputs: object) -> Node:
    return Node(
        "Displacement", "up", {"Height": height, "Midlevel": 0.0, "Scale": 1.0, **inputs}, {"space": space}
    )


def moved(mesh: MeshData, graph: Graph, matrix: np.ndarray | None = None) -> MeshData:
    """The mesh after displacement under one instance."""
    snapshot = make.scene([(mesh, np.eye(4) if matrix is None else matrix, graph)], CAMERA)
    return displaced(snapshot, compile_materials(snapshot.materials), shading_layers).meshes[0]


def grid(n: int, smooth: bool = False) -> MeshData:
    """The unit square as n × n cells."""
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
    corners = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + n + 2], 1), np.stack([a, a + n + 2, a + n + 1], 1)])
    return make.mesh(corners, faces, np.tile([0.0, 0, 1], (x.size, 1)) if smooth else None)


def area(mesh: MeshData) -> float:
    a, b, c = (mesh.vertices[mesh.triangles[:, k]].astype(float) for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


@pytest.mark.parametrize(("space", "rise"), [("OBJECT", 0.6), ("WORLD", 0.2)])
def test_a_height_is_in_the_units_of_its_space(space: str, rise: float) -> None:
    """(0.9 − 0.5)·0.5 = 0.2 along the normal: of the world, or of an object three times as large."""
    node = raised(0.9, space, Midlevel=0.5, Scale=0.5)
    turned = rotation()
    matrix = placed(3 * turned, (1, 2, 3))
    before = make.quad()
    after = moved(before, material(node), matrix)
    step = (after.vertices - before.vertices).astype(float) @ matrix[:3, :3].T
    np.testing.assert_allclose(step, np.tile(rise * turned[:, 2], (4, 1)), atol=1e-6)  # a few roundings


def test_a_ramp_has_the_area_and_the_normal_of_a_tilted_plane() -> None:
    """z = a·x over the unit square: area √(1 + a²), normal (−a, 0, 1)/√(1 + a²)."""
    coordinates = Node("TexCoord", "c", {})
    split = Node("SeparateXYZ", "s", {"Vector": Link(1, "Object")})
    after = moved(grid(8, smooth=True), material(coordinates, split, raised(Link(2, "X"), Scale=0.75)))
    slant = np.sqrt(1 + 0.75**2)
    np.testing.assert_allclose(area(after), slant, rtol=1e-6)
    assert after.normals is not None
    np.testing.assert_allclose(after.normals, np.tile([-0.75 / slant, 0, 1 / slant], (81, 1)), atol=1e-6)


def cube_to_sphere(space: str) -> list[Node]:
    """Nodes that move the point P to P/|P|: the vector P/|P| − P."""
    position = Node("NewGeometry", "g", {})
    along = Node("VectorMath", "n", {"Vector": Link(1, "Position")}, {"operation": "NORMALIZE"})
    step = Node(
        "VectorMath",
        "s",
        {"Vector": Link(2, "Vector"), "Vector_001": Link(1, "Position")},
        {"operation": "SUBTRACT"},
    )
    inputs = {"Vector": Link(3, "Vector"), "Midlevel": 0.0, "Scale": 1.0}
    return [position, along, step, Node("VectorDisplacement", "up", inputs, {"space": space})]


@pytest.mark.parametrize("space", ["OBJECT", "WORLD"])
def test_a_cube_becomes_a_sphere(space: str) -> None:
    """Vertices at distance 1; normals nearly radial: each is a mean of six faces a cell wide."""
    n = 32
    side = grid(n)
    flat = side.vertices[:, :2] * 2 - 1
    sides = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            sides.append(
                np.roll(np.column_stack([flat[:, 0] * sign, flat[:, 1], np.full(len(flat), sign)]), axis, 1)
            )
    corners, back = np.unique(np.concatenate(sides).round(5), axis=0, return_inverse=True)
    triangles = np.concatenate([side.triangles + k * len(flat) for k in range(6)])
    cube = make.mesh(
        corners, back.ravel()[triangles], corners / np.linalg.norm(corners, axis=1, keepdims=True)
    )
    after = moved(cube, material(*cube_to_sphere(space)))
    radius = np.linalg.norm(after.vertices.astype(float), axis=1)
    np.testing.assert_allclose(radius, 1, atol=3e-7)  # float32 coordinates of length 1
    assert after.normals is not None
    assert np.abs(after.normals - after.vertices).max() < 0.02
    np.testing.assert_allclose(area(after), 4 * np.pi, rtol=2e-3)  # chords: (2/32)²/2


def test_both_moves_vertices_and_keeps_normals() -> None:
    """Under BOTH the shading, not the vertices, makes the new normal; a constant height has none."""
    mesh = grid(2, smooth=True)
    ramp = (Node("TexCoord", "c", {}), Node("SeparateXYZ", "s", {"Vector": Link(1, "Object")}))
    after = moved(mesh, material(*ramp, raised(Link(2, "X")), method="BOTH"))
    np.testing.assert_allclose(after.vertices[:, 2], mesh.vertices[:, 0], atol=1e-6)
    assert after.normals is not None
    assert mesh.normals is not None
    np.testing.assert_array_equal(after.normals, mesh.normals)


def test_bump_stays_where_it_is() -> None:
    mesh = grid(2)
    assert moved(mesh, material(raised(1.0), method="BUMP")) is mesh


def test_only_triangles_of_displaced_materials_move() -> None:
    """Two quads that share no vertex, one of each material; a non-finite height moves nothing."""
    mesh = make.quad()
    two = make.mesh(
        np.concatenate([mesh.vertices, mesh.vertices + [5, 0, 0]]),
        np.concatenate([mesh.triangles, mesh.triangles + 4]),
    )
    two = replace(two, material_slot=np.repeat(np.arange(2, dtype=np.int32), 2))
    snapshot = make.scene([(two, np.eye(4), material(raised(1.0)))], CAMERA)
    instances = replace(snapshot.instances, materials=np.array([[0, 1]], np.int32))
    snapshot = replace(snapshot, instances=instances)
    after = displaced(snapshot, compile_materials(snapshot.materials), shading_layers).meshes[0]
    np.testing.assert_array_equal(after.vertices[:, 2], np.repeat([0, 1], 4))


def test_generated_stays_with_the_undisplaced_mesh() -> None:
    """Generated is measured before displacement, as before every other change of shape."""
    mesh = grid(2)
    after = moved(mesh, material(raised(1.0)))
    assert after.orco is not None
    np.testing.assert_array_equal(after.orco, mesh.vertices)


def test_instances_share_the_displaced_mesh() -> None:
    """Two instances, one mesh: both quads stand 0.5 along their own normals."""
    mesh = make.quad()
    graph = material(raised(0.5))
    snapshot = make.scene([(mesh, np.eye(4), graph), (mesh, placed(rotation(), (9, 0, 0)), graph)], CAMERA)
    snapshot = replace(
        snapshot, meshes=(mesh,), instances=replace(snapshot.instances, mesh=np.zeros(2, np.int32))
    )
    scene = prepare(snapshot)
    planes = scene.geometry.records[:4].astype(float)
    centres = np.array([[0, 0, 0], [0, 0, 0], [9, 0, 0], [9, 0, 0]]) - scene.geometry.origin
    np.testing.assert_allclose(planes[:, 3] - (planes[:, :3] * centres).sum(axis=1), 0.5, atol=1e-5)
