"""Panoramas: angles, solid angles and image circles in closed form."""

import numpy as np
import pytest

from pt_engine.cameras import make_camera
from pt_engine.scene.snapshot import CameraData

rng = np.random.default_rng(5)
W, H = 300, 200
TURN = 2 * np.pi
POLYNOMIAL = (-0.01, -0.06, 0.001, 2e-5, -1e-6)
FRAMES = {
    "EQUIRECTANGULAR": (-2.0, 3.0, -1.2, 1.5),
    "CENTRAL_CYLINDRICAL": (-2.0, 3.0, -2.0, 1.0),
    "EQUIANGULAR_CUBEMAP_FACE": (-np.pi / 4, np.pi / 4, -np.pi / 4, np.pi / 4),
    "FISHEYE_EQUIDISTANT": (-1.5, 1.5, -1.2, 1.2),
    "FISHEYE_EQUISOLID": (-1.2, 1.0, -1.0, 1.3),
    "MIRRORBALL": (-2.0, 2.0, -2.0, 2.0),
    "FISHEYE_LENS_POLYNOMIAL": (-18.0, 18.0, -12.0, 12.0),
}
FISHEYES = [kind for kind in FRAMES if "FISHEYE" in kind or kind == "MIRRORBALL"]


def panorama(kind, turned=False, **more):
    matrix = np.eye(4)
    if turned:
        q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        matrix[:3, :3] = q * np.sign(np.linalg.det(q))
    fov = TURN if kind == "MIRRORBALL" else 3.0
    fisheye = {"fisheye_fov": fov, "fisheye_polynomial": POLYNOMIAL}
    given = {"frame": FRAMES[kind], "clip": (0.25, 50.0), **fisheye}
    return CameraData("PANO", matrix, panorama=kind, **{**given, **more})


def camera(data, size=(W, H)):
    return make_camera(data, np.zeros(3), size)


def raster(n=3000):
    return (rng.random((2, n)) * [[W], [H]]).astype(np.float32)


def frame_of(data, r):
    left, right, bottom, top = data.frame
    return np.stack([left + r[0] / W * (right - left), bottom + r[1] / H * (top - bottom)]).astype(float)


def local(data, vectors):
    """World to right, up, forward in float64."""
    return data.matrix[:3, :3].T @ vectors.astype(float) * [[1], [1], [-1]]


def looks(data, x, y):
    """Directions (right, up, forward) of points of the frame, in float64 from the engine's float32."""
    left, right, bottom, top = data.frame
    r = np.stack([(x - left) / (right - left), (y - bottom) / (top - bottom)]).astype(np.float32)
    return local(data, camera(data, (1, 1)).rays(r).d)


def angle(d):
    return np.arctan2(np.hypot(d[0], d[1]), d[2])


INVERSE_RADIUS = {
    "FISHEYE_EQUIDISTANT": lambda theta: theta,
    "FISHEYE_EQUISOLID": lambda theta: 2 * np.sin(theta / 2),
    "MIRRORBALL": lambda theta: 2 * np.sin(theta / 2),
}


def back(kind, d):
    """Where in the frame a direction is seen: the inverse, written independently."""
    longitude = np.arctan2(d[0], d[2])
    if kind == "EQUIRECTANGULAR":
        return np.stack([longitude, np.arcsin(d[1])])
    if kind == "CENTRAL_CYLINDRICAL":
        return np.stack([longitude, d[1] / np.hypot(d[0], d[2])])
    if kind == "EQUIANGULAR_CUBEMAP_FACE":
        return np.arctan2(d[:2], d[2])
    return INVERSE_RADIUS[kind](angle(d)) * d[:2] / np.hypot(d[0], d[1])


@pytest.mark.parametrize("kind", [kind for kind in FRAMES if "POLYNOMIAL" not in kind])
def test_pixels_and_directions_are_inverse(kind):
    data = panorama(kind, turned=True)
    r = raster()
    rays = camera(data).rays(r)
    seen = rays.tfar > 0
    assert seen.mean() > 0.5
    found = back(kind, local(data, rays.d[:, seen]))
    np.testing.assert_allclose(found, frame_of(data, r[:, seen]), atol=2e-5)


@pytest.mark.parametrize("kind", FRAMES)
def test_directions_are_unit_and_every_ray_stands_alone(kind):
    for radius in (0.0, 0.1):
        data = panorama(kind, turned=True, aperture_radius=radius, blades=5)
        r, u = raster(1001), rng.random((2, 1001), np.float32)
        many, few = camera(data).rays(r, u), camera(data).rays(r[:, 7:9].copy(), u[:, 7:9].copy())
        for a, b in zip(many, few, strict=True):
            assert a.dtype == np.float32
            np.testing.assert_array_equal(a[..., 7:9], b)
        np.testing.assert_allclose(np.linalg.norm(many.d.astype(float), axis=0), 1, atol=4e-7)


SOLID_ANGLE = {
    "EQUIRECTANGULAR": lambda x, y: np.cos(y),
    "CENTRAL_CYLINDRICAL": lambda x, y: (1 + y * y) ** -1.5,
    "EQUIANGULAR_CUBEMAP_FACE": lambda x, y: (
        (np.cos(x) * np.cos(y)) ** -2 * (1 + np.tan(x) ** 2 + np.tan(y) ** 2) ** -1.5
    ),
    "FISHEYE_EQUIDISTANT": lambda x, y: np.sinc(np.hypot(x, y) / np.pi),
    "FISHEYE_EQUISOLID": lambda x, y: np.ones_like(x),
    "MIRRORBALL": lambda x, y: np.ones_like(x),
}


@pytest.mark.parametrize("kind", SOLID_ANGLE)
def test_solid_angle_per_area(kind):
    """|∂d/∂x × ∂d/∂y|, by central differences of float32 directions (error about h² + 1e-7/h)."""
    data, h = panorama(kind), 0.01
    x, y = rng.uniform(-0.75, 0.75, (2, 500))
    dx = (looks(data, x + h, y) - looks(data, x - h, y)) / (2 * h)
    dy = (looks(data, x, y + h) - looks(data, x, y - h)) / (2 * h)
    area = np.linalg.norm(np.cross(dx.T, dy.T), axis=1)
    np.testing.assert_allclose(area, SOLID_ANGLE[kind](x, y), atol=4e-4)


def test_whole_sphere_in_an_equirectangular_image():
    """Centre: forward; left and right edge: backward; a quarter to the right: right; top: up."""
    data = panorama("EQUIRECTANGULAR", frame=(-np.pi, np.pi, -np.pi / 2, np.pi / 2))
    d = local(data, camera(data).rays(np.float32([[150, 0, 300, 225, 80], [100, 100, 100, 100, 200]])).d)
    expected = [[0, 0, 1], [0, 0, -1], [0, 0, -1], [1, 0, 0], [0, 1, 0]]
    np.testing.assert_allclose(d.T, expected, atol=1e-6)


def test_polynomial_gives_the_angle():
    """θ = −Σ kᵢ rⁱ; with k₁ alone it is the equidistant fisheye of focal length −1/k₁."""
    data = panorama("FISHEYE_LENS_POLYNOMIAL")
    r = raster()
    rays = camera(data).rays(r)
    radius = np.hypot(*frame_of(data, r))
    theta = -sum(k * radius**n for n, k in enumerate(POLYNOMIAL))
    np.testing.assert_array_equal(rays.tfar > 0, np.abs(theta) <= 1.5)
    seen = rays.tfar > 0
    np.testing.assert_allclose(angle(local(data, rays.d))[seen], np.abs(theta)[seen], atol=1e-6)
    linear = panorama("FISHEYE_LENS_POLYNOMIAL", fisheye_polynomial=(0.0, -0.1, 0.0, 0.0, 0.0))
    scaled = panorama("FISHEYE_EQUIDISTANT", frame=tuple(x / 10 for x in linear.frame))
    np.testing.assert_allclose(camera(linear).rays(r).d, camera(scaled).rays(r).d, atol=1e-6)


def test_mirror_ball_reflects():
    """The ball of radius 1 fills (−2, 2)²; its normal is half way between the view axis and the direction."""
    data = panorama("MIRRORBALL")
    r = raster()
    rays = camera(data).rays(r)
    plane = frame_of(data, r) / 2
    np.testing.assert_array_equal(rays.tfar > 0, np.hypot(*plane) <= 1)
    half = local(data, rays.d) + [[0], [0], [1]]
    half /= np.linalg.norm(half, axis=0)
    inside = np.hypot(*plane) < 0.99
    np.testing.assert_allclose(half[:2, inside], plane[:, inside], atol=1e-5)


@pytest.mark.parametrize("kind", FISHEYES)
def test_outside_of_the_circle_there_is_no_ray(kind):
    """A square frame that the circle just fits: π/4 of the image sees, at most fov/2 from the axis."""
    fov = {"MIRRORBALL": TURN, "FISHEYE_LENS_POLYNOMIAL": 2.0}.get(kind, 3.0)
    edge = INVERSE_RADIUS.get(kind, lambda theta: 10 * theta)(fov / 2)
    linear = (0.0, -0.1, 0.0, 0.0, 0.0)
    data = panorama(kind, frame=(-edge, edge, -edge, edge), fisheye_fov=fov, fisheye_polynomial=linear)
    centres = (np.stack(np.meshgrid(np.arange(400), np.arange(400))).reshape(2, -1) + 0.5).astype(np.float32)
    rays = camera(data, (400, 400)).rays(centres)
    seen = rays.tfar > 0
    assert seen.mean() == pytest.approx(np.pi / 4, abs=1e-3)
    assert (rays.tfar[~seen] == -1).all()
    assert all(np.isfinite(part).all() for part in rays)
    theta = angle(local(data, rays.d[:, seen]))
    assert theta.max() < fov / 2 + 1e-6
    assert theta.max() > fov / 2 - (0.15 if kind == "MIRRORBALL" else 0.02)  # steep at the ball's rim


@pytest.mark.parametrize("kind", FISHEYES)
def test_the_very_centre_looks_ahead(kind):
    """Where no side of the axis is the first, a lens has no x-axis, but still a ray."""
    data = panorama(kind, frame=(-1.0, 1.0, -1.0, 1.0), fisheye_polynomial=(0.0, -0.1, 0.0, 0.0, 0.0))
    lens = CameraData(**{**vars(data), "aperture_radius": 0.1})
    r, u = np.float32([[150.0], [100.0]]), np.float32([[0.2], [0.7]])
    np.testing.assert_array_equal(local(data, camera(data).rays(r).d)[:, 0], [0, 0, 1])
    np.testing.assert_allclose(local(lens, camera(lens).rays(r, u).d)[2], 1, atol=1e-3)


def test_clipping_is_by_distance_from_the_eye():
    data = panorama("EQUIRECTANGULAR", turned=True)
    rays = camera(data).rays(raster())
    np.testing.assert_allclose(np.linalg.norm(rays.o, axis=0), 0.25, rtol=1e-6)
    np.testing.assert_allclose(rays.tfar, 49.75)


@pytest.mark.parametrize("kind", ["EQUIRECTANGULAR", "FISHEYE_EQUISOLID", "MIRRORBALL"])
def test_lens_faces_each_direction(kind):
    """All rays of a pixel meet at the focus distance from the eye and start on a disk across the middle ray.

    Its width, divided by the ratio, lies in the plane of d and the first axis (E x² = R²/4 on a disk, 5 σ).
    """
    focus, radius, ratio, n = 3.0, 0.2, 2.0, 40_000
    lens = {"aperture_radius": radius, "focus_distance": focus, "aperture_ratio": ratio, "clip": (0.0, 50.0)}
    data = panorama(kind, turned=True, **lens)
    r = np.repeat(np.float32([[201.0], [70.0]]), n, axis=1)
    rays = camera(data).rays(r, rng.random((2, n), np.float32))
    middle = local(data, camera(data).rays(r[:, :1]).d)
    o, d = local(data, rays.o), local(data, rays.d)
    reach = focus * middle - o
    np.testing.assert_allclose(np.cross(reach.T, d.T), 0, atol=2e-6)
    np.testing.assert_allclose(middle[:, 0] @ o, 0, atol=1e-6)
    axis = np.eye(3)[0 if kind == "MIRRORBALL" else 2]
    u = axis - (axis @ middle[:, 0]) * middle[:, 0]
    u /= np.linalg.norm(u)
    x, y = u @ o, np.cross(middle[:, 0], u) @ o
    tolerance = 5 * 0.3 / np.sqrt(n)
    assert (x**2).mean() / radius**2 == pytest.approx(0.25 / ratio**2, abs=tolerance)
    assert (y**2).mean() / radius**2 == pytest.approx(0.25, abs=tolerance)
    assert (x * y).mean() / radius**2 == pytest.approx(0, abs=tolerance)


def test_an_unknown_projection_is_equirectangular():
    known = panorama("EQUIRECTANGULAR")
    r = raster(100)
    unknown = CameraData(**{**vars(known), "panorama": "NEWER"})
    np.testing.assert_array_equal(camera(unknown).rays(r).d, camera(known).rays(r).d)
