"""The eyes of spherical stereo stand beside the head, and look at the same points."""

import numpy as np
import pytest

from pt_engine.cameras.spherical_stereo import of_eye
from pt_engine.scene.snapshot import Stereo

UP = np.array([[0.0], [1.0], [0.0]], np.float32)


def directions(n=500):
    """Away from the poles, where there is no sideways."""
    d = np.random.default_rng(0).normal(size=(3, n)) * [[1], [0.4], [1]]
    return (d / np.linalg.norm(d, axis=0)).astype(np.float32)


@pytest.mark.parametrize("offset", [-0.3, 0.3])
def test_rays_of_an_eye_meet_those_of_the_middle(offset):
    """offset + t d' = c d for some t > 0; the offset is at right angles to the head's axis and to d."""
    d, c = directions(), 2.5
    start, look = (x.astype(float) for x in of_eye(Stereo(offset, c), d, UP))
    np.testing.assert_allclose(np.linalg.norm(start, axis=0), abs(offset), rtol=1e-5)
    np.testing.assert_allclose((start * UP).sum(axis=0), 0, atol=1e-6)
    np.testing.assert_allclose((start * d).sum(axis=0), 0, atol=1e-6)
    to = c * d - start
    np.testing.assert_allclose(to / np.linalg.norm(to, axis=0), look, atol=1e-6)


def test_the_left_eye_is_the_negative_one():
    """Looking along −Z with +Y up, +X is to the right."""
    forward = np.array([[0.0], [0.0], [-1.0]], np.float32)
    assert of_eye(Stereo(-0.1), forward, UP)[0][0, 0] == pytest.approx(-0.1)


def test_toward_the_poles_the_eyes_come_together():
    """Full up to `merge_from`, none from `merge_to` on, a cosine between."""
    altitude = np.radians([10.0, 50.0, 60.0, 70.0, 80.0])
    d = np.stack([0 * altitude, np.sin(altitude), -np.cos(altitude)]).astype(np.float32)
    eye = Stereo(0.1, merge_from=np.radians(50.0), merge_to=np.radians(70.0))
    size = np.linalg.norm(of_eye(eye, d, UP)[0], axis=0)
    np.testing.assert_allclose(size, 0.1 * np.array([1, 1, np.cos(np.pi / 4), 0, 0]), atol=1e-6)
