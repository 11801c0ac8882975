"""Dicing: no cracks, nothing too long, layers that follow, and what a pixel measures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.hits import placed, rotation

from pt_engine.scene.pixel_size import pixel_size
from pt_engine.scene.refine import refined
from pt_engine.scene.snapshot import MeshData

EYE = np.eye(4)
MANY = 10**6


def width(size: float):
    return lambda p: np.full(len(p), size)


def edges(mesh: MeshData, matrix: np.ndarray = EYE) -> np.ndarray:
    """(T, 3) lengths in the world."""
    world = mesh.vertices.astype(float) @ matrix[:3, :3].T
    p = world[mesh.triangles]
    return np.linalg.norm(np.roll(p, -1, axis=1) - p, axis=2)


def uneven(p: np.ndarray) -> np.ndarray:
    """Ten times as fine on one side as on the other."""
    return 0.04 + 0.18 * np.abs(p[:, 0] + 1)


@pytest.mark.parametrize("curved", [False, True])
def test_a_closed_surface_stays_closed(curved: bool) -> None:
    """Every directed edge of a diced box has exactly one twin in the other direction; V − E + F = 2."""
    made, coarser = refined(make.box(), EYE, uneven, curved, MANY)
    assert coarser == 1
    ends = np.stack([made.triangles, np.roll(made.triangles, -1, axis=1)], axis=-1).reshape(-1, 2)
    directed = {(int(a), int(b)) for a, b in ends}
    assert len(directed) == len(ends)
    assert all((b, a) in directed for a, b in directed)
    used = np.unique(made.triangles)
    assert len(used) - len(ends) // 2 + len(made.triangles) == 2


def test_cells_are_no_wider_than_asked_for() -> None:
    """Edges ≤ √2·length in the world, through any matrix; a square's halves stay right isosceles."""
    matrix = placed(rotation() @ np.diag([2.0, 0.5, 1.0]))
    made, _ = refined(make.box(), matrix, width(0.17), False, MANY)
    assert edges(made, matrix).max() <= np.sqrt(2) * 0.17 * (1 + 1e-6)
    square, _ = refined(make.quad(), EYE, width(0.1), False, MANY)
    long, short = edges(square).max(axis=1), edges(square).min(axis=1)
    np.testing.assert_allclose(long / short, np.sqrt(2), rtol=1e-4)
    assert len(square.triangles) == 2 * 128  # sides shrink by √½: 128^−½ is the first below 0.1


def test_flat_cuts_change_no_shape() -> None:
    """Every new vertex of a diced box lies on the box; the area is the box's."""
    made, _ = refined(make.box(2.0), EYE, width(0.3), False, MANY)
    np.testing.assert_allclose(np.abs(made.vertices).max(axis=1), 1, atol=1e-6)
    p = made.vertices[made.triangles].astype(float)
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum() / 2
    np.testing.assert_allclose(area, 24, rtol=1e-5)


def test_curved_cuts_follow_a_sphere() -> None:
    """From edges of angle a = π/16 to the sphere: an arc's cubic is off by about a⁴/100, chords by a²/8."""
    coarse = make.sphere(1.0, 16)
    made, _ = refined(coarse, EYE, width(0.02), True, MANY)
    radius = np.linalg.norm(made.vertices.astype(float), axis=1)
    assert np.abs(radius - 1).max() < 4e-4
    chords, _ = refined(coarse, EYE, width(0.02), False, MANY)
    assert np.abs(np.linalg.norm(chords.vertices.astype(float), axis=1) - 1).max() > 4e-3
    assert made.normals is not None
    assert (made.normals * made.vertices).sum(axis=1).min() > 0.999


def test_layers_follow() -> None:
    """uv, colour and Generated that are linear in the position stay so; materials stay where they were."""
    box = make.box()
    p = box.vertices[box.triangles].reshape(-1, 3)
    index = np.arange(len(p), dtype=np.int32).reshape(-1, 3)
    rich = replace(
        box,
        corner_index=index,
        uvs={"map": p[:, :2] * 0.5, "other": p[:, 1:]},
        colors={"paint": np.concatenate([p, p[:, :1]], axis=1)},
        orco=box.vertices * 3,
        material_slot=(np.arange(12) // 2).astype(np.int32),
    )
    made, _ = refined(rich, EYE, width(0.3), False, MANY)
    at = made.vertices[made.triangles].reshape(-1, 3)
    assert made.corner_index is not None
    corner = made.corner_index.ravel()
    np.testing.assert_allclose(made.uvs["map"][corner], at[:, :2] * 0.5, atol=1e-6)
    np.testing.assert_allclose(made.uvs["other"][corner], at[:, 1:], atol=1e-6)
    np.testing.assert_allclose(made.colors["paint"][corner][:, :3], at, atol=1e-6)
    assert made.orco is not None
    np.testing.assert_allclose(made.orco, made.vertices * 3, atol=1e-6)
    for slot in range(6):
        corners = at.reshape(-1, 3, 3)[made.material_slot == slot].reshape(-1, 3)
        assert (np.ptp(corners, axis=0) < 1e-6).sum() == 1  # one side of the box each


def test_flat_faces_stay_flat_among_smooth_ones() -> None:
    """Corner normals: the face's on flat faces, the vertices' on the others."""
    box = make.box()
    normals = box.vertices / np.sqrt(3)
    flat = np.zeros(12, np.uint8)
    flat[:2] = 1
    made, _ = refined(
        replace(box, normals=normals, normal_index=box.triangles, flat=flat), EYE, width(1.0), True, MANY
    )
    assert made.normals is not None
    assert made.normal_index is not None
    assert made.flat is not None
    corner = made.normals[made.normal_index][made.flat == 1]
    np.testing.assert_allclose(np.ptp(corner, axis=1), 0, atol=1e-6)
    assert np.ptp(made.normals[made.normal_index][made.flat == 0], axis=1).max() > 0.1


def test_a_limit_coarsens_everything() -> None:
    """A million cells asked for, ten thousand allowed: lengths grow by 10 or somewhat more."""
    made, coarser = refined(make.quad(), EYE, width(1e-3), False, 10_000)
    assert len(made.triangles) <= 10_000
    assert 10 < coarser < 30


def test_what_is_fine_already_is_left_alone() -> None:
    box = make.box()
    made, _ = refined(box, EYE, width(5.0), False, MANY)
    np.testing.assert_array_equal(made.triangles, box.triangles)


def test_a_pixel_ahead_grows_with_distance() -> None:
    """tan 45°·2/100 per unit of distance, the smaller of width and height; out of view more."""
    camera = make.perspective((0, 0, 0), (0, 0, -1), 1.0)
    at = np.array([[0, 0, -5.0], [3, 0, -4], [0, 0, 5]])
    size = pixel_size(camera, 100, 50, 1.0)(at)
    np.testing.assert_allclose(size, 0.02 * 5, rtol=2e-3)  # the ray's step is that of a unit vector
    scaled = pixel_size(camera, 100, 50, 4.0)(at)
    np.testing.assert_allclose(scaled[:2], size[:2])
    np.testing.assert_allclose(
        scaled[2], size[2] + 0.02 * 3 * 5, rtol=2e-3
    )  # behind: the distance to the eye
    beside = np.array([[7.0, 0, -5]])
    out = 2 / np.sqrt(2)  # from x = 7 to the plane x = −z
    expected = 0.02 * (np.sqrt(74) + 3 * out)
    np.testing.assert_allclose(pixel_size(camera, 100, 50, 4.0)(beside), expected, rtol=2e-3)


def test_a_pixel_of_a_parallel_view_is_the_same_everywhere() -> None:
    camera = make.orthographic((0, 0, 9), (0, 0, 0), 4.0)
    size = pixel_size(camera, 100, 200, 4.0)(np.array([[0, 0, 0.0], [1, 1.5, -7]]))
    np.testing.assert_allclose(size, 4 / 200, rtol=1e-4)
    assert pixel_size(camera, 100, 200, 4.0)(np.array([[6.0, 0, 0]]))[0] > 0.04
