"""Points, vectors and normals between object space and the world, for any matrix."""

from __future__ import annotations

import numpy as np
import pytest
from support import scenes as make
from support.hits import column, lanes_of, placed, rotation, shoot

from pt_engine.scene.prepare import prepare
from pt_engine.scene.transforms import Transforms, inverse_transposed

SHEAR = np.array([[1, 0.7, 0], [0, 1, -0.4], [0, 0, 1]])
LINEAR = {
    "rotation": rotation(1),
    "uniform": rotation(2) * 7,
    "non-uniform": rotation(3) @ np.diag([0.1, 1, 20]) @ rotation(4),
    "mirrored": rotation(5) @ np.diag([-1, 2, 3]),
    "sheared": SHEAR @ rotation(6),
    "tiny": rotation(7) * 1e-4,
}
N = 500


def random(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(3, N))


@pytest.fixture(params=LINEAR, name="case")
def _case(request):
    """Three instances, of which lanes use the middle one, far from the origin; and its 3×3 part."""
    linear, at = LINEAR[request.param], np.array([1e5, -2e5, 3e5])
    matrices = np.array([np.eye(4), placed(linear, at), placed(rotation(8), -at)])
    return Transforms(matrices, at - 1.0), linear, np.full(N, 1, np.int32)


def test_a_point_goes_to_object_space(case):
    """p = M⁻¹ (world − place), with the world recentred: no digits are lost at 10⁵."""
    transforms, linear, instance = case
    p = random(1)
    recentred = linear @ p + 1.0  # the instance sits at (1, 1, 1) of the recentred world
    back = transforms.point_to_object(recentred.astype(np.float32), instance)
    condition = np.linalg.cond(linear) * (1 + np.abs(np.linalg.inv(linear)).max())
    np.testing.assert_allclose(back, p, atol=1e-6 * condition * np.abs(p).max())


def test_vectors_there_and_back(case):
    transforms, linear, instance = case
    w = random(2).astype(np.float32)
    there = transforms.vector_to_world(w, instance)
    np.testing.assert_allclose(there, linear @ w, rtol=1e-5, atol=1e-5 * np.abs(linear).max())
    back = transforms.vector_to_object(there, instance)
    np.testing.assert_allclose(back, w, atol=1e-5 * np.linalg.cond(linear))


def test_a_normal_stays_orthogonal_to_the_surface(case):
    """n·t = 0 ⇒ (M⁻ᵀ n)·(M t) = 0, whatever M; and a normal's way to object space is the inverse."""
    transforms, linear, instance = case
    n = random(3)
    t = np.cross(n.T, random(4).T).T
    n32 = n.astype(np.float32)
    world = transforms.normal_to_world(n32, instance).astype(np.float64)
    along = linear @ t
    cosine = (world * along).sum(0) / np.linalg.norm(world, axis=0) / np.linalg.norm(along, axis=0)
    assert np.abs(cosine).max() < 1e-6 * np.linalg.cond(linear)
    np.testing.assert_allclose(world, np.linalg.inv(linear).T @ n, rtol=1e-4, atol=1e-5 * np.abs(world).max())
    back = transforms.normal_to_object(world.astype(np.float32), instance)
    np.testing.assert_allclose(back, n, atol=1e-5 * np.linalg.cond(linear))


def test_each_lane_uses_its_own_instance():
    matrices = np.array([placed(rotation(k) * (k + 1), (k, 0, 0)) for k in range(20)])
    transforms = Transforms(matrices, np.zeros(3))
    instance = np.random.default_rng(1).integers(0, 20, N).astype(np.int32)
    w = random(5).astype(np.float32)
    expected = np.einsum("nij,jn->in", matrices[instance, :3, :3], w)
    np.testing.assert_allclose(transforms.vector_to_world(w, instance), expected, atol=1e-4)
    np.testing.assert_array_equal(transforms.location(instance), column(matrices[instance, :3, 3]))


def test_a_flattened_object_stays_finite():
    """Scale 0 on some or all axes: no exception, no NaN, no ∞."""
    flat = [placed(rotation(1) @ np.diag(s)) for s in ((1, 1, 0), (1, 0, 0), (0, 0, 0))]
    transforms = Transforms(np.array(flat), np.zeros(3))
    w = random(6).astype(np.float32)
    for k in range(3):
        instance = np.full(N, k, np.int32)
        for move in (
            "vector_to_world",
            "vector_to_object",
            "point_to_object",
            "normal_to_world",
            "normal_to_object",
        ):
            assert np.isfinite(getattr(transforms, move)(w, instance)).all()


def test_the_normals_of_a_flattened_ball_are_those_of_the_disc():
    """M⁻ᵀ n for M → diag(1, 1, 0): the z component outgrows all others, so shading sees a flat disc."""
    turn = rotation(2)
    disc = (make.sphere(1.0, 16), placed(turn @ np.diag([1, 1, 0])), make.diffuse(0.5))
    scene = prepare(make.scene([disc], make.perspective((0, 0, 5), (0, 0, 0))))
    xy = np.random.default_rng(3).uniform(-0.6, 0.6, (200, 2))
    target = np.c_[xy, np.zeros(200)] @ turn.T
    si = shoot(scene, target + 2 * turn[:, 2], np.tile(-turn[:, 2], (200, 1))).si
    np.testing.assert_allclose(lanes_of(scene, si, smooth=True).ns, si.ng, atol=0.02)


def test_flattened_objects_may_be_turned():
    """Rounding leaves a determinant that is not 0 but means nothing: M⁻¹ is one that undoes M in its plane.

    M M⁺ p = p for p in the plane; and no number grows by the inverse of a rounding error.
    """
    scales = [np.diag(s) for s in ((1, 1, 0), (1e4, 1e4, 0), (2, 3, 0), (1, 0, 0), (0, 0, 0))]
    linear = np.array([rotation(k) @ s @ rotation(k + 1000) for k in range(40) for s in scales])
    matrices = np.zeros((len(linear), 4, 4))
    matrices[:, :3, :3], matrices[:, 3, 3] = linear, 1
    transforms = Transforms(matrices, np.zeros(3))
    p = np.random.default_rng(7).uniform(-1, 1, (3, len(linear)))
    instance = np.arange(len(linear), dtype=np.int32)
    there = np.einsum("nij,jn->in", linear, p)
    back = transforms.point_to_object(there.astype(np.float32), instance)
    again = np.einsum("nij,jn->in", linear, back)
    assert np.abs(back).max() < 2  # √3 by theory
    size = 1 + np.abs(there).max(axis=0)
    np.testing.assert_allclose(again / size, there / size, atol=1e-5)
    assert np.isfinite(transforms.normal_to_world(p.astype(np.float32), instance)).all()


def test_no_instances():
    Transforms(np.zeros((0, 4, 4)), np.zeros(3))


@pytest.mark.parametrize("size", [1e-200, 1e-100, 1e100, 1e200, 1e307])
def test_normals_of_objects_far_beyond_float32_overflow_nowhere(size):
    """Cofactors of a sheared and of a flattened matrix: second powers of what has no third power."""
    sheared = np.array([[1.0, 0.5, 0], [0, 1, 0], [0, 0, 1]])
    flat = np.diag([1.0, 1.0, 0.0])
    np.testing.assert_allclose(inverse_transposed(size * sheared) * size, np.linalg.inv(sheared).T)
    np.testing.assert_allclose(np.abs(inverse_transposed(size * flat)), np.diag([0, 0, 1.0]))
