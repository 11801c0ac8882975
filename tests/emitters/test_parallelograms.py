"""Two triangles of a quad are one emitter: found, drawn uniformly, as likely as the rays that meet them."""

import numpy as np
import pytest
from support.lamps import density, irradiance, lights, points, up

from pt_engine.emitters.parallelogram import paired
from pt_engine.emitters.triangle import TriangleEmitters


def emitters(corners, order=((0, 1, 2), (0, 2, 3)), radiance=(2.0, 2.0), varies=False):
    """The two halves of a quad with these corners."""
    vertices = np.asarray(corners, np.float32)[np.asarray(order)]
    shine = np.repeat(np.asarray(radiance, np.float32)[:, None], 3, axis=1)
    return TriangleEmitters(vertices, shine, np.full(2, varies), np.full(2, 1e-6, np.float32))


def square(a=1.0, b=0.5, height=1.0):
    return [(0, 0, height), (a, 0, height), (a, b, height), (0, b, height)]


SKEW = [(-1, -0.5, 2), (0.7, -0.9, 2.2), (1.2, 0.4, 1.7), (-0.5, 0.8, 1.5)]


@pytest.mark.parametrize("order", [((0, 1, 2), (0, 2, 3)), ((2, 0, 1), (3, 0, 2)), ((1, 2, 0), (2, 0, 3))])
def test_halves_of_a_quad_are_found_in_any_order_of_their_corners(order):
    assert paired(emitters(square(), order)).tolist() == [[0, 1]]
    assert paired(emitters(SKEW, order)).tolist() == [[0, 1]]


def test_what_is_no_parallelogram_or_shines_unevenly_stays_apart():
    kite = [(0, 0, 1), (1, 0, 1), (1.5, 1.5, 1), (0, 1, 1)]
    assert len(paired(emitters(kite))) == 0
    assert len(paired(emitters(square(), radiance=(2.0, 3.0)))) == 0
    assert len(paired(emitters(square(), varies=True))) == 0


def test_a_strip_of_triangles_gives_each_to_one_pair():
    """Neighbours of a strip all fit: 0-1, 1-2, 2-3, … of which every other is taken."""
    zigzag = np.array([(k / 2, k % 2, 1) for k in range(8)], np.float32)
    vertices = np.stack([zigzag[k : k + 3] for k in range(6)])
    strip = TriangleEmitters(
        vertices, np.ones((6, 3), np.float32), np.zeros(6, bool), np.zeros(6, np.float32)
    )
    assert paired(strip).tolist() == [[0, 1], [2, 3], [4, 5]]


def test_irradiance_below_the_corner_of_a_rectangle():
    """E = L/2 [A/√(1+A²) atan(B/√(1+A²)) + B/√(1+B²) atan(A/√(1+B²))], A, B its sides over its height."""
    a, b = 1.0, 0.5
    of_a, of_b = np.hypot(1, a), np.hypot(1, b)
    expected = a / of_a * np.arctan(b / of_a) + b / of_b * np.arctan(a / of_b)
    estimate, error = irradiance(lights(triangles=emitters(square(a, b))))
    assert abs(estimate - 2.0 / 2 * expected) < 4 * error


def test_density_is_that_of_the_rays_that_meet_its_triangles():
    faces, n = emitters(SKEW), 4000
    scene = lights(triangles=faces)
    assert scene.power.size == 1
    s = scene.sample(points(n), up(n), np.random.default_rng(1).random((3, n), np.float32))
    inside = density(scene, faces, points(n), s.wo)
    # a direction to the common edge may be found by both halves or by none
    agree = np.abs(inside / s.pdf - 1) < 1e-4
    assert agree.mean() > 0.999
    np.testing.assert_allclose(s.weight * s.pdf, 2.0, rtol=1e-5)


def test_points_are_uniform_over_the_area():
    """The point on the quad's plane, in its own coordinates, is the pair of random numbers itself."""
    c, _, _, d = (np.asarray(corner, np.float64) for corner in SKEW)
    e1, e2, n = np.asarray(SKEW[1]) - c, d - c, 2000
    scene = lights(triangles=emitters(SKEW))
    s = scene.sample(points(n), up(n), np.random.default_rng(2).random((3, n), np.float32))
    normal = np.cross(e1, e2)
    x = s.wo * (normal @ c) / (normal @ s.wo)
    found = np.linalg.lstsq(np.stack([e1, e2], axis=1), x - c[:, None], rcond=None)[0]
    for row in found:
        counts = np.histogram(row, bins=10, range=(0, 1))[0]
        assert counts.sum() == n
        assert ((counts - n / 10) ** 2 / (n / 10)).sum() < 33.7  # χ² of 9 degrees: 1 in 10⁴
