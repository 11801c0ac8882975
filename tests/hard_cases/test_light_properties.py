"""Every lamp, camera, warp and table over its whole parameter space."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.lamps import lights, placed, points, up
from support.spaces import ANGLE, EXAMPLES, PLACE, UNIFORMS, WEIGHT, lamps

from pt_engine.cameras.make import CAMERAS, make_camera
from pt_engine.cameras.panoramic import PROJECTIONS
from pt_engine.core import warps
from pt_engine.core.distributions import AliasTable, Distribution2D
from pt_engine.scene.snapshot import CameraData, Stereo


@settings(EXAMPLES, max_examples=120)
@given(lamp=lamps(), place=PLACE)
def test_lamps_are_sampled_as_they_are_met(lamp, place):
    """Finite, pdf ≥ 0; where a ray along the sample meets the lamp, weight · pdf is the radiance it finds.

    The median to 5 %: rays that just miss or graze a lamp differ by rounding. Left out are lamps so far or
    small that float32's directions miss them (half angles below 1e-4), and points within 1e-3 of a lamp's
    centre or of an area lamp's plane.
    """
    scene = lights(lamp)
    s = scene.sample(points(64, place), up(64), UNIFORMS)
    for value in (*s.weight, s.pdf, s.distance):
        assert np.isfinite(value).all()
    assert s.pdf.min() >= 0
    assert s.weight.min() >= 0
    bright = np.flatnonzero((s.weight[0] > 0) & (s.pdf > 0))
    if not bright.size:
        return
    wo = s.wo[:, bright]
    assert np.isfinite(wo).all()
    if s.delta is True or np.median(s.pdf[bright]) > 1e7 or is_degenerate(lamp, place):
        return
    found = list(scene.intersect(points(bright.size, place), wo, np.full(bright.size, np.inf, np.float32)))
    radiance, pdf = np.zeros(bright.size), np.zeros(bright.size)
    for hit in found:
        assert np.isfinite(hit.radiance).all()
        assert np.isfinite(hit.pdf).all()
        radiance[hit.lanes], pdf[hit.lanes] = hit.radiance[0], hit.pdf
    drawn = s.weight[0, bright].astype(float) * s.pdf[bright]
    assert np.quantile(np.abs(pdf / s.pdf[bright] - 1), 0.5) < 0.05
    assert np.quantile(np.abs(radiance / drawn - 1), 0.5) < 0.05


def is_degenerate(lamp, place):
    """Whether the place is the lamp's centre, or lies in an area lamp's plane."""
    away = np.asarray(place) - lamp.matrix[:3, 3]
    axis = lamp.matrix[:3, 2]
    height = abs(away @ axis) / max(np.linalg.norm(axis), 1e-30)
    return np.linalg.norm(away) < 1e-3 or (lamp.kind == "AREA" and height < 1e-3)


EYES = st.builds(
    Stereo,
    st.floats(-1, 1),
    st.sampled_from([1e-5, 0.1, 2.0, 1e6, np.inf]),
    st.floats(0, 1.6),
    st.one_of(st.floats(0, 1.6), st.just(0.0)),
)


@pytest.mark.parametrize("kind", [*CAMERAS])
@EXAMPLES
@given(data=st.data())
def test_camera_rays_are_unit_and_finite(kind, data):
    """Wherever in the image, with any lens, any clip, and either eye."""
    left, bottom = data.draw(st.floats(-3, 1)), data.draw(st.floats(-1.4, 1))
    width, height = data.draw(st.floats(1e-4, 3)), data.draw(st.floats(1e-4, 1.4))
    camera = CameraData(
        kind,
        placed(*data.draw(PLACE), tilt=data.draw(st.floats(0, 6.3))),
        (left, left + width, bottom, bottom + height),
        clip=(
            data.draw(st.sampled_from([0.0, 1e-6, 0.1])),
            data.draw(st.sampled_from([0.0, 100.0, 1e30, np.inf])),
        ),
        aperture_radius=data.draw(st.sampled_from([0.0, 1e-6, 0.1, 10.0])),
        focus_distance=data.draw(st.sampled_from([0.0, 1e-3, 10.0, 1e6])),
        blades=data.draw(st.sampled_from([0, 1, 3, 16])),
        aperture_ratio=data.draw(st.sampled_from([1.0, 0.01, 2.0])),
        panorama=data.draw(st.sampled_from([*PROJECTIONS, "UNKNOWN"])),
        fisheye_fov=data.draw(ANGLE),
        fisheye_polynomial=tuple(data.draw(st.floats(-1, 1)) for _ in range(5)),
        stereo=data.draw(st.none() | EYES) if kind != "ORTHO" else None,
    )
    rays = make_camera(camera, np.zeros(3)).rays(UNIFORMS[:2], UNIFORMS[1:])
    seen = rays.tfar >= 0
    assert np.isfinite(rays.o[:, seen]).all()
    assert not np.isnan(rays.tfar).any()
    np.testing.assert_allclose((rays.d[:, seen].astype(float) ** 2).sum(axis=0), 1, atol=1e-5)


WARPS = {
    "disk": (warps.square_to_disk, warps.disk_to_square, warps.disk_pdf),
    "cosine": (
        warps.square_to_cosine_hemisphere,
        warps.cosine_hemisphere_to_square,
        warps.cosine_hemisphere_pdf,
    ),
    "hemisphere": (warps.square_to_hemisphere, warps.hemisphere_to_square, warps.hemisphere_pdf),
    "sphere": (warps.square_to_sphere, warps.sphere_to_square, warps.sphere_pdf),
    "triangle": (warps.square_to_triangle, warps.triangle_to_square, warps.triangle_pdf),
}
WITHIN = st.floats(0.01, 0.99)


@pytest.mark.parametrize("name", WARPS)
@EXAMPLES
@given(u=WITHIN, v=WITHIN)
def test_warps_are_undone_and_have_a_density(name, u, v):
    """To 1e-3 of the square: roots and arcs near its edges lose half of the digits."""
    forward, back, pdf = WARPS[name]
    u, v = np.array([u], np.float32), np.array([v], np.float32)
    point = forward(u, v)
    assert pdf(point)[0] > 0
    np.testing.assert_allclose(np.concatenate(back(point)), [u[0], v[0]], atol=1e-3)


@EXAMPLES
@given(u=WITHIN, v=WITHIN, corners=st.integers(3, 16), turn=st.floats(-7, 7))
def test_polygons_are_undone_and_have_a_density(u, v, corners, turn):
    """Apertures of any number of blades, turned anyhow: to 1e-3 of the square, away from edges of sectors."""
    u = (np.floor(u * corners) + 0.1 + 0.8 * (u * corners % 1)) / corners
    u, v = np.array([u], np.float32), np.array([0.1 + 0.8 * v], np.float32)
    point = warps.square_to_polygon(u, v, corners, turn)
    area = corners / 2 * np.sin(2 * np.pi / corners)
    np.testing.assert_allclose(warps.polygon_pdf(point, corners, turn) * area, 1, rtol=1e-5)
    np.testing.assert_allclose(
        np.concatenate(warps.polygon_to_square(point, corners, turn)), [u[0], v[0]], atol=1e-3
    )


@EXAMPLES
@given(u=WITHIN, v=WITHIN, size=st.floats(1e-12, 2))
def test_cones_of_any_size_are_undone(u, v, size):
    """1 − cosθ from 1e-12 to 2: u is found again to 1e-3, the density is 1 / 2π(1 − cosθ)."""
    u, v = np.array([u], np.float32), np.array([v], np.float32)
    w = warps.square_to_cone(u, v, np.float32(size))
    np.testing.assert_allclose(warps.cone_pdf(w, np.float32(size)) * 2 * np.pi * size, 1, rtol=1e-5)
    np.testing.assert_allclose(warps.cone_to_square(w, np.float32(size))[0], u, atol=2e-3)


@EXAMPLES
@given(weights=st.lists(WEIGHT, min_size=1, max_size=40))
def test_tables_choose_in_proportion(weights):
    """By 16,384 midpoints: each entry's share to 1e-3, none of weight 0, remainders in [0, 1)."""
    weights, n = np.array(weights), 1 << 14
    table = AliasTable(weights)
    index, rest = table.sample(((np.arange(n) + 0.5) / n).astype(np.float32))
    expected = weights / weights.sum() if weights.any() else np.full(len(weights), 1 / len(weights))
    np.testing.assert_allclose(table.pmf, expected, rtol=1e-6, atol=1e-38)
    share = np.bincount(index, minlength=len(weights)) / n
    np.testing.assert_allclose(share, expected, atol=len(weights) / n + 1e-3)
    assert not weights.any() or (weights[index] > 0).all()
    assert rest.min() >= 0
    assert rest.max() < 1


@EXAMPLES
@given(data=st.data(), rows=st.integers(1, 6), columns=st.integers(1, 6))
def test_images_tell_the_density_of_what_they_draw(data, rows, columns):
    """A density > 0, the same by `pdf` (texels' edges aside), and the mean of 1/density ≤ 1."""
    cells = data.draw(st.lists(WEIGHT, min_size=rows * columns, max_size=rows * columns))
    image = Distribution2D(np.array(cells).reshape(rows, columns))
    x, y, density = image.sample(*UNIFORMS[:2])
    assert density.min() > 0
    assert np.median(np.abs(image.pdf(x, y) / density - 1)) < 1e-5
    assert x.min() >= 0
    assert max(x.max(), y.max()) < 1
