"""Mesh lights, skies and the choice among many lights over their whole parameter spaces."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from support.lamps import density, floor, lights, points, texel_directions, up
from support.spaces import EXAMPLES, UNIFORMS, WEIGHT, lamps

from pt_engine.core.pixel_filters import FILTERS, FilterTable
from pt_engine.emitters.environment import EnvironmentMap
from pt_engine.emitters.many import Surfaces
from pt_engine.emitters.triangle import TriangleEmitters
from pt_engine.scene.accel import Accel

SMALL = 1e-3  # of what makes a triangle seen from the origin one that rays in float32 can be aimed at
CORNER = st.tuples(*[st.one_of(st.floats(-3, 3), st.sampled_from([0.0, 1e-7, 1e4]))] * 3)
SHINE = st.tuples(*[st.one_of(st.floats(0, 5), st.sampled_from([0.0, 1e-30, 1e30, -2.0]))] * 3)


@EXAMPLES
@given(st.lists(st.tuples(CORNER, CORNER, CORNER, SHINE), min_size=1, max_size=4))
def test_mesh_lights_are_sampled_as_they_are_met(faces):
    """Finite, pdf ≥ 0, weight · pdf is some triangle's radiance, and rays that meet it are told that pdf.

    The median to 5 %, for triangles of a millionth of a sphere or more that are not seen edge-on.
    """
    corners = np.array([face[:3] for face in faces], np.float32)
    radiance = np.array([face[3] for face in faces], np.float32)
    emitters = TriangleEmitters(
        corners, radiance, np.zeros(len(faces), bool), np.full(len(faces), 1e-6, np.float32)
    )
    scene = lights(triangles=emitters)
    s = scene.sample(points(64), up(64), UNIFORMS)
    assert all(np.isfinite(value).all() for value in (*s.weight, s.pdf, s.distance))
    assert s.pdf.min() >= 0
    sampled = np.flatnonzero((s.pdf > 0) & np.any(s.weight != 0, axis=0))
    if not sampled.size or not well_seen(corners):
        return
    found = s.weight[:, sampled].astype(float) * s.pdf[sampled]
    miss = np.abs(found[:, :, None] - radiance.T[:, None, :]) <= 1e-4 * np.abs(radiance.T[:, None, :])
    assert miss.all(axis=0).any(axis=1).all()
    pdf = density(scene, emitters, points(sampled.size), s.wo[:, sampled])
    assert np.quantile(np.abs(pdf / s.pdf[sampled] - 1), 0.5) < 0.05


def well_seen(corners) -> bool:
    """Whether all triangles are large enough, and lie in no plane through the origin."""
    d = corners.astype(float)
    normal = np.cross(d[:, 1] - d[:, 0], d[:, 2] - d[:, 0])
    size, edge = np.linalg.norm(normal, axis=1), np.abs(d).max(axis=(1, 2))
    height = np.abs((normal * d[:, 0]).sum(axis=1)) / np.maximum(size, 1e-30)
    return bool((size > SMALL * edge**2).all() and (height > SMALL * edge).all())


@EXAMPLES
@given(data=st.data(), rows=st.integers(1, 6))
def test_skies_are_sampled_as_they_are_met(data, rows):
    """Of any image: finite, pdf > 0, the same pdf for rays that leave, weight · pdf = Le, ∫ pdf = 1."""
    columns = 2 * rows
    cells = data.draw(st.lists(WEIGHT, min_size=rows * columns, max_size=rows * columns))
    image = np.array(cells, np.float32).reshape(rows, columns)

    def radiance(d):
        row = ((1 - np.arccos(np.clip(d[2], -1, 1)) / np.pi) * rows).astype(int).clip(0, rows - 1)
        column = ((0.5 - np.arctan2(d[1], d[0]) / (2 * np.pi)) * columns).astype(int) % columns
        return np.repeat(image[row, column][None], 3, axis=0)

    scene = lights(environment=EnvironmentMap(image, radiance))
    s = scene.sample(points(64), up(64), UNIFORMS)
    assert np.isfinite(s.wo).all()
    assert np.isfinite(s.weight).all()
    assert s.pdf.min() > 0
    pdf, expected = scene.environment_pdf(s.wo), radiance(s.wo)[0].astype(float)
    assert np.median(np.abs(pdf / s.pdf - 1)) < 1e-4
    assert (
        np.median(np.abs(s.weight[0].astype(float) * s.pdf - expected) / np.maximum(expected, 1e-30)) < 1e-4
    )
    d = texel_directions(64 * rows, 128 * rows)
    solid = np.repeat(np.diff(-np.cos(np.pi * np.arange(64 * rows + 1) / (64 * rows))), 128 * rows)
    whole = (scene.environment_pdf(d) * solid).sum() * 2 * np.pi / (128 * rows)
    assert abs(whole - 1) < 0.02


@settings(EXAMPLES, max_examples=12)
@given(st.lists(lamps(), min_size=8, max_size=16), st.booleans())
def test_the_choice_among_many_is_a_probability(some, opaque):
    """Σ pmf = 1 anywhere, each > 0, samples finite; of any lamps over a floor."""
    scene = lights(*some, surfaces=Surfaces(*floor(), opaque, Accel))
    choice, count = scene.by_place, len(scene.power)
    if choice is None:
        return
    for position in ((0.1, 0.2, 0.0), (-2.9, 2.9, 0.0), (40.0, 0.0, -7.0)):
        place = choice.place(points(max(64, count), position), up(max(64, count)))
        pmf = choice.ratio(place[:count], np.arange(count)).astype(np.float64) * scene.chance
        assert abs(pmf.sum() - 1) < 1e-5
        assert pmf.min() > 0
        s = scene.sample(points(64, position), up(64), UNIFORMS)
        assert np.isfinite(s.weight).all()
        assert np.isfinite(s.pdf).all()


@EXAMPLES
@given(kind=st.sampled_from(sorted(FILTERS)), width=st.one_of(st.floats(0.01, 10), st.just(1e-6)))
def test_pixel_filters_stay_within_their_width(kind, width):
    """Finite, growing with u, symmetric: the median is the pixel's middle."""
    u = np.linspace(0, 1 - 2**-24, 1001).astype(np.float32)
    x = FilterTable(kind, width).sample(u)
    assert np.isfinite(x).all()
    assert (np.diff(x) >= 0).all()
    assert np.abs(x + x[::-1]).max() <= 1e-4 * max(width, 1e-3) + 1e-6
