"""Where rays go: projected points, clipping planes, and circles of confusion in closed form."""

import numpy as np
import pytest

from pt_engine.cameras import make_camera
from pt_engine.scene.snapshot import CameraData

rng = np.random.default_rng(11)
W, H = 640, 360


def placed(**changes):
    """A camera at a place and turn of its own, in a world far from 0."""
    angles = rng.uniform(-np.pi, np.pi, 3)
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)) + np.diag(angles))
    q *= np.sign(np.linalg.det(q))
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = q, [1000.25, -2000.5, 300.125]
    given = {"kind": "PERSP", "matrix": matrix, "frame": (-0.6, 0.5, -0.3, 0.28), "clip": (0.1, 50.0)}
    return CameraData(**{**given, **changes})


ORIGIN = np.array([1000.0, -2000.0, 300.0])


def raster(n=2000):
    return (rng.random((2, n)) * [[W], [H]]).astype(np.float32)


def to_camera(data, points):
    """World (recentred) to the camera's right, up, forward, in float64."""
    local = data.matrix[:3, :3].T @ (points + (ORIGIN - data.matrix[:3, 3])[:, None])
    return local * [[1], [1], [-1]]


def frame_of(data, r):
    left, right, bottom, top = data.frame
    return np.stack([left + r[0] / W * (right - left), bottom + r[1] / H * (top - bottom)]).astype(float)


def at_depth(data, rays, depth):
    o, d = to_camera(data, rays.o.astype(float)), data.matrix[:3, :3].T @ rays.d * [[1], [1], [-1]]
    return (o + d * (depth - o[2]) / d[2])[:2]


def test_perspective_projects_as_a_pinhole():
    """At depth z a ray is at z times its point of the frame; it starts at near and ends at far."""
    data = placed()
    r = raster()
    rays = make_camera(data, ORIGIN, (W, H)).rays(r)
    for depth in (0.1, 1.0, 50.0):
        expected = depth * frame_of(data, r)
        np.testing.assert_allclose(at_depth(data, rays, depth), expected, atol=1e-6 * (1 + depth))
    np.testing.assert_allclose(np.linalg.norm(rays.d.astype(float), axis=0), 1, atol=3e-7)
    np.testing.assert_allclose(to_camera(data, rays.o.astype(float))[2], 0.1, atol=1e-6)
    np.testing.assert_allclose(to_camera(data, rays.o + rays.d * rays.tfar.astype(float))[2], 50, rtol=1e-5)
    assert all(a.dtype == np.float32 for a in rays)


def test_orthographic_rays_are_parallel():
    data = placed(kind="ORTHO", frame=(-4.0, 3.0, -1.0, 2.0))
    r = raster()
    rays = make_camera(data, ORIGIN, (W, H)).rays(r)
    for depth in (0.1, 30.0):
        np.testing.assert_allclose(at_depth(data, rays, depth), frame_of(data, r), atol=1e-5)
    np.testing.assert_allclose(to_camera(data, rays.o.astype(float))[2], 0.1, atol=1e-6)
    np.testing.assert_allclose(to_camera(data, rays.o + rays.d * rays.tfar.astype(float))[2], 50, rtol=1e-5)


def test_corners_and_crop():
    """Raster (0, 0) is the frame's left bottom, (W, H) its right top; the unit raster is the same image."""
    data = placed()
    corners = np.array([[0, W], [0, H]], np.float32)
    camera = make_camera(data, ORIGIN)
    full = camera.at_resolution(W, H).rays(corners)
    np.testing.assert_allclose(at_depth(data, full, 1.0), [[-0.6, 0.5], [-0.3, 0.28]], atol=1e-6)
    unit = camera.rays(corners / np.float32([[W], [H]]))
    np.testing.assert_array_equal(unit.d, full.d)


@pytest.mark.parametrize(
    ("kind", "blades", "ratio"), [("PERSP", 0, 1.0), ("PERSP", 5, 2.0), ("ORTHO", 0, 1.5)]
)
def test_lens_focuses_and_blurs_by_the_circle_of_confusion(kind, blades, ratio):
    """All lens points meet at depth f; at depth z they fill the aperture scaled by |1 − z/f|.

    A uniform disk of radius R has E x² = R²/4; a regular n-gon R² (2 + cos 2π/n) / 12 (5 σ, 2σ² = E x⁴).
    """
    radius, focus = 0.05, 4.0
    lens = {"aperture_radius": radius, "blades": blades, "aperture_ratio": ratio}
    data = placed(kind=kind, focus_distance=focus, **lens)
    n = 100_000
    r = np.repeat(np.float32([[123.0], [45.0]]), n, axis=1)
    camera = make_camera(data, ORIGIN, (W, H))
    assert camera.has_lens
    rays = camera.rays(r, rng.random((2, n), np.float32))
    sharp = frame_of(data, r) * (focus if kind == "PERSP" else 1.0)
    np.testing.assert_allclose(at_depth(data, rays, focus), sharp, atol=2e-5)
    second_moment = (2 + np.cos(2 * np.pi / blades)) / 12 if blades else 0.25
    for depth in (1.0, 2.0, 9.0):
        centre = frame_of(data, r) * (depth if kind == "PERSP" else 1.0)
        blur = (at_depth(data, rays, depth) - centre) / (radius * abs(1 - depth / focus))
        blur[0] *= ratio
        assert np.hypot(*blur).max() < 1 + 1e-3
        np.testing.assert_allclose((blur**2).mean(1), second_moment, atol=5 * 0.3 / np.sqrt(n))
        np.testing.assert_allclose(blur.mean(1), 0, atol=5 * 0.5 / np.sqrt(n))
    np.testing.assert_allclose(np.linalg.norm(rays.d.astype(float), axis=0), 1, atol=3e-7)


def test_lens_clipping_is_along_the_ray():
    """Rays of one raster point start `near · slant` from the lens and are (far − near) · slant long."""
    data = placed(aperture_radius=0.5, focus_distance=1.0, clip=(0.2, 10.0))
    r = raster()
    rays = make_camera(data, ORIGIN, (W, H)).rays(r, rng.random((2, 2000), np.float32))
    slant = np.sqrt((frame_of(data, r) ** 2).sum(0) + 1)
    np.testing.assert_allclose(rays.tfar, 9.8 * slant, rtol=1e-6)
    lens = to_camera(data, rays.o - rays.d * (0.2 * slant))
    np.testing.assert_allclose(lens[2], 0, atol=1e-6)
    assert np.hypot(*lens[:2]).max() < 0.5 + 1e-6


def test_orthographic_lens_starts_on_the_near_plane():
    data = placed(kind="ORTHO", frame=(-4.0, 3.0, -1.0, 2.0), aperture_radius=0.5, clip=(0.2, 10.0))
    rays = make_camera(data, ORIGIN, (W, H)).rays(raster(), rng.random((2, 2000), np.float32))
    np.testing.assert_allclose(to_camera(data, rays.o.astype(float))[2], 0.2, atol=2e-6)


def test_blade_rotation_turns_the_polygon():
    """Two blades count as round; with 4 the farthest points lie at rotation ± 45°."""
    base = {"aperture_radius": 1.0, "focus_distance": 1.0}
    u = rng.random((2, 50_000), np.float32)
    square = make_camera(placed(**base, blades=4, blade_rotation=0.3), ORIGIN)._aperture.sample(u)
    angle = np.arctan2(square[1], square[0])[np.hypot(*square) > 0.97]
    off = (angle - 0.3 - np.pi / 4) % (np.pi / 2)
    assert (np.minimum(off, np.pi / 2 - off) < 0.1).all()
    two = make_camera(placed(**base, blades=2), ORIGIN)._aperture.sample(u)
    np.testing.assert_array_equal(two, make_camera(placed(**base), ORIGIN)._aperture.sample(u))


def test_pinhole_has_no_lens_and_a_scaled_matrix_does_not_matter():
    data = placed()
    camera = make_camera(data, ORIGIN, (W, H))
    assert not camera.has_lens
    matrix = data.matrix.copy()
    matrix[:3, :3] *= 3.0
    other = make_camera(CameraData(**{**vars(data), "matrix": matrix}), ORIGIN, (W, H))
    r = raster()
    np.testing.assert_allclose(camera.rays(r).d, other.rays(r).d, atol=1e-6)


def test_a_ray_depends_on_its_own_numbers_only():
    for kind in ("PERSP", "ORTHO"):
        for radius in (0.0, 0.3):
            camera = make_camera(placed(kind=kind, aperture_radius=radius, blades=6), ORIGIN, (W, H))
            r, u = raster(1001), rng.random((2, 1001), np.float32)
            many, few = camera.rays(r, u), camera.rays(r[:, 7:9].copy(), u[:, 7:9].copy())
            for a, b in zip(many, few, strict=True):
                np.testing.assert_array_equal(a[..., 7:9], b)


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_a_footprint_is_what_one_pixel_changes(kind):
    """Mean of |∂/∂x| and |∂/∂y| of direction and origin per pixel, here by differences over 4 pixels."""
    data = placed(kind=kind, clip=(0.5, 50.0))
    camera, r = make_camera(data, ORIGIN, (W, H)), raster()
    radius, spread = camera.footprint(camera.rays(r).d)
    slopes = []
    for part in ("o", "d"):
        pairs = [
            [
                getattr(camera.rays(r + np.float32(s) * np.array(step, np.float32)), part).astype(float)
                for s in (-2, 2)
            ]
            for step in ([[1], [0]], [[0], [1]])
        ]
        slopes.append(sum(np.linalg.norm(after - before, axis=0) for before, after in pairs) / 8)
    np.testing.assert_allclose(spread, slopes[1], rtol=1e-3, atol=1e-6)
    if kind == "ORTHO":
        np.testing.assert_allclose(radius, slopes[0], rtol=1e-3)
    else:  # Cycles lets the cone start as narrow as the ray's way to the near plane has made it
        slant = np.linalg.norm(camera.rays(r).o.astype(float) - camera._eye, axis=0)
        np.testing.assert_allclose(radius, spread * slant, rtol=1e-4)
    assert radius.dtype == spread.dtype == np.float32
