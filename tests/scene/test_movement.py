"""Matrices, shapes, cameras and times between the steps that are known."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from support import scenes as make
from support.motion import moving

from pt_engine.scene.matrix_path import MatrixPath
from pt_engine.scene.movement import Movement, beside, moving_last, some_instances
from pt_engine.scene.shutter import Shutter


def matrix(linear=None, place=(0, 0, 0)):
    m = np.eye(4)
    m[:3, :3] = np.eye(3) if linear is None else linear
    m[:3, 3] = place
    return m


def turned(angle, axis):
    """Rodrigues' rotation by an angle about a unit axis."""
    x, y, z = axis
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def path(*steps):
    return MatrixPath.of(np.array([steps]))


AXIS = np.array([1, 2, -2]) / 3


def test_at_its_steps_a_path_gives_the_very_matrices():
    """Shear, mirrors and all; a few roundings of float64."""
    steps = np.random.default_rng(0).normal(size=(40, 5, 4, 4))
    steps[..., 3, :] = 0, 0, 0, 1
    whole = MatrixPath.of(steps)
    for k in range(5):
        np.testing.assert_allclose(whole.at(k / 4), steps[:, k], atol=1e-11)


@pytest.mark.parametrize("angle", [1e-3, 0.7, 3.0])
def test_a_turn_has_a_constant_pace(angle):
    """A quarter of the time, a quarter of the angle, between steps that are 3 apart."""
    found = path(matrix(turned(-angle, AXIS)), matrix(), matrix(turned(angle, AXIS)))
    for time in (0, 0.125, 0.6, 1):
        expected = turned((2 * time - 1) * angle, AXIS)
        np.testing.assert_allclose(found.at(time)[0, :3, :3], expected, atol=1e-12 + 1e-9 * angle)


def test_a_turn_of_exactly_pi_is_a_turn_about_its_axis():
    """Either way round: half of it is ±π/2."""
    half = path(matrix(), matrix(turned(np.pi, AXIS))).at(0.5)[0, :3, :3]
    np.testing.assert_allclose(np.trace(half), 1, atol=1e-12)  # 1 + 2 cos(π/2)
    np.testing.assert_allclose(half @ AXIS, AXIS, atol=1e-12)


def test_a_turn_of_more_than_pi_between_two_steps_goes_the_short_way():
    """As in every renderer that knows only the steps: more steps make it right."""
    found = path(matrix(), matrix(turned(1.5 * np.pi, AXIS))).at(0.5)[0, :3, :3]
    np.testing.assert_allclose(found, turned(-0.25 * np.pi, AXIS), atol=1e-12)


def test_a_mirrored_object_stays_mirrored():
    flip = np.diag([-1.0, 1, 1])
    found = path(matrix(flip), matrix(turned(1.0, AXIS) @ flip))
    for time in np.linspace(0, 1, 9):
        np.testing.assert_allclose(np.linalg.det(found.at(time)[0, :3, :3]), -1, rtol=1e-12)


def test_a_scale_to_nothing_keeps_its_rotation_on_the_way():
    """Where nothing is left there is no rotation: the neighbour's is taken."""
    r = turned(2.0, AXIS)
    found = path(matrix(r), matrix(np.zeros((3, 3))))
    np.testing.assert_allclose(found.at(0.75)[0, :3, :3], 0.25 * r, atol=1e-12)


def test_an_axis_that_passes_through_nothing_stays_finite():
    steps = [matrix(np.diag([s, 1.0, 1.0])) for s in (1.0, 0.0, -1.0)]
    for time in np.linspace(0, 1, 21):
        assert np.isfinite(path(*steps).at(time)).all()
    np.testing.assert_allclose(path(*steps).at(0.25)[0, :3, :3], np.diag([0.5, 1, 1]), atol=1e-12)


def test_what_is_not_finite_makes_no_noise():
    steps = [matrix(np.full((3, 3), np.nan)), matrix(np.eye(3) * 1e200)]
    path(*steps).at(0.5)


@pytest.mark.parametrize(
    "curve", [[1, 1], [0, 1, 0], [0, 0, 1, 0, 0.3], [0.2, 0.2, 5, 0.1], [1e-9, 1], [3, 0, 0, 3]]
)
def test_times_have_the_curve_as_their_density(curve):
    """F(t(u)) = u with F by quadrature of the piecewise linear curve; exact within the rule's 1e-6."""
    shutter, knots = Shutter(np.array(curve)), np.linspace(0, 1, len(curve))
    t = np.linspace(0, 1, 200_001)
    density = np.interp(t, knots, curve)
    cumulative = np.concatenate([[0], np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(t))])
    u = np.linspace(0, 1, 101)[:-1] + 1e-3
    times = np.array([shutter.time(x) for x in u])
    assert (np.diff(times) >= 0).all()
    np.testing.assert_allclose(np.interp(times, t, cumulative / cumulative[-1]), u, atol=1e-5)


@pytest.mark.parametrize("curve", [[0, 0, 0], [np.nan, np.inf], [-1, -2]])
def test_a_shutter_that_never_opens_is_taken_as_open(curve):
    assert [Shutter(np.array(curve)).time(u) for u in (0, 0.25, 1)] == [0, 0.25, 1]


def snapshot():
    camera = make.perspective((0, -5, 0), (0, 0, 0))
    grey = make.diffuse(0.5)
    return make.scene([(make.quad(), make.translation(k, 0, 0), grey) for k in range(4)], camera)


def test_those_that_move_come_last_and_keep_their_rows():
    rows = {0: [make.translation(0, 0, z) for z in (0, 1)], 2: [make.translation(2, 0, z) for z in (0, 1, 3)]}
    shape = np.stack([make.quad().vertices] * 2)
    ordered = moving_last(moving(snapshot(), rows, {3: shape}))
    assert ordered.instances.names == ("object 1", "object 0", "object 2", "object 3")
    movement = Movement(ordered, ordered.motion)
    assert movement.first == 1
    found = movement.instances(0.75)
    np.testing.assert_allclose(found.matrix[:, :3, 3], [[0, 0, 0.75], [2, 0, 2], [3, 0, 0]], atol=1e-12)
    assert found.names == ("object 0", "object 2", "object 3")


def test_some_instances_have_every_field():
    every = replace(
        snapshot().instances,
        attributes={"object:a": np.arange(16, dtype=np.float32).reshape(4, 4)},
        terminator=np.linspace(0, 1, 4, dtype=np.float32),
        shading_offset=np.linspace(0, 1, 4, dtype=np.float32),
        light_group=np.arange(4, dtype=np.int32),
    )
    some = some_instances(every, np.array([2, 0]))
    for field in fields(every):
        whole, part = getattr(every, field.name), getattr(some, field.name)
        if isinstance(whole, dict):
            whole, part = whole["object:a"], part["object:a"]
        assert len(part) == 2
        np.testing.assert_array_equal(part, [whole[2], whole[0]])


def test_an_eye_moves_along_with_its_camera():
    """It stays where it is in the camera's space, and as many image widths to the side."""
    frames = [replace(make.perspective((x, -5, 0), (0, 0, 0)), frame=(-w, w, -w, w)) for x, w in
              ((-1, 0.4), (0, 0.5), (1, 0.6))]  # fmt: skip
    eye = replace(
        frames[1], matrix=frames[1].matrix @ make.translation(0.03, 0, 0), frame=(-0.45, 0.55, -0.5, 0.5)
    )
    moved = beside(tuple(frames), frames[1], eye)
    np.testing.assert_allclose(moved[1].matrix, eye.matrix, atol=1e-15)
    np.testing.assert_allclose(moved[1].frame, eye.frame, atol=1e-15)
    for camera, own in zip(moved, frames, strict=True):
        np.testing.assert_allclose(
            np.linalg.inv(own.matrix) @ camera.matrix, make.translation(0.03, 0, 0), atol=1e-12
        )
    np.testing.assert_allclose(moved[2].frame, (-0.54, 0.66, -0.6, 0.6), atol=1e-12)
